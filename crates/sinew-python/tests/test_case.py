"""Cases from everywhere are one case, and errors are in the program's words."""

from __future__ import annotations

import os
import pickle
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest

from pysinew import Case, CaseError, SinewWarning, SolveError

from conftest import BAR

KEYS = dict(
    law="neo-hookean",
    parameters={"mu": [8.0, 16.0], "lambda": (8, 16)},
    loads=[{"body_force": np.array([0.0, 0.0, -9.8e-3])}],
    supports=[{"clamped": "x_min"}],
)
THETA = {"mu": 10.0, "lambda": 12.0}


def test_keys_text_and_file_are_one_case(bar: Case, tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(BAR)
    read = Case.read(tmp_path / "bar.toml")
    made = Case(mesh={"box": {"extent": [30, 6, 6], "cells": [6, 2, 2]}}, **KEYS)
    expected = bar.solve(THETA).displacement
    for case in (read, made):
        assert np.array_equal(case.solve(THETA).displacement, expected)
    assert read.name == "bar" and [p.name for p in made.parameters] == ["mu", "lambda"]


def test_meshes_of_meshio_and_pyvista_are_the_mesh(bar: Case, tmp_path: Path) -> None:
    meshio, pyvista = pytest.importorskip("meshio"), pytest.importorskip("pyvista")
    expected = bar.solve(THETA).displacement
    triangles = bar.facet_sets["x_min"]
    of_meshio = meshio.Mesh(
        bar.points / 10.0,
        [("triangle", triangles), ("tetra", bar.cells)],
        cell_sets={"x_min": [np.arange(len(triangles)), np.array([], dtype=int)]},
    )
    case = Case(mesh=of_meshio, unit="cm", **KEYS)
    assert np.allclose(case.solve(THETA).displacement, expected, rtol=1e-9, atol=1e-12)
    of_meshio.cell_sets = {"x_min": [np.ones(len(triangles), bool), np.array([], dtype=int)]}
    assert np.array_equal(Case(mesh=of_meshio, unit="cm", **KEYS).solve(THETA).displacement, case.solve(THETA).displacement)
    for wrong in (np.array([len(triangles)]), np.array([-1]), np.array([0.5])):
        of_meshio.cell_sets = {"x_min": [wrong, np.array([], dtype=int)]}
        with pytest.raises(CaseError, match="cell set `x_min`"):
            Case(mesh=of_meshio, unit="cm", **KEYS)
    # Interleaved kinds of cells, labelled by a field.
    blocks = meshio.Mesh(bar.points, [("tetra", bar.cells[:50]), ("triangle", triangles), ("tetra", bar.cells[50:])])
    blocks.cell_data["region"] = [np.zeros(50, int), np.full(len(triangles), 7), np.zeros(len(bar.cells) - 50, int)]
    keys = {**KEYS, "supports": [{"clamped": "region:7"}]}
    assert np.array_equal(Case(mesh=blocks, **keys).solve(THETA).displacement, expected)
    blocks.write(tmp_path / "bar.vtu")
    assert np.array_equal(Case(mesh=tmp_path / "bar.vtu", **keys).solve(THETA).displacement, expected)
    grid = pyvista.read(tmp_path / "bar.vtu")
    assert np.array_equal(Case(mesh=grid, **keys).solve(THETA).displacement, expected)
    # And back again.
    again = Case(mesh=bar.to_pyvista(), node_sets={"x_min": bar.node_sets.get("x_min", np.unique(triangles))}, **KEYS)
    assert np.array_equal(again.solve(THETA).displacement, expected)


def test_voxels_are_hexahedra() -> None:
    pyvista = pytest.importorskip("pyvista")
    image = pyvista.ImageData(dimensions=(7, 3, 3), spacing=(5.0, 3.0, 3.0))
    # A segmented image, whose background is left out.
    image.cell_data["label"] = np.ones(image.n_cells, dtype=int)
    keys = {**KEYS, "supports": [{"clamped": "left"}], "select": {"left": {"plane": {"point": [0, 0, 0], "normal": [1, 0, 0]}}}}
    hexahedra = Case(mesh={"box": {"extent": [30, 6, 6], "cells": [6, 2, 2]}, "element": "hexahedra"}, **KEYS)
    for voxels in (image, image.threshold(0.5, scalars="label")):
        case = Case(mesh=voxels, **keys)
        assert case.cells.shape == (24, 8)
        found, expected = (own.points + own_u.displacement for own, own_u in ((c, c.solve(THETA)) for c in (case, hexahedra)))
        by_place = [np.lexsort(own.points.round(6).T) for own in (case, hexahedra)]
        # To the solver's tolerance: nodes are numbered in another order.
        assert np.allclose(found[by_place[0]], expected[by_place[1]], rtol=0.0, atol=1e-8)


def test_keys_that_are_none_are_left_out_and_two_units_refused(bar: Case) -> None:
    mesh = {"box": {"extent": [30, 6, 6], "cells": [6, 2, 2]}, "unit": None}
    made = Case(mesh=mesh, **{**KEYS, "loads": [{"body_force": [0.0, 0.0, -9.8e-3], "facets": None}]})
    assert np.array_equal(made.solve(THETA).displacement, bar.solve(THETA).displacement)
    with pytest.raises(CaseError, match="unit = 'mm', but the keys of the mesh have 'cm'"):
        Case(mesh={**mesh, "unit": "cm"}, unit="mm", **KEYS)


def test_facets_may_be_named_by_their_nodes(bar: Case) -> None:
    mesh = (bar.points, bar.cells)
    case = Case(mesh=mesh, facet_sets={"x_min": bar.facet_sets["x_min"]}, **KEYS)
    assert np.array_equal(case.solve(THETA).displacement, bar.solve(THETA).displacement)
    with pytest.raises(CaseError, match="1 cells of the boundary are facets of no cell"):
        Case(mesh=mesh, facet_sets={"x_min": np.array([[0, 1, len(bar.points) - 1]])}, **KEYS)


def test_fields_of_cells_stand_beside_facets_by_their_nodes(bar: Case) -> None:
    meshio = pytest.importorskip("meshio")
    twice = meshio.Mesh(bar.points, [("tetra", bar.cells)], cell_data={"twice": [np.full(len(bar.cells), 2, np.uint8)]})
    case = Case(mesh=twice, facet_sets={"x_min": bar.facet_sets["x_min"]}, stiffness={"field": "twice"}, **KEYS)
    expected = bar.solve({name: 2.0 * value for name, value in THETA.items()}).displacement
    assert np.allclose(case.solve(THETA).displacement, expected, rtol=0.0, atol=1e-9)


def test_a_law_with_fibres_reads_a_field(bar: Case) -> None:
    meshio = pytest.importorskip("meshio")
    fibres = np.tile([1.0, 0.0, 0.0], (len(bar.cells), 1)).astype(np.float32)
    mesh = meshio.Mesh(bar.points, [("tetra", bar.cells)], cell_data={"fibre": [fibres]})
    keys = {
        **KEYS,
        "law": {"name": "guccione", "bulk_modulus": 25.0},
        "parameters": {"C": [1.75, 3.5], "b_f": [1.75, 3.5], "b_t": [1.75, 3.5], "b_fs": [1.75, 3.5]},
    }
    sets = {"x_min": bar.points[:, 0] == 0}
    field = Case(mesh=mesh, fibres={"field": "fibre"}, node_sets=sets, **keys)
    constant = Case(mesh=mesh, fibres={"direction": [1, 0, 0]}, node_sets=sets, **keys)
    assert np.array_equal(field.solve().displacement, constant.solve().displacement)
    stresses = field.solve().stresses()
    assert stresses["fibre_stretch"].shape == (len(bar.cells),) and stresses["cauchy_stress"].shape == (len(bar.cells), 3, 3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"law": "neo-hooken"}, "did you mean `neo-hookean`"),
        ({"supports": []}, "the body is held nowhere"),
        ({"supports": [{"clamped": "x_mni"}]}, "x_mni"),
        ({"parameters": {"mu": [8, 16]}}, "`lambda` is missing"),
        ({"parameters": {"mu": [8, np.nan], "lambda": [8, 16]}}, "not finite"),
        ({"formulation": "plane"}, "plain"),
        ({"loads": [{"body_force": object()}]}, "a object has no place in a case"),
    ],
)
def test_a_wrong_key_is_told_as_by_the_program(change: dict, said: str) -> None:
    with pytest.raises(CaseError) as error:
        Case(mesh={"box": {"extent": [30, 6, 6], "cells": [6, 2, 2]}}, **{**KEYS, **change})
    assert said in str(error.value)


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="there is no case file"):
        Case.read(tmp_path / "none.toml")
    with pytest.raises(CaseError, match="IdealVentricle"):
        Case.scene("IdealVentricel")
    with pytest.raises(CaseError, match="is no mesh"):
        Case(mesh=3, **KEYS)


