"""Emulators of stored runs of any solver, without a case."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Union

import numpy as np

from . import _files, _meshes, _theta, posterior
from ._native import NativeRuns
from ._numbers import Floats, count, floats
from ._progress import ProgressArgument, shown, warn
from .errors import CaseError
from .posterior import Posterior

__all__ = ["LeftOut", "Runs"]

Path = Union[str, pathlib.Path]
# Chains of a posterior.
CHAINS = 4


@dataclass(frozen=True)
class LeftOut:
    """Error of an output in runs that were predicted from the others.

    Attributes:
        error: Root mean square, of displacements over nodes [unit].
        r_squared: One less the share of the variance that is unexplained.
        unit: Unit of the output.
    """

    error: float
    r_squared: float
    unit: str


class Runs:
    """Gaussian processes of numbers or displacements over parameters, from runs of any solver.

    runs = Runs.of_table({"mu [kPa]": mu, "lambda [kPa]": lam}, {"volume [ml]": volume})
    volume, error = runs.predict({"mu": 75.0, "lambda": 80.0})["volume"]
    """

    def __init__(self, native: NativeRuns) -> None:
        self._native = native

    def __repr__(self) -> str:
        return f"<Runs: {', '.join(self.left_out)} by {', '.join(self.parameters)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _revived, (_files.stored(self.save),)

    @staticmethod
    def of_table(theta: Any, outputs: Any, *, progress: ProgressArgument = None) -> Runs:
        """From columns by name, which may end with their unit: dictionaries or frames, a row per run."""
        inputs, results = _columns(theta, "theta"), _columns(outputs, "outputs")
        _same_labels([*inputs.values(), *results.values()], "theta and outputs")
        found = [(name, unit, column[:, np.newaxis]) for name, unit, column in _read(results, "outputs")]
        return Runs._fit(_read(inputs, "theta"), found, None, progress)

    @staticmethod
    def of_fields(theta: Any, displacements: Any, mesh: Any, *, unit: str = "1", progress: ProgressArgument = None) -> Runs:
        """From displacements (runs, nodes, 3) on a mesh of meshio or pyvista, or (points, cells), in its unit, which `unit` may name."""
        array = floats(_theta.by_axes(displacements, "displacements", None if unit == "1" else unit), "displacements")
        if array.ndim != 3 or array.shape[2] != 3:
            raise CaseError(f"displacements of shape {array.shape}; give (runs, nodes, 3)")
        results = [("displacement", unit, array.reshape(len(array), -1))]
        inputs = _columns(theta, "theta")
        _same_labels([*inputs.values(), displacements], "theta and displacements")
        return Runs._fit(_read(inputs, "theta"), results, _meshes.read(mesh), progress)

    @staticmethod
    def _fit(columns: Any, results: Any, mesh: Any, progress: ProgressArgument) -> Runs:
        counts = {len(column) for _, _, column in [*columns, *results]}
        if len(counts) > 1:
            raise CaseError(f"columns of {' and '.join(str(n) for n in sorted(counts))} runs; give the same runs in all")
        heads = [(name, unit) for name, unit, _ in columns]
        table = np.stack([column for _, _, column in columns], axis=1)
        with shown(progress) as bar:
            return Runs(NativeRuns.fit(heads, table, results, mesh, bar))

    @staticmethod
    def load(folder: Path) -> Runs:
        """From a folder of `save` or of `sinew train --from-table`."""
        native = NativeRuns.load(pathlib.Path(folder))
        warn(native.warnings)
        return Runs(native)

    def save(self, folder: Path) -> None:
        """Stores it in a folder, for `load` and `sinew predict`."""
        self._native.save(pathlib.Path(folder))

    @property
    def parameters(self) -> dict[str, tuple[float, float]]:
        """Ranges of the runs by name."""
        return {name: (low, high) for name, _, (low, high) in self._native.parameters}

    @property
    def left_out(self) -> dict[str, LeftOut]:
        """Errors of runs left out, by output."""
        return {name: LeftOut(error, r_squared, unit) for name, unit, error, r_squared in self._native.left_out}

    def predict(self, theta: Any) -> dict[str, tuple[Floats, Floats]]:
        """Values by output and half-widths of their 95 % intervals: a number each for one θ, arrays for columns or rows of θ.
        Displacements are (nodes, 3), and their half-width is that of the root mean square nodal error."""
        rows, one = self._rows(theta)
        warn([text for row in rows for text in self._native.outside(list(row))])
        found: dict[str, tuple[Floats, Floats]] = {}
        for (name, *_), (values, widths) in zip(self._native.left_out, self._native.predict(rows)):
            shaped = values.reshape(len(rows), -1, 3) if self._native.of_fields else values[:, 0]
            found[name] = (shaped[0], widths[0]) if one else (shaped, widths)
        return found

    def posterior(
        self,
        data: Mapping[str, tuple[float, float]],
        *,
        seed: int = 0,
        draws: int = 4000,
        progress: ProgressArgument = None,
    ) -> Posterior:
        """Draws of the parameters given values and standard deviations of outputs, by the emulator alone: no solver confirms them."""
        if not isinstance(data, Mapping):
            raise CaseError(f"data: a {type(data).__name__} has no names; give a dictionary of values with their standard deviations")
        measured = []
        units = {name: unit for name, unit, *_ in self._native.left_out}
        for name, pair in data.items():
            numbers = floats(pair, f"data: {name}")
            if numbers.shape != (2,):
                raise CaseError(f"data: {name} of shape {numbers.shape}; give its value and its standard deviation")
            measured.append((_own(_theta.head(name, pair), units, "data"), float(numbers[0]), float(numbers[1])))
        each = -(-count(draws, "draws") // CHAINS)
        with shown(progress) as bar:
            groups, words, warnings = self._native.posterior(measured, count(seed, "seed"), each, bar)
        warn(warnings)
        return posterior.read(None, json.loads(groups), words)

    def page(self, path: Path) -> dict[str, str]:
        """Writes one self-contained page for a browser, as `sinew export --page`: the displacements with a slider for every parameter, and their error.
        Returns what was measured of the page, by name."""
        _files.check_page(path)
        html, facts, notes = self._native.page()
        warn([*self._native.warnings, *notes])
        pathlib.Path(path).write_bytes(html.encode())
        return dict(facts)

    def _rows(self, theta: Any) -> tuple[Floats, bool]:
        names = list(self.parameters)
        named = _theta.values_by_name(theta, names)
        if named is not None:
            units = {name: unit for name, unit, _ in self._native.parameters}
            given = {_own(_theta.head(name, value), units, "theta"): value for name, value in named.items()}
            if len(given) < len(named):
                raise CaseError(f"theta: a name is there twice among {', '.join(map(str, named))}; keep one")
            if set(given) != set(names):
                raise CaseError(f"theta has {', '.join(given)}; the parameters are {', '.join(names)}")
            _same_labels(given.values(), "theta")
            columns = [floats(given[name], f"theta: {name}") for name in names]
            try:
                array = np.stack(np.broadcast_arrays(*columns), axis=-1)
            except ValueError as error:
                raise CaseError("theta: columns of different lengths; give as many values in each") from error
        else:
            array = floats(theta, "theta")
        if array.ndim not in (1, 2) or array.shape[-1] != len(names) or array.size == 0:
            raise CaseError(f"theta of shape {array.shape}; give {', '.join(names)}, or a row of them for every set")
        return np.ascontiguousarray(np.atleast_2d(array)), array.ndim == 1


def _revived(files: dict[str, bytes]) -> Runs:
    """The emulator that files hold."""
    return _files.restored(files, Runs.load)


def _head(text: Any) -> tuple[str, str]:
    """Name and unit of a column such as `mu [kPa]`."""
    name, _, unit = str(text).partition("[")
    return name.strip(), unit.strip().rstrip("]").strip()


def _own(text: Any, units: Mapping[str, str], what: str) -> str:
    """Name of a column, whose unit is that of the runs if it has one."""
    name, unit = _head(text)
    own = units.get(name, unit)
    if unit and unit != own:
        raise CaseError(f"{what}: {name} is in {unit} here and in {own} in the runs; give it in {own}")
    return name


def _same_labels(columns: Iterable[Any], what: str) -> None:
    """Refuses columns whose rows have different labels."""
    labels = [found[0] for found in map(_theta.labels_of, columns) if found and found[0]]
    if any(other != labels[0] for other in labels[1:]):
        raise CaseError(f"{what}: columns have different labels; align them, or give their values alone")


def _columns(table: Any, what: str) -> dict[str, Any]:
    """Columns by their heads."""
    if hasattr(table, "columns") and hasattr(table, "to_numpy"):
        return {str(name): table[name] for name in table.columns}
    if isinstance(table, Mapping) and table:
        return {_theta.head(name, column): column for name, column in table.items()}
    raise CaseError(f"{what}: {'there are no columns' if isinstance(table, Mapping) else f'a {type(table).__name__} has no names'}; "
                    "give a dictionary of columns, or a frame")


def _read(columns: Mapping[str, Any], what: str) -> list[tuple[str, str, Floats]]:
    """Names, units and values of columns."""
    found = []
    for head, values in columns.items():
        column = floats(values, f"{what}: {head}")
        if column.ndim != 1:
            raise CaseError(f"{what}: {head} of shape {column.shape}; give a number per run")
        name, unit = _head(head)
        found.append((name, unit or "1", column))
    return found
