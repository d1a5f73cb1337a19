"""Mistakes are told in words of Python, warnings stand at the caller's line, and `help` tells of all there is."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable

import pytest

import pysinew
from pysinew import Case, CaseError, Emulator, SinewWarning

from conftest import BAR


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda e: e.case.sample(-1), "count = -1: give a whole number, 1 or more"),
        (lambda e: e.case.sample(2.5), "count = 2.5: give a whole number"),
        (lambda e: e.case.sample(10**30), "give a whole number"),
        (lambda e: e.case.sample(2, seed=-3), "seed = -3"),
        (lambda e: e.case.sample(2, design="random"), "design = 'random': give one of latin-hypercube, sobol, uniform"),
        (lambda e: e.case.train("magic"), "recipe = 'magic': give one of taylor, regression, pi, dd"),
        (lambda e: e.case.train("regression", samples=-4), "samples = -4"),
        (lambda e: e.case.train("regression", held_out=1.5), "held_out = 1.5"),
        (lambda e: e.case.train("regression", design="grid"), "design = 'grid'"),
        (lambda e: e.correct([10.0, 12.0], steps=-1), "steps = -1"),
        (lambda e: e.predict([10.0, 12.0], refine=-1), "refine = -1"),
        (lambda e: e.case.train("regression", target="low"), "target = 'low': give a finite number"),
        (lambda e: e.case.train("regression", minutes=float("nan")), "minutes = nan: give a finite number"),
        (lambda e: e.case.train("dd", learning_rate=True), "learning_rate = True: give a finite number"),
        (lambda e: e.case.train("dd", network={"virtual_nodes": [float("nan")]}), "train: a number is not finite"),
        (lambda e: e.case.train("dd", network=[97, 24]), "network = [97, 24]: give a dictionary"),
        (lambda e: e.case.train("regression", resume="yes"), "resume = 'yes': give True or False"),
        (lambda e: e.case.solve(load_steps=1), "load_steps = 1: give True or False"),
        (lambda e: e.case.solve(progress="bar"), "progress = 'bar': give None, False or a function"),
        (lambda e: e.case.answers([10.0, 12.0], "1e-3"), "accuracy = '1e-3': give a finite number"),
        (lambda e: e.case.answers([10.0, 12.0], emulator="regression"), "the emulator is none of this case"),
        (lambda e: e.estimate([10.0, 12.0]), "estimate takes what `predict` gives, not a list"),
        (lambda e: Case.scene(3), "name = 3: give a text"),
        (lambda e: Case.parse(b"law"), "text = b'law': give a text"),
        (lambda e: Case(mesh={}, law="neo-hookean", parameters={}, supports={"clamped": "x_min"}), "supports = {'clamped': 'x_min'}: give a list"),
        (lambda e: Case(mesh={}, law="neo-hookean", parameters={}, supports=[], loads=None), "loads = None: give a list of dictionaries"),
        (lambda e: e.case.calibrate(seed=-1), "seed = -1"),
        (lambda e: e.case.synthesise({"mu": 10.0}, seed=-1), "seed = -1"),
    ],
)
def test_counts_and_choices_are_told(emulator: Emulator, wrong: Callable[[Emulator], object], said: str) -> None:
    with pytest.raises(CaseError) as error:
        wrong(emulator)
    assert said in str(error.value)


def test_warnings_stand_at_the_line_of_the_caller(bar: Case) -> None:
    soft = BAR.replace("mu = [8.0, 16.0], lambda = [8.0, 16.0]", "mu = [8.0, 16.0], lambda = [8e3, 16e3]")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", SinewWarning)
        bar.solve([20.0, 12.0], progress=False)
        Case.parse(soft).train("regression", samples=2, held_out=2, progress=False)
    assert len(told) > 1 and {warning.filename for warning in told} == {__file__}
    # What has no meaning is refused, without a word about its range.
    with warnings.catch_warnings():
        warnings.simplefilter("error", SinewWarning)
        with pytest.raises(CaseError, match="mu = -10"):
            bar.solve([-10.0, 12.0])


def test_warnings_name_calls_of_python(bar: Case) -> None:
    with pytest.warns(SinewWarning) as told:
        bar.solve([10.0, 12.0], progress=False)
        bar.answers([10.0, 12.0], progress=False)
    words = [str(warning.message) for warning in told]
    assert len(words) == 2 and all("`Case.check_mesh` measures what is lost" in text for text in words)
    assert not any("sinew " in text for text in words)


def test_help_tells_of_every_attribute() -> None:
    for name in pysinew.__all__:
        thing = getattr(pysinew, name)
        if dataclasses.is_dataclass(thing):
            own = thing.__dict__.get("__annotations__", {})
            assert all(field in thing.__doc__ for field in own if name != "Parameter"), name
