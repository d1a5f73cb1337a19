"""Arrays in any order and of any number type are read by their indices, or refused."""

from __future__ import annotations

import numpy as np
import pytest

from pysinew import Case, CaseError, Solutions, SolveError

# Two sets of one body, which a permutation would exchange.
THETAS = np.array([[9.0, 12.0], [15.0, 10.0], [11.0, 14.0]])


def variants(table: np.ndarray) -> dict[str, np.ndarray]:
    """The same numbers in other memory."""
    wide = np.full((2 * len(table), 3 * table.shape[1]), np.nan)
    wide[::2, ::3] = table
    return {
        "transposed": np.ascontiguousarray(table.T).T,
        "fortran": np.asfortranarray(table),
        "strided": wide[::2, ::3],
        "reversed": table[::-1, ::-1].copy()[::-1, ::-1],
        "float32": table.astype(np.float32),
        "integer": table.astype(np.int32),
        "big endian": table.astype(">f8"),
        "list": table.tolist(),
    }


@pytest.mark.parametrize("kind", list(variants(THETAS)))
def test_theta_is_read_by_its_indices(emulator, kind: str) -> None:
    expected = emulator.predict(THETAS).displacement
    given = variants(THETAS)[kind]
    assert np.array_equal(emulator.predict(given).displacement, expected)
    # The compiled half does not rely on the order either.
    if kind in ("transposed", "fortran", "strided", "reversed"):
        found, _ = emulator._native.predict(given, 0, None)
        assert np.array_equal(found, expected)


@pytest.mark.parametrize("kind", list(variants(THETAS)))
def test_a_mesh_is_read_by_its_indices(bar: Case, kind: str) -> None:
    keys = dict(
        law="neo-hookean",
        parameters={"mu": [8, 16], "lambda": [8, 16]},
        loads=[{"body_force": [0, 0, -9.8e-3]}],
        supports=[{"clamped": "x_min"}],
        node_sets={"x_min": bar.points[:, 0] == 0},
    )
    points, cells = variants(bar.points)[kind], bar.cells
    if kind == "integer":
        assert np.array_equal(points, bar.points), "the box has whole coordinates"
    case = Case(mesh=(points, np.asfortranarray(cells)), **keys)
    assert np.array_equal(case.points, bar.points) and np.array_equal(case.cells, cells)
    theta = {"mu": 10, "lambda": 12}
    assert np.array_equal(case.solve(theta).displacement, bar.solve(theta).displacement)


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        ([np.nan, 12.0], "not a finite number"),
        ([[10.0, np.inf]], "[0, 1]"),
        (np.array([1 + 2j, 3]), "complex"),
        (np.array(["a", "b"]), "numbers are needed"),
        (np.array([True, False]), "bool"),
        ([1.0, 2.0, 3.0], "2 parameters (mu, lambda)"),
        (3.0, "give one number each"),
        ([[1.0], [2.0, 3.0]], "different lengths"),
        ({"mu": np.nan, "lambda": 1}, "not a finite number"),
        ({"mu": 10, "lamda": 12}, "did you mean `lambda`"),
        ({"mu": 10}, "lambda"),
        ({"mu": "10 mm", "lambda": 12}, "mm"),
        ({"mu": True, "lambda": 12}, "bool"),
        ({"mu": [1, 2], "lambda": [1, 2, 3]}, "columns of one length"),
        ({"mu": -10.0, "lambda": 12.0}, "mu = -10"),
    ],
)
def test_what_is_no_theta_is_refused(bar: Case, bad: object, said: str) -> None:
    with pytest.raises(CaseError) as error:
        bar.solve(bad, progress=False)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("points", "cells", "said"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0], [0, 0, 1]], [[0, 1, 2, 3]], "not a finite number"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 4]], "4"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, -1]], "-1"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0.0, 1.0, 2.0, 3.0]], "whole numbers"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3, 0]], "3, 4, 6, 8 or 10"),
        ([[0], [1]], [[0, 1, 2, 3]], "three coordinates"),
    ],
)
def test_what_is_no_mesh_is_refused(points: object, cells: object, said: str) -> None:
    with pytest.raises(CaseError) as error:
        Case(mesh=(points, cells), law="neo-hookean", parameters={}, supports=[{"clamped": "a"}])
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        ({"node_sets": {"x": np.ones(3, dtype=bool)}}, "a mask of shape (3,); give one entry for each of 4 nodes"),
        ({"node_sets": {"x": np.ma.masked_array([0, 1], mask=[0, 1])}}, "the node set `x`: masked entries"),
        ({"node_sets": [0, 1]}, "node_sets: give a dictionary of sets by their names"),
        ({"facet_sets": {1: [[0, 1, 2]]}}, "facet_sets: give a dictionary of sets by their names"),
        ({"merge": "yes"}, "merge = 'yes': give True or False"),
    ],
)
def test_what_is_no_set_is_refused(sets: dict, said: str) -> None:
    mesh = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])
    with pytest.raises(CaseError) as error:
        Case(mesh=mesh, law="neo-hookean", parameters={}, supports=[{"clamped": "x"}], **sets)
    assert said in str(error.value)


def test_displacements_of_ones_own_are_doubles_of_the_nodes(bar: Case) -> None:
    found = bar.solve([10.0, 12.0], progress=False)
    single = Solutions(bar, found.theta.astype(np.float32), found.displacement.astype(np.float32), [[]])
    stress, expected = (own.stresses()["cauchy_stress"] for own in (single, found))
    # Rounding of displacements to 24 bits: 1e-6 mm over cells of 3 mm, times a stiffness of 50 kPa.
    assert np.abs(stress - expected).max() < 1e-4
    short = Solutions(bar, found.theta, found.displacement[1:], [[]])
    for asked in (short.stresses, short.reactions, lambda: short.volumes):
        with pytest.raises(CaseError, match="the case has 63 nodes"):
            asked()
    lost = Solutions(bar, np.stack([found.theta] * 2), np.stack([found.displacement, np.nan * found.displacement]), [[], []], {1: "no equilibrium"})
    for asked in (lost.stresses, lost.reactions, lambda index: lost.write("never.vtu", index)):
        with pytest.raises(SolveError, match="set 1: no equilibrium"):
            asked(-1)


def test_units_are_those_of_a_case_file(bar: Case) -> None:
    by_name = bar.solve({"lambda": "0.012 MPa", "mu": "10000 Pa"}).displacement
    assert np.allclose(by_name, bar.solve([10.0, 12.0]).displacement, rtol=1e-12, atol=0.0)
    scene = Case.scene("IdealVentricle")
    pressure = scene.parameters[-1]
    assert (pressure.name, pressure.unit) == ("p", "mmHg")
    middle = scene._native.shown(scene._native.centre()[np.newaxis])[0]
    theta = dict(zip([p.name for p in scene.parameters], middle))
    rows = [scene._native.in_scene(middle[np.newaxis])[0][-1], scene._native.theta([(k, repr(float(v))) for k, v in theta.items()])[-1]]
    assert rows[0] == rows[1]
    kpa = scene._native.theta([(k, repr(float(v)) if k != "p" else "1.0 kPa") for k, v in theta.items()])[-1]
    assert kpa == 1.0
