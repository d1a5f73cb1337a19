"""Posteriors of parameters, for arviz and for people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ._numbers import Floats

if TYPE_CHECKING:
    from .case import Case

__all__ = ["Check", "Posterior"]


@dataclass(frozen=True, eq=False)
class Check:
    """Whether a model calibrates data, at the most likely parameters and before anything is sampled.

    Attributes:
        verdict: `calibrates`, `does not` or `cannot tell`.
        theta: Most likely parameters by name, in their own units.
        misfits: Distance of each datum from what the body does there [standard deviations], by the name of the datum.
        words: The same for people, line by line; the first is the verdict with the number that decides.
    """

    verdict: Literal["calibrates", "does not", "cannot tell"]
    theta: dict[str, float]
    misfits: dict[str, float]
    words: list[str]

    def __str__(self) -> str:
        return "\n".join(self.words)


@dataclass(frozen=True, eq=False)
class Posterior:
    """Draws of a posterior, by chain and draw.

    Attributes:
        case: The case with its data, by whose solver the draws are; None of an emulator of stored runs.
        groups: Arrays by name, (chains, draws), in the groups of arviz: `posterior`, `prior`, `posterior_predictive`; measured values in
            `observed_data`; in `log_likelihood` the array `data`, (chains, draws, data). Names end with the unit, such as `mu [kPa]`.
        words: The result for people, line by line.
        labels: `coords` and `dims` of arviz: names of the data along the dimension `datum`.
    """

    case: Case | None
    groups: dict[str, dict[str, Floats]]
    words: list[str]
    labels: dict[str, dict[str, list[str]]]

    def __str__(self) -> str:
        return "\n".join(self.words)

    @property
    def names(self) -> list[str]:
        """Parameters and derived volumes."""
        return list(self.groups["posterior"])

    def __getitem__(self, name: str) -> Floats:
        """Draws of a parameter or volume by its name, with or without its unit, (chains, draws)."""
        found = [own for own in self.names if name in (own, own.split(" [")[0])]
        if not found:
            raise KeyError(f"{name} is not in this posterior; there are: {', '.join(self.names)}")
        return self.groups["posterior"][found[0]]

    def to_arviz(self) -> Any:
        """An arviz `InferenceData`, with arviz 1 the `xarray.DataTree` that replaced it. `arviz.loo` and `arviz.compare` take it."""
        import arviz

        named: dict[str, Any] = {**self.groups, **self.labels}
        return arviz.from_dict(**named) if arviz.__version__.startswith("0.") else arviz.from_dict(self.groups, **self.labels)


def read(case: Case | None, groups: dict[str, dict[str, Any]], words: list[str]) -> Posterior:
    """A posterior of lists."""
    labels = {key: groups.pop(key, {}) for key in ("coords", "dims")}
    arrays = {name: {own: np.asarray(values) for own, values in group.items()} for name, group in groups.items()}
    return Posterior(case, arrays, words, labels)
