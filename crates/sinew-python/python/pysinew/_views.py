"""Results for other packages, which are imported when they are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._meshes import NAMES

if TYPE_CHECKING:
    from .case import Case
    from .results import Fields


def _arrays(result: Fields, index: int, stresses: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Fields of the nodes and of the cells."""
    nodes = {"displacement": np.array(result.one(index))}
    cells = {name: values.reshape(len(values), -1) if values.ndim == 3 else values
             for name, values in result.stresses(index).items()} if stresses else {}
    return nodes, cells


def pyvista_of(case: Case) -> Any:
    """A pyvista grid of a case's mesh."""
    import pyvista

    return pyvista.UnstructuredGrid({case._native.vtk_type: case.cells}, np.array(case.points))


def meshio_of(case: Case) -> Any:
    """A meshio mesh of a case's mesh, with its node sets."""
    import meshio

    cells = [(NAMES[case._native.vtk_type], case.cells)]
    return meshio.Mesh(np.array(case.points), cells, point_sets=dict(case.node_sets))


def to_pyvista(result: Fields, index: int, stresses: bool) -> Any:
    grid = pyvista_of(result.case)
    nodes, cells = _arrays(result, index, stresses)
    for name, values in nodes.items():
        grid.point_data[name] = values
    grid.set_active_vectors("displacement")
    for name, values in cells.items():
        grid.cell_data[name] = values
    return grid


def to_meshio(result: Fields, index: int, stresses: bool) -> Any:
    mesh = meshio_of(result.case)
    nodes, cells = _arrays(result, index, stresses)
    mesh.point_data.update(nodes)
    mesh.cell_data.update({name: [values] for name, values in cells.items()})
    return mesh


def to_xarray(result: Fields) -> Any:
    import xarray

    case = result.case
    many = len(result)
    displacement = result.displacement.reshape(many, -1, 3)
    thetas = np.atleast_2d(result.theta)
    coordinates: dict[str, Any] = {
        "axis": ["x", "y", "z"],
        "position": (("node", "axis"), np.array(case.points), {"units": "mm"}),
    }
    for k, parameter in enumerate(case.parameters):
        coordinates[parameter.name] = ("set", thetas[:, k], {"units": parameter.unit})
    data: dict[str, Any] = {"displacement": (("set", "node", "axis"), displacement, {"units": "mm"})}
    for name, volumes in result.volumes.items():
        data[f"volume_{name}"] = ("set", np.atleast_1d(volumes), {"units": "mm3"})
    error = getattr(result, "error", None)
    if error is not None:
        data["error"] = ("set", np.atleast_1d(error), {"units": "1"})
    return xarray.Dataset(data, coords=coordinates, attrs={"case": case.name})