def test_several_sets_follow_theta(bar: Case) -> None:
    table = np.array([[10.0, 12.0], [9.0, 15.0]])
    found = bar.solve(table)
    assert found.displacement.shape == (2, len(bar.points), 3) and len(found) == 2 and found.failures == {}
    assert np.array_equal(found.theta, table) and found.seconds.shape == (2,)
    columns = bar.solve({"mu": table[:, 0], "lambda": list(table[:, 1])})
    rows = bar.solve([{"mu": 10, "lambda": 12}, {"lambda": "15 kPa", "mu": 9}])
    for other in (columns, rows):
        assert np.array_equal(other.displacement, found.displacement)
    one = bar.solve(table[1])
    assert one.is_one and one.displacement.shape == (len(bar.points), 3) and one.magnitude.shape == (len(bar.points),)
    assert one.theta_of() == {"mu": 9.0, "lambda": 15.0}


def test_sensitivities_and_reactions_are_those_of_the_solver(bar: Case) -> None:
    found, step = bar.sensitivity([10.0, 12.0]), 1e-3
    assert found.shape == (2, len(bar.points), 3)
    for k, by in enumerate(np.eye(2) * step):
        ends = bar.solve(np.array([[10.0, 12.0] + by, [10.0, 12.0] - by]), progress=False).displacement
        # The truncation of the difference is of the order of the squared step.
        assert np.allclose((ends[0] - ends[1]) / (2 * step), found[k], rtol=0.0, atol=1e-6 * np.abs(found[k]).max())
    force = bar.solve([10.0, 12.0]).reactions()["x_min"]
    # The weight of the bar, 9.8e-3 mN/mm³ of 30 x 6 x 6 mm³; the residual of a solution is at most 1e-6 of it.
    assert np.allclose(force, [0.0, 0.0, 9.8e-3 * 1080.0], rtol=0.0, atol=2e-5)


