"""Emulators: displacements in microseconds, with their errors."""

from __future__ import annotations

import json
import pathlib
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _files, _theta
from ._native import NativeEmulator
from ._numbers import Floats, count
from ._progress import ProgressArgument, shown, warn
from ._theta import Theta
from .errors import CaseError
from .results import Answers, Corrections, Estimate, Fields, Predictions

if TYPE_CHECKING:
    from .case import Case, Path

__all__ = ["Emulator"]


class Emulator:
    """An emulator of one case, from `Case.train` or `Case.load`."""

    def __init__(self, case: Case, native: NativeEmulator) -> None:
        self.case = case
        self._native = native

    def __reduce__(self) -> tuple[Any, ...]:
        return _revived, (self.case, _files.stored(self.save))

    def __repr__(self) -> str:
        return f"<Emulator of {self.case.name}: {self}>"

    def __str__(self) -> str:
        lines = [self._native.words]
        error = self.median_error
        if np.isfinite(error):
            lines.append(f"error on the held-out cases: median {error:.1e}, largest {self.largest_error:.1e} of the displacement")
        return "\n".join(lines)

    @property
    def record(self) -> dict[str, Any]:
        """How it was made and how it did: simulations, times, candidates, errors on the held-out cases."""
        found: dict[str, Any] = json.loads(self._native.record)
        return found

    @property
    def warnings(self) -> list[str]:
        """Reasons not to trust it."""
        return self._native.warnings

    def _held_out(self, quantile: str) -> float:
        held_out = self.record["held_out"]
        return float("nan") if held_out is None else float(held_out["relative"][quantile])

    @property
    def median_error(self) -> float:
        """Median over the held-out cases of the mean nodal error relative to the mean nodal displacement."""
        return self._held_out("q50")

    @property
    def largest_error(self) -> float:
        """Largest of these errors."""
        return self._held_out("max")

    def predict(self, theta: Theta = None, *, refine: int = 0, progress: ProgressArgument = None) -> Predictions:
        """Displacements; θ as in `Case.solve`. `refine` takes quasi-Newton steps with a frozen stiffness for all."""
        sets = _theta.read(self.case._native, theta)
        with shown(progress) as bar:
            displacement, warnings = self._native.predict(sets.rows, count(refine, "refine"), bar)
        return Predictions(self.case, sets.pick(sets.values), sets.pick(displacement), warnings)

    def estimate(self, prediction: Predictions, *, progress: ProgressArgument = None) -> Estimate:
        """How far a prediction is from equilibrium, by Newton steps from it that contract, or why there is no telling."""
        if not isinstance(prediction, Fields):
            raise CaseError(f"estimate takes what `predict` gives, not a {type(prediction).__name__}")
        if prediction.case is not self.case:
            raise CaseError("the prediction is of another case; estimate it by an emulator of its own")
        sets = _theta.read(self.case._native, prediction.theta)
        with shown(progress) as bar:
            found = self._native.estimate(sets.rows, prediction._rows(), bar)
        return _estimate(found, sets)

    def correct(self, theta: Theta = None, steps: int = 1, *, progress: ProgressArgument = None) -> Corrections:
        """Predictions after Newton steps, each of which about squares the error."""
        sets = _theta.read(self.case._native, theta)
        with shown(progress) as bar:
            found = self._native.correct(sets.rows, count(steps, "steps"), bar)
        values, displacement = sets.pick(sets.values), sets.pick(found["displacement"])
        return Corrections(self.case, values, displacement, found["set_warnings"], _estimate(found, sets))

    def answers(self, thetas: Theta, accuracy: float = 1e-3, *, progress: ProgressArgument = None) -> Answers:
        """Displacements to a relative accuracy, from this emulator's predictions where that costs least."""
        return self.case.answers(thetas, accuracy, emulator=self, progress=progress)

    def sensitivity(self, theta: Theta = None) -> Floats:
        """Derivative of the displacement by each parameter [mm per unit of the parameter], (p, nodes, 3), at one θ."""
        return self._native.sensitivity(_theta.read(self.case._native, theta).single().rows)

    def page(self, path: Path, *, progress: ProgressArgument = None) -> dict[str, str]:
        """Writes one self-contained page for a browser, as `sinew export --page`: the body with a slider for every parameter, and its error. Returns what was
        measured of the page, by name."""
        _files.check_page(path)
        with shown(progress) as bar:
            html, facts, notes = self._native.page(bar)
        warn([*self._native.doubts(), *notes])
        pathlib.Path(path).write_bytes(html.encode())
        return dict(facts)

    def save(self, folder: Path) -> None:
        """Stores it in a folder, for `Case.load` and for the program `sinew`."""
        self._native.save(folder)


def _revived(case: Case, files: dict[str, bytes]) -> Emulator:
    """The emulator that files hold."""
    return _files.restored(files, case.load)


def _estimate(found: dict[str, Any], sets: _theta.Sets) -> Estimate:
    names = ("mean", "largest", "energy_norm", "relative", "residual")
    return Estimate(**{name: sets.pick(found[name]) for name in names}, words=found["words"])
