"""Bodies that several tests solve."""

from __future__ import annotations

import warnings

import pytest

from pysinew import Case, SinewWarning

BAR = """
law = "neo-hookean"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh.box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }
parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
training = { held_out = 4 }
"""


@pytest.fixture(scope="session")
def bar() -> Case:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        return Case.parse(BAR, "bar")


@pytest.fixture(scope="session")
def emulator(bar: Case):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        return bar.train("regression", samples=9, target=0.0, progress=False)