def test_sets_without_equilibrium_are_listed() -> None:
    # A ventricle whose wall bears the first pressure and not the second, far above the range.
    case = Case.scene("IdealVentricle")
    theta = {"a": 0.18, "b": 2.6, "a_f": 3.3, "b_f": 2.7, "p": ["8 mmHg", "1e5 mmHg"]}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = case.solve(theta, progress=False)
    assert list(found.failures) == [1] and "equilibrium" in found.failures[1]
    assert np.isnan(found.displacement[1]).all() and np.isfinite(found.displacement[0]).all()
    assert np.isnan(found.seconds[1]) and np.isnan(found.volumes["endo"][1])
    said = [str(warning.message) for warning in told]
    assert any("outside its range" in text for text in said)
    assert any("1 of 2 sets have no equilibrium, the first is set 1" in text for text in said)
    with pytest.raises(SolveError, match="p = 100000 mmHg"):
        case.solve({**theta, "p": "1e5 mmHg"}, progress=False)


def test_a_doubtful_case_warns() -> None:
    with pytest.warns(SinewWarning, match="outside its range"):
        Case.parse(BAR).solve([20.0, 12.0])


def test_same_seed_same_sample(bar: Case) -> None:
    first, again, other = bar.sample(8, seed=3), bar.sample(8, seed=3), bar.sample(8, seed=4)
    assert np.array_equal(first, again) and not np.array_equal(first, other)
    assert first.min() >= 8.0 and first.max() <= 16.0
    with pytest.raises(CaseError, match="design"):
        bar.sample(8, design="random")  # type: ignore[arg-type]


