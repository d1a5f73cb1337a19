"""Results for other packages, imported when they are asked for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pysinew import Case, CaseError


def test_nothing_else_is_imported() -> None:
    program = "import sys, pysinew; print([m for m in ('meshio', 'pyvista', 'vtk', 'xarray', 'pandas') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_meshio_and_pyvista_hold_the_displacement(bar: Case, tmp_path: Path) -> None:
    meshio, pyvista = pytest.importorskip("meshio"), pytest.importorskip("pyvista")
    found = bar.solve([[10.0, 12.0], [9.0, 15.0]])
    grid, mesh = found.to_pyvista(1, stresses=True), found.to_meshio(1, stresses=True)
    for points, u in ((grid.points, grid.point_data["displacement"]), (mesh.points, mesh.point_data["displacement"])):
        assert np.array_equal(points, bar.points) and np.array_equal(u, found.displacement[1])
    assert grid.cell_data["cauchy_stress"].shape == (len(bar.cells), 9)
    mesh.write(tmp_path / "meshio.vtu")
    found.write(tmp_path / "own.vtu", 1)
    assert grid.active_vectors_name == "displacement" and pyvista.read(tmp_path / "own.vtu").active_vectors_name == "displacement"
    for file in ("meshio.vtu", "own.vtu"):
        assert np.array_equal(meshio.read(tmp_path / file).point_data["displacement"], found.displacement[1])
        assert np.array_equal(pyvista.read(tmp_path / file).point_data["displacement"], found.displacement[1])


def test_files_hold_stresses_where_they_are_asked_for(bar: Case, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    found = bar.solve([10.0, 12.0])
    found.write(tmp_path / "u.vtu", stresses=True)
    grid, stresses = pyvista.read(tmp_path / "u.vtu"), found.stresses()
    assert np.array_equal(grid.cell_data["cauchy_stress"].reshape(-1, 3, 3), stresses["cauchy_stress"])
    tensors = grid.point_data["cauchy_stress"].reshape(-1, 3, 3)
    values = np.linalg.eigvalsh(tensors)[:, ::-1]
    # Rounding of eigenvalues, relative to the largest stress.
    assert np.abs(values - grid.point_data["principal_stresses"]).max() < 1e-12 * np.abs(values).max()
    with pytest.raises(CaseError, match="u.xyz: fields are written as VTU"):
        found.write(tmp_path / "u.xyz")
    for wrong in (found.one, found.stresses, found.theta_of):
        with pytest.raises(IndexError, match="set 5"):
            wrong(5)


def test_xarray_names_axes_and_parameters(bar: Case, emulator) -> None:
    pytest.importorskip("xarray")
    found = emulator.predict([[10.0, 12.0], [9.0, 15.0]]).to_xarray()
    assert dict(found.sizes) == {"set": 2, "node": len(bar.points), "axis": 3}
    assert found["mu"].attrs["units"] == "kPa" and list(found["lambda"].values) == [12.0, 15.0]
    answers = bar.answers({"mu": 10.0, "lambda": 12.0}).to_xarray()
    assert answers["error"].shape == (1,)


def test_volumes_of_cavities_rise_with_pressure() -> None:
    case = Case.scene("IdealVentricle")
    low, high = (p.low for p in case.parameters), (p.low for p in case.parameters)
    rows = np.array([list(low), list(high)])
    rows[1, -1] = case.parameters[-1].high
    volumes = case.solve(rows, progress=False).volumes["endo"]
    assert volumes.shape == (2,) and volumes[1] > 1.05 * volumes[0]
