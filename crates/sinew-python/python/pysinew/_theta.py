"""Parameter sets, as users give them."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Union

import numpy as np
from numpy.typing import NDArray

from ._native import NativeCase
from ._numbers import Floats, floats, unmasked
from .errors import CaseError

# One set: {"mu": 12.0, "p": "8 mmHg"} or p numbers. Several: a table n × p, a list of such sets, or a dictionary whose values
# are columns. None: the middle of the ranges.
Theta = Union[None, Mapping[str, Any], Sequence[Any], NDArray[Any]]


# A path of one parameter: "p=0..8mmHg", or {"p": (0, "8 mmHg")}.
Way = Union[str, Mapping[str, Any]]


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
    names = [name for name, *_ in case.parameters]
    named = values_by_name(theta, names)
    if named is not None:
        return _by_name(case, named)
    if isinstance(theta, Sequence) and not isinstance(theta, str):
        sets = [values_by_name(each, names) for each in theta]
        if any(each is not None for each in sets):
            return np.stack([_one(case, named or each) for named, each in zip(sets, theta)]), False
    table = floats(theta, "theta")
    if table.ndim not in (1, 2) or table.shape[-1] != len(names):
        raise CaseError(
            f"theta of shape {table.shape}: the case has {len(names)} parameters ({', '.join(names)}); give one number each, or a "
            f"row of them for every set"
        )
    return table


def way(along: Any) -> tuple[str, str]:
    """Name of the parameter of a path, and the path as the program reads it."""
    if isinstance(along, str):
        return along.partition("=")[0].strip(), along
    given = list(along.items()) if isinstance(along, Mapping) else []
    if len(given) != 1 or isinstance(given[0][1], str) or not hasattr(given[0][1], "__len__") or len(given[0][1]) != 2:
        raise CaseError(f"along = {along!r}: give one parameter with two ends, such as \"p=0..8mmHg\" or {{\"p\": (0, \"8 mmHg\")}}")
    head, ends = given[0]
    [(name, start)], [(_, end)] = (pairs({head: value}) for value in (ends[0], ends[1]))
    return name, f"{name}={start}..{end}"


def values_by_name(theta: Any, names: list[str]) -> Union[Mapping[str, Any], None]:
    """Values by the names that frames, rows of them, named tuples and xarray carry; None where there are none."""
    if isinstance(theta, Mapping):
        return theta
    if head("", theta):
        raise CaseError(f"theta: an array in {head('', theta)[2:-1]}; give each parameter its own unit: a dataset or a dictionary")
    if hasattr(theta, "columns") and hasattr(theta, "to_numpy"):
        return _paired(theta.columns, [theta[name].to_numpy() for name in theta.columns])
    if isinstance(theta, tuple) and hasattr(theta, "_fields"):
        return _paired(theta._fields, theta)
    found = labels_of(theta)
    if found is None:
        return None
    by_text = [axis for axis, labels in enumerate(found) if labels and all(isinstance(each, str) for each in labels)]
    by_text.sort(key=lambda axis: not {each.partition("[")[0].strip() for each in found[axis]} & set(names))
    if by_text:
        return _paired(found[by_text[0]], np.moveaxis(np.asarray(theta), by_text[0], 0))
    if not hasattr(theta, "dims") and found[0] != list(range(len(found[0]))):
        raise CaseError("theta: the labels of a series are neither names of parameters nor 0, 1, …; give its values alone")
    return None


def _paired(names: Any, values: Any) -> dict[str, Any]:
    pairs = {str(name): value for name, value in zip(names, values)}
    if len(pairs) < len(names):
        raise CaseError(f"theta: a name is there twice among {', '.join(str(name) for name in names)}; keep one")
    return pairs


def labels_of(value: Any) -> Union[list[list[Any]], None]:
    """Labels along each axis of a series or an array of xarray; None of other objects."""
    if hasattr(value, "dims") and hasattr(value, "coords"):
        return [np.asarray(value.coords[dim]).tolist() if dim in value.coords else [] for dim in value.dims]
    if hasattr(value, "to_numpy") and not callable(getattr(value, "index", len)):
        return [list(value.index)]
    return None


def by_axes(values: Any, what: str, unit: str | None = None) -> Any:
    """Vectors along the last axis as x, y, z: by the labels of that axis where it has any, else by place."""
    if (own := head("", values)[2:-1]) not in ("", unit or "mm"):
        raise CaseError(f"{what}: they are in {own}; give unit={own!r} beside them")
    labels = list(values.columns) if hasattr(values, "columns") else (labels_of(values) or [[]])[-1]
    if not labels or labels == list(range(len(labels))):
        return values
    if labels not in ([*"xy"], [*"xyz"]) and sorted(map(str, labels)) != [*"xyz"]:
        raise CaseError(f"{what}: components are labelled {', '.join(map(str, labels))}; label them x, y, z, or give their values alone")
    return np.asarray(values)[..., [labels.index(axis) for axis in sorted(labels)]]


def text(name: str, value: Any) -> str:
    """A value as a case file would hold it."""
    if isinstance(value, str):
        return value
    unmasked(value, f"theta: {name}")
    if np.ndim(value) == 0 and hasattr(value, "item"):
        value = value.item()
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise CaseError(f"theta: {name} is a {type(value).__name__}; give a number, or a text such as \"12 kPa\"")
    return repr(float(value))


def head(name: Any, value: Any) -> str:
    """A name with its unit, such as `p [mmHg]`: its own, or that which an array of xarray carries."""
    unit = getattr(value, "attrs", {}).get("units", "1")
    return str(name) if unit in ("1", "", None) or "[" in str(name) else f"{name} [{unit}]"


def pairs(theta: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Names and values as texts; a head with a unit gives the value that unit."""
    found = []
    for name, value in theta.items():
        own, _, unit = head(name, value).partition("[")
        said = text(str(name), value)
        found.append((own.strip(), f"{said} {unit.strip().rstrip(']')}" if unit else said))
    return found


def _one(case: NativeCase, theta: Any) -> Floats:
    if not isinstance(theta, Mapping):
        raise CaseError(f"theta: a {type(theta).__name__} stands among sets by name; give them all in one way")
    return case.theta(pairs(theta))


def _by_name(case: NativeCase, theta: Mapping[str, Any]) -> tuple[Floats, bool]:
    columns = {name: value for name, value in theta.items() if not isinstance(value, str) and np.ndim(value) > 0}
    labels = [found for found in map(labels_of, columns.values()) if found is not None]
    if any(found != labels[0] for found in labels):
        raise CaseError("theta: columns with different labels; put them into one frame, or give their values alone")
    heads = {}
    for name, column in columns.items():
        unmasked(column, f"theta: {name}")
        heads[name] = head(name, column)
        # By place, whatever the labels are.
        columns[name] = column if labels_of(column) is None else np.asarray(column)
    if not columns:
        return _one(case, theta)[np.newaxis], True
    count = max(len(column) for column in columns.values())
    for name, column in columns.items():
        if np.ndim(column) != 1:
            raise CaseError(f"theta: {name} of shape {np.shape(column)}; give a column of numbers")
        if len(column) != count:
            raise CaseError(f"theta: {name} has {len(column)} values where another parameter has {count}; give columns of one length")
    rows = [
        _one(case, {heads.get(name, name): columns[name][row] if name in columns else value for name, value in theta.items()})
        for row in range(count)
    ]
    if not rows:
        raise CaseError("theta: no parameter set; give at least one")
    return np.stack(rows), False
