"""Parameter sets with labels of their own: names decide, never places; masked entries are refused."""

from __future__ import annotations

from collections import namedtuple

import numpy as np
import pytest

from pysinew import Case, CaseError, Runs, SinewWarning

# In the order of the case: mu, lambda.
ASKED = [[15.0, 10.0], [11.0, 14.0], [9.0, 12.0]]


def rows(case: Case, theta: object) -> list[list[float]]:
    return np.atleast_2d(case.solve(theta, progress=False).theta).round(9).tolist()


def test_frames_and_their_rows_are_read_by_name(bar: Case) -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame({"lambda": [12.0, 10.0, 14.0], "mu": [9.0, 15.0, 11.0]})
    sets = table.sort_values("mu", ascending=False)
    assert rows(bar, sets) == ASKED
    assert rows(bar, sets.iloc[0]) == ASKED[:1]
    assert rows(bar, [row for _, row in sets.iterrows()]) == ASKED
    assert rows(bar, {"mu": sets["mu"], "lambda": sets["lambda"]}) == ASKED
    assert rows(bar, {"mu": sets["mu"], "lambda": sets["lambda"].to_numpy()}) == ASKED
    assert rows(bar, {"mu": table[table["mu"] > 10]["mu"], "lambda": 12.0}) == [[15.0, 12.0], [11.0, 12.0]]
    # Without names the place decides, but not against labels.
    assert rows(bar, pandas.Series([9.0, 12.0])) == [[9.0, 12.0]]
    with pytest.raises(CaseError, match="labels of a series"):
        bar.solve(pandas.Series([9.0, 12.0], index=[1, 0]))
    with pytest.raises(CaseError, match="different labels"):
        bar.solve({"mu": sets["mu"], "lambda": table["lambda"]})
    with pytest.raises(CaseError, match="twice"):
        bar.solve(pandas.DataFrame([[9.0, 12.0, 9.0]], columns=["mu", "lambda", "mu"]))


def test_heads_may_have_units(bar: Case) -> None:
    # Tables of the program have such heads.
    assert rows(bar, {"lambda [Pa]": [10e3, 14e3, 12e3], "mu[kPa]": [15.0, 11.0, 9.0]}) == ASKED
    with pytest.raises(CaseError, match="not a unit of stress"):
        bar.solve({"lambda [mm]": 10.0, "mu": 15.0})
    with pytest.raises(CaseError, match="twice"):
        bar.solve({"lambda [kPa]": 10.0, "lambda": 10.0, "mu": 15.0})


def test_coordinates_of_points_are_read_by_name(bar: Case) -> None:
    pandas = pytest.importorskip("pandas")
    keys = dict(
        law="neo-hookean",
        parameters={"mu": [8.0, 16.0], "lambda": [8.0, 16.0]},
        supports=[{"clamped": "left"}],
        node_sets={"left": bar.points[:, 0] == 0},
    )
    turned = pandas.DataFrame(bar.points[:, ::-1], columns=["z", "y", "x"])
    assert np.array_equal(Case(mesh=(turned, bar.cells), **keys).points, bar.points)
    unnamed = pandas.DataFrame(bar.points)
    assert np.array_equal(Case(mesh=(unnamed, bar.cells), **keys).points, bar.points)
    with pytest.raises(CaseError, match="components are labelled r, phi, z"):
        Case(mesh=(pandas.DataFrame(bar.points, columns=["r", "phi", "z"]), bar.cells), **keys)