def test_solutions_are_those_of_the_program_to_the_bit(bar: Case, tmp_path: Path) -> None:
    program = os.environ.get("SINEW_PROGRAM")
    if program is None:
        pytest.skip("SINEW_PROGRAM names no program sinew to compare with")
    (tmp_path / "bar.toml").write_text(BAR)
    table = bar.sample(5, seed=2, design="uniform")
    rows = "\n".join(",".join(repr(float(value)) for value in row) for row in table)
    (tmp_path / "thetas.csv").write_text(f"mu,lambda\n{rows}\n")
    subprocess.run(
        [program, "solve", "bar.toml", "--theta", "thetas.csv", "--out", "out"], cwd=tmp_path, check=True, capture_output=True
    )
    theirs = np.load(tmp_path / "out" / "solve" / "cases.npz")
    assert np.array_equal(theirs["theta"], table)
    assert np.array_equal(theirs["displacement"], bar.solve(table).displacement)
    assert np.array_equal(theirs["points"], bar.points) and np.array_equal(theirs["cells"], bar.cells)
    assert theirs["parameters"].tolist() == ["mu [kPa]", "lambda [kPa]"]


def test_mixed_elements_are_solved_as_by_the_program(tmp_path: Path) -> None:
    program = os.environ.get("SINEW_PROGRAM")
    if program is None:
        pytest.skip("SINEW_PROGRAM names no program sinew to compare with")
    text = BAR.replace('law = "neo-hookean"', 'law = { name = "neo-hookean-isochoric", bulk_modulus = 1e4 }\nformulation = "mixed"')
    text = text.replace(", lambda = [8.0, 16.0]", "").replace("cells = [6, 2, 2]", "cells = [4, 1, 1]")
    case = Case.parse(text)
    found = case.solve({"mu": [10.0, 12.0]}, progress=False)
    (tmp_path / "mixed.toml").write_text(text)
    (tmp_path / "thetas.csv").write_text("mu\n10\n12\n")
    command = [program, "solve", "mixed.toml", "--theta", "thetas.csv", "--fields", "--out", "out"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    theirs = np.load(tmp_path / "out" / "solve" / "cases.npz")
    assert np.array_equal(theirs["displacement"], found.displacement) and found.pressure.shape[0] == 2
    one, along = case.solve([12.0], progress=False), case.solve(along={"mu": (10.0, 12.0)}, frames=1, progress=False)
    for own in (found, pickle.loads(pickle.dumps(found))):
        assert np.array_equal(theirs["cauchy_stress"][1].ravel(), own.stresses(1)["cauchy_stress"].ravel())
    # The same equilibrium on other ways, to the tolerance of the solver.
    for stresses in (one.stresses(), along.stresses(1)):
        assert np.allclose(stresses["cauchy_stress"], found.stresses(1)["cauchy_stress"], rtol=0.0, atol=1e-3)
    weight = 9.8e-3 * 1080.0
    assert np.allclose(one.reactions()["x_min"], [0.0, 0.0, weight], rtol=0.0, atol=1e-4 * weight)
    for asked in (lambda: case.train("taylor"), lambda: case.answers([12.0]), lambda: case.sensitivity([12.0]), lambda: case.unload([12.0]), lambda: case.solve([12.0], folder=tmp_path / "kept")):
        with pytest.raises(CaseError, match="mixed elements have no potential"):
            asked()


def test_an_image_is_unloaded_and_loaded_again() -> None:
    case = Case(mesh={"box": {"extent": [30, 6, 6], "cells": [6, 2, 2]}}, **KEYS)
    found = case.unload({"mu": 14.0, "lambda": 14.0})
    assert found.distance < 1e-6 and found.volume_ratios[0] <= found.volume_ratios[1]
    assert np.allclose(found.case.points + found.displacement, case.points, atol=1e-9)
    loaded = found.case.solve({"mu": 14.0, "lambda": 14.0})
    # The image again: to the solver's tolerance.
    assert np.abs(found.case.points + loaded.displacement - case.points).max() < 1e-6
    with pytest.raises(CaseError, match="one set"):
        case.unload([[14.0, 14.0], [15.0, 15.0]])


def test_solutions_by_load_steps_are_kept_apart(bar: Case, tmp_path: Path) -> None:
    for load_steps in (False, True):
        bar.solve(THETA, load_steps=load_steps, folder=tmp_path / "kept", progress=False)
    assert {path.name for path in (tmp_path / "kept").iterdir()} > {"load_steps"}
