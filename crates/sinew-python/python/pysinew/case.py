"""Cases: a mesh, a law, fibres, loads, supports and ranges of parameters."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, Union, get_args
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from . import _meshes, _numbers, _theta, _views, posterior
from ._native import NativeCase, calibrate, check_calibration, scenes, synthesise
from ._numbers import Floats
from ._progress import ProgressArgument, shown, warn
from ._theta import Theta, Way
from .errors import CaseError, SolveError
from .posterior import Check, Posterior
from .results import Answers, MeshCheck, Solutions

if TYPE_CHECKING:
    from .emulator import Emulator

__all__ = ["Case", "Parameter", "Unloaded"]

Path = Union[str, "PathLike[str]"]
Recipe = Literal["taylor", "regression", "pi", "dd"]
Optimiser = Literal["muon", "adam"]
Design = Literal["latin-hypercube", "sobol", "uniform"]
# Files of a calibration that an earlier one in the same folder may have left.
_WRITTEN = ("posterior.csv", "posterior.json", "edpvr.csv", "rest.vtu", "report.html", "report.json", "provenance.json")
# Cases that went to another process or came from one, by what they are made of.
_alive: WeakValueDictionary[tuple[str, str, bool, bytes], Case] = WeakValueDictionary()


@dataclass(frozen=True)
class Parameter:
    """A free parameter with its range, in its own unit; `sampling` is `log` or `linear`."""

    name: str
    unit: str
    low: float
    high: float
    sampling: str


def _plain(value: Any) -> Any:
    """Keys of a case file as JSON knows them."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, PathLike):
        return os.fspath(value)
    raise CaseError(f"a {type(value).__name__} has no place in a case; give numbers, texts, lists or dictionaries")


def _json(keys: Mapping[str, Any], what: str) -> str:
    """Keys as the compiled half reads them; those that are None are left out."""
    try:
        text = json.dumps(keys, default=_plain, allow_nan=False)
        given = json.loads(text, object_hook=lambda table: {key: value for key, value in table.items() if value is not None})
        return json.dumps(given)
    except ValueError as error:
        if isinstance(error, CaseError):
            raise
        raise CaseError(f"{what} is not finite") from error


def _listed(value: Any, what: str) -> list[Any]:
    if isinstance(value, (str, Mapping)) or not hasattr(value, "__iter__"):
        raise CaseError(f"{what} = {value!r}: give a list of dictionaries")
    return list(value)