def test_units_that_arrays_of_xarray_carry_are_read_or_refused(bar: Case) -> None:
    xarray = pytest.importorskip("xarray")
    pascals = {"units": "Pa"}
    assert rows(bar, {"mu": xarray.DataArray(15e3, attrs=pascals), "lambda": 10.0}) == ASKED[:1]
    with pytest.raises(CaseError, match="an array in Pa"):
        bar.solve(xarray.DataArray([15e3, 10e3], dims="parameter", attrs=pascals))
    with pytest.raises(CaseError, match="points: they are in cm"):
        Case(
            mesh=(xarray.DataArray(bar.points, dims=("node", "axis"), attrs={"units": "cm"}), bar.cells),
            law="neo-hookean",
            parameters={"mu": 1.0, "lambda": 1.0},
            supports=[{"clamped": "left"}],
            node_sets={"left": [0]},
        )
    mu, p = (xarray.DataArray(values, dims="run", attrs={"units": unit}) for values, unit in (([*range(8, 18)], "kPa"), ([4, 9, 7] * 3 + [5], "mmHg")))
    runs = Runs.of_table({"mu": mu, "p": p}, {"volume": 2.0 * mu.values + p.values}, progress=False)
    assert abs(runs.predict({"mu": mu[0], "p": p[0]})["volume"][0] - 20.0) < 1e-6
    with pytest.raises(CaseError, match="p is in kPa here and in mmHg in the runs"):
        runs.predict({"mu": mu[0], "p": xarray.DataArray(0.5, attrs={"units": "kPa"})})


def test_named_tuples_are_read_by_name(bar: Case) -> None:
    # `lambda` is a word of Python, which pandas calls `_0` then.
    Renamed = namedtuple("Renamed", ["_0", "mu"], rename=True)
    with pytest.raises(CaseError, match="_0"):
        bar.solve(Renamed(12.0, 9.0))
    Stress = namedtuple("Stress", ["E", "nu"])
    with pytest.raises(CaseError, match="`E`"):
        bar.solve([Stress(10.0, 0.3)])


def test_coordinates_of_xarray_are_read_by_name(bar: Case) -> None:
    xarray = pytest.importorskip("xarray")
    swapped = [row[::-1] for row in ASKED]
    table = xarray.DataArray(swapped, dims=("set", "parameter"), coords={"parameter": ["lambda", "mu"]})
    assert rows(bar, table) == ASKED and rows(bar, table.T) == ASKED
    assert rows(bar, table.isel(set=1)) == ASKED[1:2]
    assert rows(bar, table.to_dataset("parameter")) == ASKED
    assert rows(bar, xarray.DataArray(ASKED, dims=("set", "parameter"))) == ASKED


@pytest.mark.parametrize("place", ["table", "rows", "column", "number"])
def test_masked_entries_are_refused(bar: Case, place: str) -> None:
    table = np.ma.masked_array(ASKED, mask=[[False, True], [False, False], [False, False]])
    theta = {
        "table": table,
        "rows": list(table),
        "column": {"mu": table[:, 1], "lambda": 12.0},
        "number": {"mu": table[0, 1], "lambda": 12.0},
    }[place]
    with pytest.raises(CaseError, match="masked"):
        bar.solve(theta)
    assert rows(bar, np.ma.masked_array(ASKED, mask=False)) == ASKED


def test_nodes_at_one_place_and_of_no_cell_are_told(bar: Case) -> None:
    points = np.vstack([bar.points, [[1e6, 0.0, 0.0]]])
    keys = dict(
        law="neo-hookean",
        parameters={"mu": [8.0, 16.0], "lambda": [8.0, 16.0]},
        loads=[{"body_force": [0.0, 0.0, -9.8e-3]}],
        supports=[{"clamped": "left"}],
        select={"left": {"plane": {"point": [0, 0, 0], "normal": [1, 0, 0]}}},
    )
    expected = bar.solve([9.0, 12.0], progress=False).displacement
    with pytest.warns(SinewWarning, match="1 node of no cell left out"):
        case = Case(mesh=(points, bar.cells), **keys)
    assert np.array_equal(case.solve([9.0, 12.0], progress=False).displacement, expected)
    # Two halves with nodes of their own.
    half = len(bar.cells) // 2
    points = np.vstack([bar.points, bar.points])
    cells = np.vstack([bar.cells[:half], bar.cells[half:] + len(bar.points)])
    with pytest.warns(SinewWarning, match="nodes at the place of another"):
        Case(mesh=(points, cells), **keys)
    merged = Case(mesh=(points, cells), merge=True, **keys)
    found = merged.solve([9.0, 12.0], progress=False).displacement
    # Nodes are numbered in another order.
    by_place = [np.lexsort(case.points.T) for case in (merged, bar)]
    assert np.allclose(found[by_place[0]], expected[by_place[1]], rtol=1e-9, atol=1e-12)
