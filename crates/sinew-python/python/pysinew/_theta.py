"""Parameter sets, as users give them."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Union

import numpy as np

from ._native import NativeCase
from ._numbers import Floats, floats
from .errors import CaseError

# One set: {"mu": 12.0, "p": "8 mmHg"} or p numbers. Several: a table n × p, a list of such sets, or a dictionary whose values
# are columns. None: the middle of the ranges.
Theta = Union[None, Mapping[str, Any], Sequence[Any], Floats]


class Sets(NamedTuple):
    """Parameter sets, a row each."""

    #: In the units of the scene.
    rows: Floats
    #: In the parameters' own units.
    values: Floats
    #: Whether one set was given rather than a list of them.
    one: bool

    def pick(self, found: Any) -> Any:
        """What was found for every set, or for the one."""
        return np.asarray(found[0]) if self.one else found

    def single(self) -> Sets:
        """Requires one set."""
        if not self.one:
            raise CaseError(f"theta: give one set of parameters, not {len(self.rows)}")
        return self


def read(case: NativeCase, theta: Any) -> Sets:
    """Parameter sets as users give them."""
    table = _table(case, theta)
    if isinstance(table, tuple):
        rows, one = table
        return Sets(rows, case.shown(rows), one)
    values = np.atleast_2d(table)
    return Sets(case.in_scene(values), values, table.ndim == 1)


def _table(case: NativeCase, theta: Any) -> Union[Floats, tuple[Floats, bool]]:
    """Numbers in the parameters' own units; or rows in those of the scene, and whether one set was given."""
    if theta is None:
        return case.centre()[np.newaxis], True
    if hasattr(theta, "columns") and hasattr(theta, "to_numpy"):
        theta = {str(name): theta[name].to_numpy() for name in theta.columns}
    if isinstance(theta, Mapping):
        return _by_name(case, theta)
    if isinstance(theta, Sequence) and theta and isinstance(theta[0], Mapping):
        return np.stack([_one(case, each) for each in theta]), False
    table = floats(theta, "theta")
    names = [name for name, *_ in case.parameters]
    if table.ndim not in (1, 2) or table.shape[-1] != len(names):
        raise CaseError(
            f"theta of shape {table.shape}: the case has {len(names)} parameters ({', '.join(names)}); give one number each, or a "
            f"row of them for every set"
        )
    return table


def text(name: str, value: Any) -> str:
    """A value as a case file would hold it."""
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise CaseError(f"theta: {name} is a {type(value).__name__}; give a number, or a text such as \"12 kPa\"")
    return repr(float(value))


def _one(case: NativeCase, theta: Any) -> Floats:
    if not isinstance(theta, Mapping):
        raise CaseError(f"theta: a {type(theta).__name__} stands among sets by name; give them all in one way")
    return case.theta([(str(name), text(str(name), value)) for name, value in theta.items()])


def _by_name(case: NativeCase, theta: Mapping[str, Any]) -> tuple[Floats, bool]:
    lengths = {
        name: len(value)
        for name, value in theta.items()
        if not isinstance(value, str) and np.ndim(value) > 0
    }
    if not lengths:
        return _one(case, theta)[np.newaxis], True
    count = max(lengths.values())
    for name, length in lengths.items():
        if length != count or np.ndim(theta[name]) != 1:
            raise CaseError(f"theta: {name} has {length} values where another parameter has {count}; give columns of one length")
    rows = [
        _one(case, {name: value[row] if name in lengths else value for name, value in theta.items()})
        for row in range(count)
    ]
    if not rows:
        raise CaseError("theta: no parameter set; give at least one")
    return np.stack(rows), False