class Case:
    """A body with its parameters θ, from a case file, a built-in scene, or a mesh in memory.

    `mesh` is one of meshio or pyvista, a pair (points, cells), the path of a file, or keys of `[mesh]` in a case file such as
    `{"box": {"extent": [100, 10, 10], "cells": [12, 4, 5]}}`. The other arguments are the keys of a case file. Lengths are in
    mm unless `unit` says otherwise, stresses in kPa.
    """

    _native: NativeCase

    def __init__(
        self,
        *,
        mesh: Any,
        law: Union[str, Mapping[str, Any]],
        parameters: Mapping[str, Any],
        supports: Sequence[Mapping[str, Any]],
        loads: Sequence[Mapping[str, Any]] = (),
        fibres: Mapping[str, Any] | None = None,
        active: bool | Mapping[str, Any] | None = None,
        stiffness: Mapping[str, Any] | None = None,
        select: Mapping[str, Any] | None = None,
        formulation: str | None = None,
        training: Mapping[str, Any] | None = None,
        phases: Mapping[str, Any] | None = None,
        data: Sequence[Mapping[str, Any]] | None = None,
        calibration: Mapping[str, Any] | None = None,
        name: str = "case",
        unit: str | None = None,
        merge: bool = False,
        node_sets: Mapping[str, Any] | None = None,
        facet_sets: Mapping[str, Any] | None = None,
    ) -> None:
        keys: dict[str, Any] = {
            "name": _numbers.words(name, "name"),
            "law": law,
            "formulation": formulation and _numbers.words(formulation, "formulation"),
            "parameters": parameters,
            "supports": _listed(supports, "supports"),
            "loads": _listed(loads, "loads"),
            "fibres": fibres,
            "active": active,
            "stiffness": stiffness,
            "select": select,
            "training": training,
            "phases": phases,
            "data": data,
            "calibration": calibration,
        }
        source: dict[str, Any] = {} if unit is None else {"unit": unit}
        merge = _numbers.flag(merge, "merge")
        given = None
        if isinstance(mesh, (Mapping, str, PathLike)):
            keys_of_mesh = mesh if isinstance(mesh, Mapping) else {"file": os.fspath(mesh)}
            if unit is not None and keys_of_mesh.get("unit") not in (None, unit):
                raise CaseError(f"unit = {unit!r}, but the keys of the mesh have {keys_of_mesh['unit']!r}; give one")
            source = {**keys_of_mesh, **source, **({"merge": True} if merge else {})}
        else:
            given = _meshes.read(mesh, node_sets, facet_sets, merge, unit)
        if given is None and (node_sets or facet_sets):
            raise CaseError("node_sets and facet_sets belong to a mesh in memory; name sets of another by place with `select`")
        keys["mesh"] = source
        self._open(NativeCase.from_json(_json(keys, f"{name}: a number of the case"), name, given))

    def _open(self, native: NativeCase) -> None:
        self._native = native
        warn(native.warnings())

    @classmethod
    def _of(cls, native: NativeCase) -> Case:
        case = cls.__new__(cls)
        case._open(native)
        return case

    @classmethod
    def read(cls, path: Path) -> Case:
        """A case file. A mesh file in it is relative to it."""
        if not os.path.exists(path):
            raise CaseError(f"there is no case file {os.fspath(path)}; `Case.scene` opens built-in scenes")
        return cls._of(NativeCase.read(path))

    @classmethod
    def scene(cls, name: str) -> Case:
        """A built-in scene by its name; `Case.scenes` lists them."""
        if _numbers.words(name, "name").lower() not in (known.lower() for known in scenes()):
            raise CaseError(f"there is no scene `{name}`; scenes: {', '.join(scenes())}")
        return cls._of(NativeCase.read(name))

    @staticmethod
    def scenes() -> list[str]:
        """Names of the built-in scenes."""
        return scenes()

    @classmethod
    def parse(cls, text: str, name: str = "case") -> Case:
        """A case from the text of a case file."""
        return cls._of(NativeCase.parse(_numbers.words(text, "text"), _numbers.words(name, "name")))

    @cached_property
    def _state(self) -> tuple[str, str, bool, bytes]:
        state = self._native.state()
        _alive.setdefault(state, self)
        return state

    def __reduce__(self) -> tuple[Any, ...]:
        return _revived, self._state

    def __repr__(self) -> str:
        names = ", ".join(parameter.name for parameter in self.parameters)
        return f"<Case {self.name}: {len(self.points)} nodes, {len(self.cells)} cells, parameters {names}>"

    @cached_property
    def _width(self) -> int:
        """Numbers of a displacement."""
        return 3 * len(self.points)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self._native.name

    @property
    def text(self) -> str:
        """The case as the text of a case file; a mesh in memory is not in it."""
        return self._native.text

    @property
    def parameters(self) -> list[Parameter]:
        """Free parameters, in the order of θ."""
        return [Parameter(*each) for each in self._native.parameters]

    @property
    def points(self) -> Floats:
        """Nodes in the reference configuration [mm], (nodes, 3)."""
        return self._native.points

    @property
    def cells(self) -> NDArray[np.int64]:
        """Nodes of the cells in VTK's order, (cells, nodes of a cell)."""
        return self._native.cells

    @property
    def node_sets(self) -> dict[str, NDArray[np.int64]]:
        """Nodes of each named set."""
        return self._native.sets[0]

    @property
    def facet_sets(self) -> dict[str, NDArray[np.int64]]:
        """Nodes of the facets of each named set, (facets, nodes of a facet)."""
        return self._native.sets[1]

    def quadratic(self) -> Case:
        """The case in quadratic cells, to see what linear ones lose; its first nodes are the same."""
        return Case._of(self._native.quadratic())

    def to_pyvista(self) -> Any:
        """The mesh as a `pyvista.UnstructuredGrid`."""
        return _views.pyvista_of(self)

    def to_meshio(self) -> Any:
        """The mesh as a `meshio.Mesh`."""
        return _views.meshio_of(self)

    def sample(
        self,
        count: int,
        seed: int = 1,
        design: Design = "latin-hypercube",
    ) -> Floats:
        """Parameter sets within the ranges, (count, p), in the parameters' own units. Same seed, same numbers."""
        count, seed = _numbers.count(count, "count", 1, _numbers.MOST_SETS), _numbers.count(seed, "seed")
        _numbers.choice(design, get_args(Design), "design")
        return self._native.shown(self._native.sample(count, seed, design))

    def solve(
        self,
        theta: Theta = None,
        *,
        load_steps: bool = False,
        along: Way | None = None,
        frames: int | None = None,
        folder: Path | None = None,
        progress: ProgressArgument = None,
    ) -> Solutions:
        """Equilibria by the solver, on all cores.

        θ is a dictionary (`{"mu": 12.0, "p": "8 mmHg"}`, or with columns as values), p numbers, a table n × p, or None for the
        middle of the ranges. `load_steps` raises the load step by step from rest. In a `folder` solutions are kept as they are
        made, and found again by a call with the same θ; those of `load_steps` are in a folder `load_steps` in it.

        `along` is a path of one parameter, as `"p=0..8mmHg"` or `{"p": (0, "8 mmHg")}`, in `frames` steps (20 unless told), each of which starts from
        the equilibrium before. θ gives the other parameters, and there is one set more than steps. Frames behind the end of the path, where the body
        snaps, are failures.

        Raises `SolveError` where one set was asked for and has no equilibrium; of several, failures are listed.
        """
        if along is not None:
            if load_steps or folder is not None:
                raise CaseError("along starts at rest by load steps and keeps no folder; leave load_steps and folder out")
            frames = 20 if frames is None else _numbers.count(frames, "frames", 1)
            if frames > 10_000:
                raise CaseError(f"frames = {frames}: give 10000 at most")
            return self._along(theta, along, frames, progress)
        if frames is not None:
            raise CaseError("frames are those of a path; give along as well")
        sets = _theta.read(self._native, theta)
        warn(self._native.outside(sets.rows))
        with shown(progress) as bar:
            found = self._native.solve(sets.rows, _numbers.flag(load_steps, "load_steps"), folder, bar)
        warn(found["warnings"])
        failures = dict(found["failures"])
        self._refuse(sets, failures)
        if failures:
            row, reason = next(iter(failures.items()))
            warn([f"{len(failures)} of {len(sets.rows)} sets have no equilibrium, the first is set {row}: {reason}"])
        empty: list[list[str]] = [[] for _ in sets.rows]
        picked = map(sets.pick, (sets.values, found["displacement"], found["seconds"], found["pressure"]))
        values, displacement, seconds, pressure = picked
        return Solutions(self, values, displacement, empty, failures, seconds, pressure)

    def _along(self, theta: Theta, along: Way, frames: int, progress: ProgressArgument) -> Solutions:
        name, way = _theta.way(along)
        middle = dict(zip([own.name for own in self.parameters], self._native.shown(self._native.centre()[np.newaxis])[0]))
        named = None if theta is None else _theta.values_by_name(theta, list(middle))
        if named is not None:
            # The path has all values of its own.
            others = {head: value for head, value in named.items() if str(head).partition("[")[0].strip() != name}
            # A path of no parameter is refused below.
            theta = {**others, name: middle[name]} if name in middle else None
        rows = _theta.read(self._native, theta).single().rows
        with shown(progress) as bar:
            found = self._native.along(rows, way, frames, bar)
        thetas, end = found["theta"], found["end"]
        # Values of the other parameters, and both ends.
        outside = self._native.outside(thetas[[0, -1]])
        warn([*outside, *found["warnings"], *([] if end is None else [f"{found['found']} of {len(thetas)} frames were found: {end}"])])
        failures = {frame: end for frame in range(found["found"], len(thetas))}
        empty: list[list[str]] = [[] for _ in thetas]
        seconds = np.full(len(thetas), np.nan)
        return Solutions(self, self._native.shown(thetas), found["displacement"], empty, failures, seconds, found["pressure"])

    def check_mesh(self, theta: Theta = None, *, progress: ProgressArgument = None) -> MeshCheck:
        """How far the equilibrium at one θ is from that in quadratic cells: what the case's own cells lose."""
        # One set, so that a failure is raised.
        theta = _theta.read(self._native, theta).single().values[0]
        kind = {6: "quadratic triangles", 8: "hexahedra", 10: "quadratic tetrahedra"}.get(self.cells.shape[1])
        if kind is not None:
            raise CaseError(f"check_mesh: quadratic cells are not made of {kind}; compare with a finer mesh")
        better = self.quadratic()
        own, other = (case.solve(theta, progress=progress).one().ravel() for case in (self, better))
        mean, largest, loss, volumes, words = self._native.compared(own, better._native, other)
        return MeshCheck(mean, largest, loss, {name: (ours, theirs) for name, (ours, theirs) in volumes}, words)

    def sensitivity(self, theta: Theta = None) -> Floats:
        """Derivative of the equilibrium's displacement by each parameter [mm per unit of the parameter], (p, nodes, 3), at one θ."""
        return self._native.sensitivity(_theta.read(self._native, theta).single().rows)

    def _refuse(self, sets: _theta.Sets, failures: dict[int, str]) -> None:
        """Raises where one set was asked for and failed."""
        if sets.one and failures:
            raise SolveError(f"{self._native.in_words(sets.rows[0])}: {failures[0]}")

    def answers(
        self,
        thetas: Theta,
        accuracy: float = 1e-3,
        *,
        emulator: Emulator | None = None,
        progress: ProgressArgument = None,
    ) -> Answers:
        """Displacements to a relative accuracy by the method that costs least, every one with its checked error."""
        sets = _theta.read(self._native, thetas)
        warn(self._native.outside(sets.rows))
        if emulator is not None and getattr(emulator, "case", None) is not self:
            raise CaseError("the emulator is none of this case; call `answers` of its own, `emulator.case`")
        accuracy = _numbers.number(accuracy, "accuracy")
        native = None if emulator is None else emulator._native
        with shown(progress) as bar:
            found = self._native.answers(sets.rows, accuracy, native, bar)
        warn(found["warnings"])
        failures = dict(found["failures"])
        self._refuse(sets, failures)
        values, displacement, error = map(sets.pick, (sets.values, found["displacement"], found["error"]))
        return Answers(self, values, displacement, found["set_warnings"], error, found["source"], failures, accuracy, found["method"])

    def train(
        self,
        recipe: Recipe | None = None,
        *,
        samples: int | None = None,
        target: float | None = None,
        minutes: float | None = None,
        seed: int | None = None,
        held_out: int | None = None,
        design: Design | None = None,
        network: Mapping[str, Any] | None = None,
        optimiser: Optimiser | None = None,
        learning_rate: float | None = None,
        batch: int | None = None,
        folder: Path | None = None,
        resume: bool = False,
        restart: bool = False,
        progress: ProgressArgument = None,
    ) -> Emulator:
        """An emulator: `regression` of some solutions (the default), or `taylor`, a Taylor expansion about one.

        Arguments replace those of the case's `training`. In a `folder` everything is kept as it is made: a run that was stopped
        goes on with `resume`, one that is there is replaced with `restart`.

        Networks (`pi`, `dd`) read `network`, a dictionary of their sizes such as `{"virtual_nodes": [97, 24]}`,
        `optimiser`, `learning_rate` and `batch`; other recipes refuse them.
        """
        from .emulator import Emulator

        given = {
            "recipe": recipe,
            "samples": samples,
            "target": target,
            "minutes": minutes,
            "seed": seed,
            "held_out": held_out,
            "design": design,
            "network": network,
            "optimiser": optimiser,
            "learning_rate": learning_rate,
            "batch": batch,
        }
        given = {key: value for key, value in given.items() if value is not None}
        for key in {"samples", "held_out", "batch"} & given.keys():
            given[key] = _numbers.count(given[key], key, 0, _numbers.MOST_SETS)
        if "seed" in given:
            given["seed"] = _numbers.count(given["seed"], "seed")
        for key in {"target", "minutes", "learning_rate"} & given.keys():
            given[key] = _numbers.number(given[key], key)
        if not isinstance(given.get("network", {}), Mapping):
            raise CaseError(f"network = {network!r}: give a dictionary of its sizes, such as {{'virtual_nodes': [97, 24]}}")
        for key, choices in {"recipe": Recipe, "design": Design, "optimiser": Optimiser}.items():
            if key in given:
                _numbers.choice(given[key], get_args(choices), key)
        options = _json(given, "train: a number")
        resume, restart = _numbers.flag(resume, "resume"), _numbers.flag(restart, "restart")
        with shown(progress) as bar:
            locking = self._native.locking(bar)
        warn([] if locking is None else [locking])
        with shown(progress) as bar:
            native = self._native.train(options, folder, resume, restart, bar)
        warn(native.doubts())
        return Emulator(self, native)

    def load(self, folder: Path) -> Emulator:
        """An emulator of this case that `Emulator.save`, `train(folder=)` or `sinew train` stored."""
        from .emulator import Emulator

        return Emulator(self, self._native.load(folder))

    def unload(
        self,
        theta: Theta = None,
        *,
        fibres: Literal["carried", "kept"] = "carried",
        progress: ProgressArgument = None,
    ) -> Unloaded:
        """The body at rest whose loading gives this case's mesh, an image under load. Fibres of the image move with the tissue, or are
        `kept` as the same vectors."""
        if fibres not in ("carried", "kept"):
            raise CaseError(f"fibres = {fibres!r}: give \"carried\" or \"kept\"")
        rows = _theta.read(self._native, theta).single().rows
        warn(self._native.outside(rows))
        with shown(progress) as bar:
            native, found = self._native.unload(rows, fibres == "kept", bar)
        warn(found["warnings"])
        return Unloaded(
            Case._of(native), found["displacement"], found["distance"], tuple(found["volume_ratios"]), found["iterations"]
        )

    def calibrate(
        self,
        *,
        seed: int | None = None,
        budget: float | None = None,
        folder: Path | None = None,
        resume: bool = False,
        restart: bool = False,
        progress: ProgressArgument = None,
    ) -> Posterior:
        """The posterior of the parameters, of a case whose mesh is an image and which has `phases` and `data`. Every draw is corrected by
        the solver; `calibration` of the case sets how.

        `seed` replaces that of the case. A `budget` [s] ends with an error when it is over. In a `folder` all solves are kept as they are made, and
        the files of `sinew calibrate` are written, its page among them. A run that was stopped goes on with `resume`, to the same numbers; `restart`
        solves everything anew.

        Raises `CalibrationError` where the solver does not confirm a posterior.
        """
        seed = None if seed is None else _numbers.count(seed, "seed")
        resume, restart = _numbers.flag(resume, "resume"), _numbers.flag(restart, "restart")
        if folder is None and (resume or restart):
            raise CaseError("resume and restart are about stored solves; name their folder")
        if resume and restart:
            raise CaseError("resume goes on from stored solves and restart starts anew without them; give one")
        budget = None if budget is None else _numbers.positive(budget, "budget")
        if folder is not None and not os.path.exists(os.path.join(folder, "solves.csv")):
            theirs = [name for name in _WRITTEN if os.path.exists(os.path.join(folder, name))]
            if theirs:
                raise CaseError(f"{os.fspath(folder)} holds {theirs[0]} of something else; name another folder")
        with shown(progress) as bar:
            groups, words, doubts = calibrate(self._native, seed, budget, folder, (resume, restart), bar)
        warn(doubts)
        return posterior.read(self, json.loads(groups), words)

    def check_calibration(self, *, budget: float | None = None, progress: ProgressArgument = None) -> Check:
        """Whether the model calibrates the data, before anything is sampled: as `sinew calibrate --check`, with its verdict."""
        budget = None if budget is None else _numbers.positive(budget, "budget")
        with shown(progress) as bar:
            found = check_calibration(self._native, budget, bar)
        warn(found["warnings"])
        return Check(found["verdict"], dict(found["theta"]), dict(found["misfits"]), found["words"])

    def synthesise(self, theta: Mapping[str, Any], seed: int = 1) -> Case:
        """The case with data that the solver gives at θ by name, with noise of their standard deviations."""
        theta = _theta.values_by_name(theta, []) or theta
        if not isinstance(theta, Mapping):
            raise CaseError(f"theta: a {type(theta).__name__} has no names; give a dictionary")
        return Case._of(synthesise(self._native, _theta.pairs(theta), _numbers.count(seed, "seed")))


def _revived(*state: Any) -> Case:
    """The case of a state, whose doubts were told where it was made first."""
    case = _alive.get(state)
    if case is None:
        case = Case.__new__(Case)
        case._native = NativeCase.revived(*state)
        case.__dict__["_state"] = state
        _alive[state] = case
    return case


@dataclass(frozen=True, eq=False)
class Unloaded:
    """A body at rest.

    Attributes:
        case: The case at rest, ready to be solved.
        displacement: From the body at rest to the image [mm], (nodes, 3).
        distance: Largest distance of a node from its image after loading from rest [mm].
        volume_ratios: Least and largest volume of a cell at rest relative to that in the image.
        iterations: Newton iterations.
    """

    case: Case
    displacement: Floats
    distance: float
    volume_ratios: tuple[float, ...]
    iterations: int
