"""Emulators: predictions, their errors, corrections, sensitivities, answers."""

from __future__ import annotations

import os
import subprocess
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from pysinew import Case, CaseError, Emulator, EmulatorError, SinewWarning
from pysinew._native import NETWORKS

from conftest import BAR

THETA = {"mu": 10.0, "lambda": 12.0}


def test_a_prediction_knows_its_error(bar: Case, emulator) -> None:
    truth = bar.solve(THETA).displacement
    prediction = emulator.predict(THETA)
    estimate = emulator.estimate(prediction)
    actual = np.linalg.norm(prediction.displacement - truth, axis=1).mean()
    assert estimate.mean.shape == () and 0.5 * actual < estimate.mean < 2.0 * actual
    corrected = emulator.correct(THETA)
    after = np.linalg.norm(corrected.displacement - truth, axis=1).mean()
    assert after < 0.1 * actual and corrected.estimate.residual < estimate.residual
    assert "estimated error" in str(estimate)
    assert 0.0 < emulator.median_error <= emulator.largest_error < 0.1
    assert emulator.record["recipe"] == "regression" and "regression" in repr(emulator)


def test_several_sets_follow_theta(bar: Case, emulator) -> None:
    table = bar.sample(5, seed=9)
    prediction = emulator.predict(table)
    estimate = emulator.estimate(prediction)
    assert prediction.displacement.shape == (5, len(bar.points), 3) and estimate.mean.shape == (5,)
    refined = emulator.estimate(emulator.predict(table, refine=4))
    assert (refined.mean < estimate.mean).all()
    for row, theta in enumerate(table):
        assert np.array_equal(emulator.predict(theta).displacement, prediction.displacement[row])
    assert len(emulator.correct(table).warnings) == 5


def test_what_extrapolates_is_marked(emulator) -> None:
    inside, outside = emulator.predict([[10.0, 12.0], [20.0, 12.0]]).warnings
    assert inside == [] and "outside the trained range" in outside[0]


def test_sensitivities_are_derivatives_by_own_units() -> None:
    text = BAR.replace("mu = [8.0, 16.0]", 'mu = { range = [8000.0, 16000.0], unit = "Pa" }')
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        emulator = Case.parse(text).train("taylor", progress=False)
    theta = np.array([10_000.0, 12.0])
    found = emulator.sensitivity(theta)
    for k, step in enumerate((10.0, 0.01)):
        ahead, behind = theta.copy(), theta.copy()
        ahead[k] += step
        behind[k] -= step
        difference = (emulator.predict(ahead).displacement - emulator.predict(behind).displacement) / (2 * step)
        # Truncation of central differences over a thousandth of the value.
        assert np.abs(found[k] - difference).max() < 1e-4 * np.abs(difference).max()


def test_answers_are_within_what_is_asked_for(bar: Case, emulator) -> None:
    table = bar.sample(12, seed=5)
    truth = bar.solve(table).displacement
    for found in (bar.answers(table, 1e-4), emulator.answers(table, 1e-4)):
        assert found.within.all() and found.failures == {} and len(found.source) == 12
        error = np.linalg.norm(found.displacement - truth, axis=2).mean(axis=1) / np.linalg.norm(truth, axis=2).mean(axis=1)
        assert error.max() < 1e-4
    assert bar.answers(THETA).within
    with pytest.raises(CaseError, match="accuracy"):
        bar.answers(table, 2.0)


def test_an_emulator_is_stored_and_read(bar: Case, emulator, tmp_path: Path) -> None:
    emulator.save(tmp_path / "stored")
    again = bar.load(tmp_path / "stored")
    assert np.array_equal(again.predict(THETA).displacement, emulator.predict(THETA).displacement)
    with pytest.raises(EmulatorError, match="holds no emulator"):
        bar.load(tmp_path / "none")
    with pytest.raises(EmulatorError, match="another body"):
        Case.parse(BAR.replace("-9.8e-3", "-9.7e-3")).load(tmp_path / "stored")


def test_a_run_is_kept_and_refused_twice(bar: Case, tmp_path: Path) -> None:
    keys = dict(samples=4, target=0.0, folder=tmp_path / "run", progress=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        first = bar.train("regression", **keys)
        with pytest.raises(EmulatorError, match="finished"):
            bar.train("regression", **keys)
        resumed = bar.train("regression", resume=True, **keys)
    assert np.array_equal(first.predict(THETA).displacement, resumed.predict(THETA).displacement)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"recipe": "regresion"}, "regresion"),
        pytest.param({"recipe": "pi"}, "networks", marks=pytest.mark.skipif(NETWORKS, reason="this library has networks")),
        ({"minutes": -1.0}, "positive"),
        ({"held_out": 0}, "held-out"),
        ({"recipe": "regression", "learning_rate": 1e-3}, "learning_rate: the recipe `regression` trains no network"),
        ({"recipe": "dd", "batch": 0}, "batch: 0 is out of bounds; give 1 to 1024"),
        ({"recipe": "dd", "optimiser": "adm"}, "muon, adam"),
    ],
)
def test_a_training_that_makes_no_sense_is_refused(bar: Case, keys: dict, said: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        with pytest.raises((CaseError, EmulatorError)) as error:
            bar.train(**keys, progress=False)
    assert said in str(error.value)


def test_an_emulator_of_the_program_predicts_the_same_to_the_bit(bar: Case, tmp_path: Path) -> None:
    program = os.environ.get("SINEW_PROGRAM")
    if program is None:
        pytest.skip("SINEW_PROGRAM names no program sinew to compare with")
    (tmp_path / "bar.toml").write_text(BAR)

    def run(*arguments: str) -> None:
        subprocess.run([program, *arguments, "--out", "out"], cwd=tmp_path, check=True, capture_output=True)

    run("train", "bar.toml", "--recipe", "regression", "--samples", "9", "--target", "0")
    run("predict", "bar.toml", "--theta", "mu=10,lambda=12")
    theirs = np.load(tmp_path / "out" / "predict" / "regression" / "cases.npz")["displacement"][0]
    stored = bar.load(tmp_path / "out" / "regression" / "emulator").predict(THETA).displacement
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SinewWarning)
        trained = bar.train("regression", samples=9, target=0.0, progress=False).predict(THETA).displacement
    assert np.array_equal(stored, theirs) and np.array_equal(trained, theirs)


def test_a_thousand_predictions_cost_what_they_cost_in_rust(emulator, bar: Case) -> None:
    table = bar.sample(1000, seed=6, design="uniform")
    rows = bar._native.in_scene(table)
    found = emulator._native.predict(rows, 0, None)

    class Found:
        """Gives at once what the compiled half found."""

        def predict(self, *_: object) -> object:
            return found

    def least(call) -> float:
        times = []
        for _ in range(50):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
        return min(times)

    compiled = least(lambda: emulator._native.predict(rows, 0, None))
    added = least(lambda: Emulator(bar, Found()).predict(table))
    print(f"1000 predictions: {1e3 * compiled:.2f} ms in Rust and {1e3 * added:.2f} ms in Python")
    assert added <= 0.05 * compiled
