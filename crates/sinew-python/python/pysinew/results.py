"""Displacements with their parameters, and how far they are to be trusted."""

from __future__ import annotations

import operator
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _views
from ._numbers import Floats, flag
from .errors import CaseError, SolveError

if TYPE_CHECKING:
    from .case import Case

__all__ = ["Answers", "Corrections", "Estimate", "Fields", "MeshCheck", "Predictions", "Solutions"]


@dataclass(frozen=True, eq=False)
class Fields:
    """Displacements of a case at one parameter set, or at several.

    Arrays follow θ: at one set `displacement` has the shape (nodes, 3), at n sets (n, nodes, 3).

    Attributes:
        case: The case.
        theta: Parameters in their own units, (p,) or (n, p).
        displacement: Displacement [mm], (nodes, 3) or (n, nodes, 3); NaN where there is none.
        warnings: Reasons not to trust each set.
    """

    case: Case
    theta: Floats
    displacement: Floats
    warnings: list[list[str]]

    def __len__(self) -> int:
        """Number of parameter sets."""
        return 1 if self.is_one else len(self.displacement)

    @property
    def is_one(self) -> bool:
        """Whether this is of one set rather than of several."""
        return self.displacement.ndim == 2

    def _rows(self) -> Floats:
        """Displacements as the compiled half reads them, a row for each set."""
        rows = np.asarray(self.displacement, dtype=np.float64).reshape(len(self), -1)
        if rows.shape[1] != self.case._width:
            raise CaseError(f"displacement of shape {self.displacement.shape}: the case has {self.case._width // 3} nodes; give three numbers for each")
        return rows

    def _flat(self, index: int) -> Floats:
        """The displacement of one set, which has one."""
        row: Floats = self._rows()[self._place(index)]
        if not np.isfinite(row).all():
            why = getattr(self, "failures", {}).get(self._place(index), "its displacement is not finite")
            raise SolveError(f"set {self._place(index)}: {why}")
        return row

    def _pressure(self, index: int) -> Floats:
        """Pressures of mixed elements at one set; none without them."""
        return np.zeros(0)

    def _place(self, index: int) -> int:
        """Place of a set, which may be counted from the end."""
        place = operator.index(index)
        if not -len(self) <= place < len(self):
            raise IndexError(f"set {place}: there {'is one set, number 0' if len(self) == 1 else f'are {len(self)} sets'}")
        return place % len(self)

    def _of(self, rows: Floats, index: int) -> Floats:
        """The row of one set."""
        row: Floats = rows if self.is_one and self._place(index) == 0 else rows[self._place(index)]
        return row

    def one(self, index: int = 0) -> Floats:
        """Displacement of one set [mm], (nodes, 3)."""
        return self._of(self.displacement, index)

    def theta_of(self, index: int = 0) -> dict[str, float]:
        """Parameters of one set by name, in their own units."""
        values = self._of(self.theta, index)
        return {parameter.name: float(value) for parameter, value in zip(self.case.parameters, values)}

    @property
    def magnitude(self) -> Floats:
        """Length of each node's displacement [mm], (nodes,) or (n, nodes)."""
        return np.asarray(np.linalg.norm(self.displacement, axis=-1))

    @property
    def volumes(self) -> dict[str, Floats]:
        """Volumes of the cavities that pressures act in [mm³], by name; () or (n,)."""
        found = self.case._native.volumes(self._rows())
        return {name: found[0, k] if self.is_one else found[:, k] for k, name in enumerate(self.case._native.cavities)}

    def stresses(self, index: int = 0) -> dict[str, Floats]:
        """Stress and strain of the cells of one set: `cauchy_stress` [kPa] and `green_lagrange_strain` (cells, 3, 3), principal values,
        `volume` [mm³] and `volume_ratio`, and for laws with fibres their direction, stretch and stress [kPa]."""
        return self.case._native.stresses(self._in_scene(index), self._flat(index), self._pressure(index))

    def reactions(self, index: int = 0) -> dict[str, Floats]:
        """Forces of the supports on each node set that they hold [kPa mm² = mN], (3,), of one set of parameters.

        A node of two node sets counts in both, so that the forces on sets with common nodes do not add up to the load."""
        found = self.case._native.reactions(self._in_scene(index), self._flat(index), self._pressure(index))
        return {name: np.array(force) for name, force in found}

    def _in_scene(self, index: int) -> Floats:
        """Parameters of one set in the units of the scene."""
        return self.case._native.in_scene(np.atleast_2d(np.asarray(self._of(self.theta, index), dtype=np.float64))).ravel()

    def to_pyvista(self, index: int = 0, stresses: bool = False) -> Any:
        """A `pyvista.UnstructuredGrid` of one set, with its `displacement`."""
        return _views.to_pyvista(self, index, stresses)

    def to_meshio(self, index: int = 0, stresses: bool = False) -> Any:
        """A `meshio.Mesh` of one set, with its `displacement`."""
        return _views.to_meshio(self, index, stresses)

    def to_xarray(self) -> Any:
        """An `xarray.Dataset` of all sets."""
        return _views.to_xarray(self)

    def write(self, path: Union[str, PathLike[str]], index: int = 0, stresses: bool = False) -> None:
        """Writes one set as a VTU file for ParaView, with its `displacement`, and with stress and strain of nodes and cells where they are
        asked for."""
        if not fspath(path).lower().endswith(".vtu"):
            raise CaseError(f"{fspath(path)}: fields are written as VTU; give a name that ends with .vtu")
        theta = self._in_scene(index) if flag(stresses, "stresses") else None
        self.case._native.write_vtu(path, self._flat(index), self._pressure(index), theta)


