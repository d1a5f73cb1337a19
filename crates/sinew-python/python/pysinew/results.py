"""Displacements with their parameters, and how far they are to be trusted."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _views
from ._numbers import Floats

if TYPE_CHECKING:
    from .case import Case

__all__ = ["Answers", "Corrections", "Estimate", "Fields", "Predictions", "Solutions"]


@dataclass(frozen=True, eq=False)
class Fields:
    """Displacements of a case at one parameter set, or at several.

    Arrays follow θ: at one set `displacement` has the shape (nodes, 3), at n sets (n, nodes, 3).
    """

    #: The case.
    case: Case
    #: Parameters in their own units, (p,) or (n, p).
    theta: Floats
    #: Displacement [mm], (nodes, 3) or (n, nodes, 3); NaN where there is none.
    displacement: Floats
    #: Reasons not to trust each set.
    warnings: list[list[str]]

    def __len__(self) -> int:
        """Number of parameter sets."""
        return 1 if self.is_one else len(self.displacement)

    @property
    def is_one(self) -> bool:
        """Whether this is of one set rather than of several."""
        return self.displacement.ndim == 2

    def _rows(self) -> Floats:
        return self.displacement.reshape(len(self), -1)

    def one(self, index: int = 0) -> Floats:
        """Displacement of one set [mm], (nodes, 3)."""
        return self.displacement if self.is_one else self.displacement[index]

    def theta_of(self, index: int = 0) -> dict[str, float]:
        """Parameters of one set by name, in their own units."""
        values = self.theta if self.is_one else self.theta[index]
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
        values = np.atleast_2d(self.theta)[index if not self.is_one else 0]
        theta = self.case._native.in_scene(values[np.newaxis])[0]
        return self.case._native.stresses(theta, np.ascontiguousarray(self.one(index)).ravel())

    def to_pyvista(self, index: int = 0, stresses: bool = False) -> Any:
        """A `pyvista.UnstructuredGrid` of one set, with the displacement `u`."""
        return _views.to_pyvista(self, index, stresses)

    def to_meshio(self, index: int = 0, stresses: bool = False) -> Any:
        """A `meshio.Mesh` of one set, with the displacement `u`."""
        return _views.to_meshio(self, index, stresses)

    def to_xarray(self) -> Any:
        """An `xarray.Dataset` of all sets."""
        return _views.to_xarray(self)

    def write(self, path: Union[str, PathLike[str]], index: int = 0) -> None:
        """Writes one set as a VTU file with the displacement `u`, for ParaView."""
        self.case._native.write_vtu(path, np.ascontiguousarray(self.one(index)))


@dataclass(frozen=True, eq=False)
class Solutions(Fields):
    """Equilibria by the solver."""

    #: Why a set has no equilibrium, by its index.
    failures: dict[int, str] = field(default_factory=dict)
    #: Wall time of each solve [s]; NaN where it failed.
    seconds: Floats = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class Predictions(Fields):
    """Displacements by an emulator. `Emulator.estimate` says how far they are from equilibrium."""


@dataclass(frozen=True, eq=False)
class Answers(Fields):
    """Displacements to an accuracy that was asked for, each with its checked error."""

    #: Estimated mean nodal error relative to the mean nodal displacement, () or (n,).
    error: Floats = field(default_factory=lambda: np.zeros(0))
    #: `predicted` or `solved`, set by set.
    source: list[str] = field(default_factory=list)
    #: Why a set has no answer, by its index.
    failures: dict[int, str] = field(default_factory=dict)
    #: Error that was asked for.
    accuracy: float = 1e-3
    #: Method that was expected to cost least.
    method: str = ""

    @property
    def within(self) -> Any:
        """Whether the checked error is below what was asked for, () or (n,)."""
        return self.error <= self.accuracy


@dataclass(frozen=True, eq=False)
class Estimate:
    """Distances of displacements from the equilibria nearby, () or (n,); NaN where there is none, for which `words` say why."""

    #: Mean nodal distance [mm].
    mean: Floats
    #: Largest nodal distance [mm].
    largest: Floats
    #: Energy norm of the error [√(kPa·mm³)].
    energy_norm: Floats
    #: Energy norm relative to that of the displacement.
    relative: Floats
    #: Unbalanced nodal forces relative to loads and reactions.
    residual: Floats
    #: The same for people, set by set.
    words: list[str]

    def __str__(self) -> str:
        return "\n".join(self.words)


@dataclass(frozen=True, eq=False)
class Corrections(Fields):
    """Predictions after Newton steps, with the estimate of what is left."""

    #: Their estimate; None is never given by `Emulator.correct`.
    estimate: Estimate = field(default=None)  # type: ignore[assignment]
