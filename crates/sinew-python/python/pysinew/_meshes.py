"""Meshes that users have: meshio, pyvista, or arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._native import NativeMesh
from ._numbers import Floats, floats, indices, unmasked
from ._theta import by_axes
from .errors import CaseError

# Kinds of cells by the names of meshio: VTK's number, nodes, dimension.
KINDS = {
    "vertex": (1, 1, 0),
    "line": (3, 2, 1),
    "line3": (21, 3, 1),
    "triangle": (5, 3, 2),
    "triangle6": (22, 6, 2),
    "quad": (9, 4, 2),
    "tetra": (10, 4, 3),
    "tetra10": (24, 10, 3),
    "hexahedron": (12, 8, 3),
    "wedge": (13, 6, 3),
    "pyramid": (14, 5, 3),
}
NAMES = {number: name for name, (number, _, _) in KINDS.items()}
# VTK's number for a hexahedron along the axes, and its nodes in the order of other hexahedra.
VOXEL = 11
VOXEL_ORDER = [0, 1, 3, 2, 4, 5, 7, 6]
# Kinds of cells by their number of nodes, where nothing else is said.
BY_NODES = {3: "triangle", 4: "tetra", 6: "triangle6", 8: "hexahedron", 10: "tetra10"}


class Blocks:
    """A mesh while it is put together, with the places of its blocks among all cells."""

    def __init__(self, points: Any, unit: str | None = None) -> None:
        array = floats(by_axes(points, "mesh: points", unit), "mesh: points")
        labels = list(points.index) if hasattr(points, "columns") else []
        if labels != list(range(len(labels))) and sorted(map(str, labels)) == sorted(map(str, range(len(labels)))):
            raise CaseError("mesh: rows of points are not in the order of their labels, which cells refer to; sort them (sort_index)")
        if array.ndim != 2 or array.shape[1] not in (2, 3):
            raise CaseError(f"mesh: points of shape {array.shape}; give a row of three coordinates for every node")
        if array.shape[1] == 2:
            array = np.hstack([array, np.zeros((len(array), 1))])
        self.points = array
        self.native = NativeMesh(array)
        self.count = 0
        self.fields: list[tuple[str, Any, bool]] = []

    def add(self, kind: str, cells: Any) -> range:
        """Adds a block of cells; their numbers among all."""
        array = indices(cells, f"mesh: cells ({kind})")
        if kind not in KINDS:
            raise CaseError(f"mesh: cells of the kind `{kind}` are not computed with; kinds: {', '.join(KINDS)}")
        number, nodes, _ = KINDS[kind]
        if array.ndim != 2 or array.shape[1] != nodes:
            raise CaseError(f"mesh: cells ({kind}) of shape {array.shape}; give a row of {nodes} nodes for every cell")
        first = self.native.add_cells(number, array)
        self.count = first + len(array)
        return range(first, self.count)

    def name_cells(self, name: str, cells: Any) -> None:
        self.native.name_cells(name, indices(cells, f"mesh: the set `{name}`").ravel().astype(np.uint64))

    def name_nodes(self, name: str, nodes: Any) -> None:
        self.native.name_nodes(name, indices(nodes, f"mesh: the node set `{name}`").ravel().astype(np.uint64))

    def field(self, name: str, values: Any, of_nodes: bool) -> None:
        """Adds a field; one that is not of numbers is left out."""
        unmasked(values, f"mesh: the field `{name}`")
        array = np.asarray(values)
        rows = len(self.points) if of_nodes else self.count
        if array.dtype.kind not in "fiub" or array.ndim == 0 or len(array) != rows or array.size == 0:
            return
        self.fields.append((name, array, of_nodes))

    def made(self) -> NativeMesh:
        """The mesh; fields are zero at cells that were added behind them."""
        for name, array, of_nodes in self.fields:
            rows = len(self.points) if of_nodes else self.count
            array = np.concatenate([array, np.zeros((rows - len(array), *array.shape[1:]), array.dtype)])
            if array.ndim == 1 and array.dtype.kind in "iub":
                self.native.add_labels(name, of_nodes, np.ascontiguousarray(array, dtype=np.int64))
                continue
            table: Floats = np.ascontiguousarray(array, dtype=np.float64).reshape(rows, -1)
            self.native.add_field(name, of_nodes, table)
        return self.native


def read(
    mesh: Any,
    node_sets: Mapping[str, Any] | None = None,
    facet_sets: Mapping[str, Any] | None = None,
    merge: bool = False,
    unit: str | None = None,
) -> NativeMesh:
    """A mesh of meshio or pyvista, or (points, cells) in a unit of length, with further sets, and nodes at one place made one."""
    if hasattr(mesh, "celltypes") and hasattr(mesh, "cells_dict"):
        blocks = _from_pyvista(mesh)
    elif hasattr(mesh, "cast_to_unstructured_grid"):
        blocks = _from_pyvista(mesh.cast_to_unstructured_grid())
    elif hasattr(mesh, "points") and hasattr(mesh, "cells"):
        blocks = _from_meshio(mesh)
    elif isinstance(mesh, tuple) and len(mesh) == 2:
        blocks = _from_arrays(*mesh, unit)
    else:
        raise CaseError(
            f"mesh: a {type(mesh).__name__} is no mesh; give one of meshio or pyvista, (points, cells), the path of a file, or keys "
            f"such as {{'box': {{'extent': [100, 10, 10], 'cells': [12, 4, 5]}}}}"
        )
    for name, nodes in _named(node_sets, "node_sets").items():
        unmasked(nodes, f"mesh: the node set `{name}`")
        array = np.asarray(nodes)
        if array.dtype.kind == "b" and array.shape != (len(blocks.points),):
            raise CaseError(f"mesh: the node set `{name}`: a mask of shape {array.shape}; give one entry for each of {len(blocks.points)} nodes")
        blocks.name_nodes(name, np.flatnonzero(array) if array.dtype.kind == "b" else array)
    for name, facets in _named(facet_sets, "facet_sets").items():
        array = indices(facets, f"mesh: the facet set `{name}`")
        width = array.shape[1] if array.ndim == 2 else 0
        kind = {2: "line", 3: "triangle", 4: "quad", 6: "triangle6"}.get(width)
        if kind is None:
            raise CaseError(f"mesh: the facet set `{name}` of shape {array.shape}; give a row of nodes for every facet")
        blocks.name_cells(name, list(blocks.add(kind, array)))
    if merge:
        blocks.native.merge_nodes()
    return blocks.made()


def _named(sets: Any, what: str) -> Mapping[str, Any]:
    sets = {} if sets is None else sets
    if not isinstance(sets, Mapping) or any(not isinstance(name, str) for name in sets):
        raise CaseError(f"{what}: give a dictionary of sets by their names")
    return sets


def _from_arrays(points: Any, cells: Any, unit: str | None) -> Blocks:
    blocks = Blocks(points, unit)
    if isinstance(cells, Mapping):
        cells = list(cells.items())
    if isinstance(cells, list) and cells and isinstance(cells[0], tuple) and isinstance(cells[0][0], str):
        for kind, array in cells:
            blocks.add(kind, array)
        return blocks
    array = indices(cells, "mesh: cells")
    width = array.shape[1] if array.ndim == 2 else 0
    if width not in BY_NODES:
        raise CaseError(f"mesh: cells of shape {array.shape}; give a row of 3, 4, 6, 8 or 10 nodes for every cell")
    blocks.add(BY_NODES[width], array)
    return blocks


def _from_meshio(mesh: Any) -> Blocks:
    blocks = Blocks(mesh.points)
    places = [(block.type, blocks.add(block.type, block.data)) for block in mesh.cells]
    for name, values in mesh.point_data.items():
        blocks.field(name, values, of_nodes=True)
    for name, parts in mesh.cell_data.items():
        if len({np.asarray(part).shape[1:] for part in parts}) == 1:
            blocks.field(name, np.concatenate([np.asarray(part) for part in parts]), of_nodes=False)
    for name, nodes in getattr(mesh, "point_sets", {}).items():
        blocks.name_nodes(name, nodes)
    named = {name: parts for name, parts in getattr(mesh, "cell_sets", {}).items() if ":" not in name}
    for name, parts in named.items():
        for (_, place), part in zip(places, parts):
            if part is not None and len(part):
                blocks.name_cells(name, place.start + _cells_of(name, np.asarray(part), len(place)))
    tags = mesh.cell_data.get("gmsh:physical", [])
    for name, (tag, dimension) in getattr(mesh, "field_data", {}).items():
        for (kind, place), part in zip(places, tags):
            if name not in named and KINDS[kind][2] == dimension:
                blocks.name_cells(name, place.start + np.flatnonzero(np.asarray(part) == tag))
    return blocks


def _cells_of(name: str, cells: np.ndarray, count: int) -> np.ndarray:
    """Places of the cells of a set in a block of so many, by their numbers or a mask."""
    if cells.dtype == bool and cells.shape == (count,):
        return np.flatnonzero(cells)
    if not np.issubdtype(cells.dtype, np.integer) or cells.min() < 0 or cells.max() >= count:
        raise CaseError(f"mesh: the cell set `{name}` of a block of {count} cells: give numbers from 0 to {count - 1}, or a mask")
    return cells.astype(np.int64)


def _from_pyvista(mesh: Any) -> Blocks:
    blocks = Blocks(np.asarray(mesh.points))
    types = np.asarray(mesh.celltypes)
    order = []
    for number, cells in mesh.cells_dict.items():
        kind = "hexahedron" if number == VOXEL else NAMES.get(int(number))
        if kind is None:
            raise CaseError(f"mesh: cells of VTK's type {number} are not computed with; triangulate the mesh")
        blocks.add(kind, np.asarray(cells)[:, VOXEL_ORDER] if number == VOXEL else np.asarray(cells))
        order.append(np.flatnonzero(types == number))
    rows = np.concatenate(order) if order else np.zeros(0, dtype=np.int64)
    for name in mesh.point_data.keys():
        blocks.field(name, np.asarray(mesh.point_data[name]), of_nodes=True)
    for name in mesh.cell_data.keys():
        blocks.field(name, np.asarray(mesh.cell_data[name])[rows], of_nodes=False)
    return blocks