@dataclass(frozen=True, eq=False)
class Solutions(Fields):
    """Equilibria by the solver, with the attributes of `Fields`.

    Attributes:
        failures: Why a set has no equilibrium, by its index.
        seconds: Wall time of each solve [s]; NaN where it failed, and along a path.
        pressure: Pressures of mixed elements at their nodes [kPa], compression negative, (m,) or (n, m); empty without mixed elements.
    """

    failures: dict[int, str] = field(default_factory=dict)
    seconds: Floats = field(default_factory=lambda: np.zeros(0))
    pressure: Floats = field(default_factory=lambda: np.zeros(0))

    def _pressure(self, index: int) -> Floats:
        return self._of(self.pressure, index) if self.pressure.size else self.pressure.ravel()


@dataclass(frozen=True, eq=False)
class Predictions(Fields):
    """Displacements by an emulator. `Emulator.estimate` says how far they are from equilibrium."""


@dataclass(frozen=True, eq=False)
class Answers(Fields):
    """Displacements to an accuracy that was asked for, each with its checked error, and the attributes of `Fields`.

    Attributes:
        error: Estimated mean nodal error relative to the mean nodal displacement, () or (n,).
        source: `predicted` or `solved`, set by set.
        failures: Why a set has no answer, by its index.
        accuracy: Error that was asked for.
        method: Method that was expected to cost least.
    """

    error: Floats = field(default_factory=lambda: np.zeros(0))
    source: list[str] = field(default_factory=list)
    failures: dict[int, str] = field(default_factory=dict)
    accuracy: float = 1e-3
    method: str = ""

    @property
    def within(self) -> NDArray[np.bool_]:
        """Whether the checked error is below what was asked for, () or (n,)."""
        return np.asarray(self.error <= self.accuracy)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Distances of displacements from the equilibria nearby, () or (n,); NaN where there is none, for which `words` say why.

    Attributes:
        mean: Mean nodal distance [mm].
        largest: Largest nodal distance [mm].
        energy_norm: Energy norm of the error [√(kPa·mm³)].
        relative: Energy norm relative to that of the displacement.
        residual: Unbalanced nodal forces relative to loads and reactions.
        words: The same for people, set by set.
    """

    mean: Floats
    largest: Floats
    energy_norm: Floats
    relative: Floats
    residual: Floats
    words: list[str]

    def __str__(self) -> str:
        return "\n".join(self.words)


@dataclass(frozen=True, eq=False)
class MeshCheck:
    """Difference of an equilibrium from that in quadratic cells.

    Attributes:
        mean: Mean nodal distance [mm].
        largest: Largest nodal distance [mm].
        loss: Loss of mean displacement relative to that in quadratic cells; negative where the case's own cells move farther.
        volumes: Volumes of the cavities in the case's own cells and in quadratic ones [mm³], by name.
        words: The same for people.
    """

    mean: float
    largest: float
    loss: float
    volumes: dict[str, tuple[float, float]]
    words: str

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True, eq=False)
class Corrections(Fields):
    """Predictions after Newton steps, with the attributes of `Fields`.

    Attributes:
        estimate: Estimate of their error, which `Emulator.correct` always gives.
    """

    estimate: Estimate = field(default=None)  # type: ignore[assignment]
