"""Numbers that users give, as arrays of doubles; what is no finite number is refused."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import CaseError

Floats = NDArray[np.float64]


def unmasked(values: Any, what: str) -> None:
    """Refuses masked entries of an array, or of the arrays in a list."""
    each = values if isinstance(values, (list, tuple)) else [values]
    if any(np.ma.is_masked(array) for array in each):
        raise CaseError(f"{what}: masked entries have no value; leave them out or fill them")


def floats(values: Any, what: str) -> Floats:
    """An array of finite doubles in C order, whatever its order, stride or number type was."""
    unmasked(values, what)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise CaseError(f"{what}: rows of different lengths; give as many numbers in each") from error
    if array.dtype.kind not in "fiu":
        raise CaseError(f"{what}: numbers are needed, not {array.dtype}")
    result: Floats = np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)
    bad = np.argwhere(~np.isfinite(result))
    if len(bad):
        place = ", ".join(str(index) for index in bad[0])
        raise CaseError(f"{what}: {result[tuple(bad[0])]} at [{place}] is not a finite number")
    return result


MOST_SETS = 10**8
"""Most parameter sets, as in the program."""


def count(value: Any, what: str, least: int = 0, most: int = 2**63 - 1) -> int:
    """A whole number that is neither too small nor too large."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Integral) or not least <= int(value) <= most:
        bound = f", at most {most}" if most == MOST_SETS else ""
        raise CaseError(f"{what} = {value!r}: give a whole number, {least} or more{bound}")
    return int(value)


def number(value: Any, what: str) -> float:
    """A finite number."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real) or not np.isfinite(float(value)):
        raise CaseError(f"{what} = {value!r}: give a finite number")
    return float(value)


def positive(value: Any, what: str) -> float:
    """A finite number above 0."""
    if number(value, what) <= 0.0:
        raise CaseError(f"{what} = {value!r}: give a number above 0")
    return float(value)


def flag(value: Any, what: str) -> bool:
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise CaseError(f"{what} = {value!r}: give True or False")
    return bool(value)


def words(value: Any, what: str) -> str:
    """A text."""
    if not isinstance(value, str):
        raise CaseError(f"{what} = {value!r}: give a text")
    return value


def choice(value: Any, choices: tuple[str, ...], what: str) -> str:
    """One of some words."""
    if value not in choices:
        raise CaseError(f"{what} = {value!r}: give one of {', '.join(choices)}")
    return str(value)


def indices(values: Any, what: str) -> NDArray[np.int64]:
    """An array of whole numbers, 0 or more."""
    unmasked(values, what)
    array = np.asarray(values)
    if array.size and array.dtype.kind not in "iu":
        raise CaseError(f"{what}: whole numbers are needed, not {array.dtype}")
    if array.size and int(array.min()) < 0:
        raise CaseError(f"{what}: {int(array.min())} is not the number of a node or cell; give 0 or more")
    return np.ascontiguousarray(array, dtype=np.int64)
