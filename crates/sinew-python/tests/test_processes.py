"""Cases, results and emulators in other processes, and copies."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from pysinew import Case, SinewWarning

from conftest import BAR

THETA = [10.0, 12.0]


def elsewhere(thing: object, tmp_path: Path, program: str) -> np.ndarray:
    """What a program makes of a pickled thing in a process of its own."""
    (tmp_path / "thing").write_bytes(pickle.dumps(thing))
    read = "import pathlib, pickle, numpy as np; thing = pickle.loads(pathlib.Path('thing').read_bytes())"
    command = [sys.executable, "-c", f"{read}; np.save('made', {program})"]
    subprocess.run(command, cwd=tmp_path, check=True)
    return np.load(tmp_path / "made.npy")


def test_a_case_is_the_same_in_another_process(bar: Case, tmp_path: Path) -> None:
    (tmp_path / "cases").mkdir()
    bar.solve(THETA).write(tmp_path / "cases" / "bar.vtu")
    # A mesh file beside the case, in another unit and with a set by place.
    text = BAR.replace('mesh.box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }', 'mesh = { file = "bar.vtu", unit = "cm" }')
    text = text.replace('clamped = "x_min"', 'clamped = "left"')
    text += "select.left = { plane = { point = [0.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }\n"
    (tmp_path / "cases" / "bar.toml").write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        read = Case.read(tmp_path / "cases" / "bar.toml")
        at_rest = bar.unload({"mu": 14.0, "lambda": 14.0}).case
    for case in (bar, bar.quadratic(), read, at_rest):
        found = elsewhere(case, tmp_path, f"thing.solve({THETA}).displacement")
        assert np.array_equal(found, case.solve(THETA).displacement)


def test_results_and_emulators_are_the_same_in_another_process(bar: Case, emulator, tmp_path: Path) -> None:
    solution, prediction = bar.solve(THETA), emulator.predict(THETA)
    found = elsewhere((solution, emulator), tmp_path, "np.stack([thing[0].displacement, thing[1].predict(thing[0].theta).displacement])")
    assert np.array_equal(found, [solution.displacement, prediction.displacement])
    # Back here a case is the one that is there.
    again = pickle.loads(pickle.dumps(prediction))
    assert again.case is bar and float(emulator.estimate(again).mean) == float(emulator.estimate(prediction).mean)


def test_copies_are_the_case(bar: Case, emulator) -> None:
    assert copy.deepcopy(bar) is bar and copy.copy(bar) is bar
    copied = copy.deepcopy(emulator)
    assert copied is not emulator and np.array_equal(copied.predict(THETA).displacement, emulator.predict(THETA).displacement)


def test_a_pool_of_processes_solves(bar: Case) -> None:
    thetas = bar.sample(4, seed=5)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = list(pool.map(bar.solve, thetas))
    assert all(one.case is bar for one in found)
    for one, theta in zip(found, thetas):
        assert np.array_equal(one.displacement, bar.solve(theta).displacement)
