"""Emulators of stored runs of any solver, and posteriors by them."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

from pysinew import Case, CaseError, EmulatorError, Runs, SinewWarning


@pytest.fixture(scope="module")
def theta() -> dict[str, np.ndarray]:
    draws = np.random.default_rng(1).uniform(size=(40, 2))
    return {"k [kPa]": 1.0 + 9.0 * draws[:, 0], "angle [deg]": -60.0 + 120.0 * draws[:, 1]}


def truth(k: np.ndarray, angle: np.ndarray) -> dict[str, np.ndarray]:
    turned = np.radians(angle)
    return {"volume [ml]": 60.0 + 50.0 / k * (1.0 + 0.3 * np.sin(turned)), "strain": 0.1 * turned + 0.05 * np.sin(2.0 * turned)}


@pytest.fixture(scope="module")
def runs(theta: dict[str, np.ndarray]) -> Runs:
    return Runs.of_table(theta, truth(*theta.values()), progress=False)


def test_unseen_runs_are_within_their_intervals(runs: Runs, tmp_path: Path) -> None:
    assert runs.left_out["volume"].unit == "ml" and runs.left_out["volume"].r_squared > 0.99
    unseen = np.random.default_rng(2).uniform([1.5, -50.0], [9.0, 50.0], (100, 2))
    exact = truth(*unseen.T)
    found = runs.predict({"angle": unseen[:, 1], "k": unseen[:, 0]})
    for name, values in zip(("volume", "strain"), exact.values()):
        predicted, width = found[name]
        assert np.mean(np.abs(predicted - values) <= width) >= 0.85
    runs.save(tmp_path)
    again = Runs.load(tmp_path).predict(unseen)
    assert all(np.array_equal(again[name][0], found[name][0]) for name in found)
    one, width = runs.predict({"k": 3.0, "angle": 20.0})["volume"]
    assert np.ndim(one) == 0 and abs(one - truth(np.float64(3.0), np.float64(20.0))["volume [ml]"]) <= 3 * width
    with pytest.warns(SinewWarning, match="outside its range"):
        runs.predict({"k": 30.0, "angle": 20.0})


def test_measured_outputs_give_a_posterior(runs: Runs) -> None:
    exact = truth(np.float64(3.0), np.float64(-20.0))
    data = {"volume": (exact["volume [ml]"], 0.5), "strain": (exact["strain"], 0.005)}
    found = runs.posterior(data, progress=False)
    for name, value in (("k", 3.0), ("angle", -20.0)):
        low, high = np.quantile(found[name], [0.025, 0.975])
        assert low < value < high and high - low < 0.5 * abs(value)
    assert "no solver has confirmed it" in str(found)
    told: list[tuple[str, float]] = []
    again = runs.posterior(data, progress=lambda stage, fraction, left, message: told.append((stage, fraction)))
    assert np.array_equal(again["k"], found["k"])
    # Long enough to be told of.
    runs.posterior(data, draws=40_000, progress=lambda stage, fraction, left, message: told.append((stage, fraction)))
    assert {stage for stage, _ in told} == {"draw the posterior"} and all(0.0 < fraction <= 1.0 for _, fraction in told)
    # The likelihood is normal, with the variance of measurement and emulator.
    likelihood = found.groups["log_likelihood"]["data"]
    assert likelihood.shape == (*found["k"].shape, 2) and found.labels["coords"]["datum"] == ["volume [ml]", "strain"]
    largest = -0.5 * np.log(2.0 * np.pi * np.square([0.5, 0.005]))
    assert np.all(likelihood <= largest) and np.all(likelihood.max(axis=(0, 1)) > largest - 0.1)
    with pytest.raises(CaseError, match="did you mean"):
        runs.posterior({"volum": (70.0, 1.0)})
    with pytest.raises(CaseError, match="standard deviations from"):
        runs.posterior({"volume": (700.0, 1.0)})


def test_displacements_on_a_mesh_are_emulated(bar: Case, tmp_path: Path) -> None:
    solved = bar.solve(bar.sample(12), progress=False)
    fields = solved.displacement
    columns = {"mu [kPa]": solved.theta[:, 0], "lambda [kPa]": solved.theta[:, 1]}
    emulator = Runs.of_fields(columns, fields, (bar.points, bar.cells), progress=False)
    # The unit is that of the mesh, which only the user knows.
    assert emulator.left_out["displacement"].unit == "1"
    named = Runs.of_fields(columns, fields / 1000.0, (bar.points / 1000.0, bar.cells), unit="m", progress=False)
    assert named.left_out["displacement"].unit == "m"
    found, width = emulator.predict(solved.theta[3])["displacement"]
    error = np.sqrt(np.mean(np.sum((found - fields[3]) ** 2, axis=1)))
    assert found.shape == fields[3].shape and error <= 3 * width
    facts = emulator.page(tmp_path / "bar.html")
    assert "factor of 3" in facts["shown error"] and "sinewViewer" in (tmp_path / "bar.html").read_text()
    with pytest.raises(CaseError, match="page is HTML"):
        emulator.page(tmp_path / "bar.txt")
    with pytest.raises(EmulatorError, match="numbers in a run"):
        Runs.of_fields(columns, fields[:, 1:], (bar.points, bar.cells), progress=False)
    with pytest.raises(CaseError, match="leave nodes of no cell out"):
        Runs.of_fields(columns, fields, (np.vstack([bar.points, [9.0, 9.0, 9.0]]), bar.cells), progress=False)
    # Runs in another order, by their labels.
    xarray, pandas = pytest.importorskip("xarray"), pytest.importorskip("pandas")
    labelled = xarray.DataArray(fields, dims=("run", "node", "axis"), coords={"run": range(12)})
    with pytest.raises(CaseError, match="theta and displacements: columns have different labels"):
        Runs.of_fields(pandas.DataFrame(columns), labelled[::-1], (bar.points, bar.cells), progress=False)
    with pytest.raises(CaseError, match="they are positions"):
        Runs.of_fields(columns, fields + bar.points, (bar.points, bar.cells), progress=False)


def test_units_of_columns_are_those_of_the_runs(runs: Runs) -> None:
    assert runs.predict({"k [kPa]": 3.0, "angle [deg]": 20.0})["volume"] == runs.predict({"k": 3.0, "angle": 20.0})["volume"]
    with pytest.raises(CaseError, match="theta: k is in MPa here and in kPa in the runs"):
        runs.predict({"k [MPa]": 0.003, "angle": 20.0})
    with pytest.raises(CaseError, match="data: volume is in l here and in ml in the runs"):
        runs.posterior({"volume [l]": (0.07, 0.01)})


def test_runs_are_the_same_in_a_copy(runs: Runs) -> None:
    theta = {"k": 3.0, "angle": 20.0}
    assert pickle.loads(pickle.dumps(runs)).predict(theta) == copy.deepcopy(runs).predict(theta) == runs.predict(theta)


def test_names_and_labels_decide(theta: dict[str, np.ndarray], runs: Runs) -> None:
    pandas = pytest.importorskip("pandas")
    inputs, outputs = pandas.DataFrame(theta), pandas.DataFrame(truth(*theta.values()))
    whole, _ = runs.predict({"k": 3.0, "angle": 20.0})["volume"]
    row = pandas.Series({"angle": 20.0, "k": 3.0})
    assert runs.predict(row)["volume"][0] == whole
    assert np.array_equal(Runs.of_table(inputs, outputs, progress=False).predict(inputs)["volume"][0], runs.predict(theta)["volume"][0])
    with pytest.raises(CaseError, match="different labels"):
        Runs.of_table(inputs, outputs.sample(frac=1.0, random_state=1))
    with pytest.raises(CaseError, match="the parameters are k, angle"):
        runs.predict({"k": 3.0})
    with pytest.raises(CaseError, match="shape"):
        runs.predict(np.empty((0, 2)))
    with pytest.raises(CaseError, match="draws a chain"):
        runs.posterior({"volume [ml]": (75.0, 1.0)}, draws=8)


def test_doubts_are_told_again_where_runs_are_loaded(tmp_path: Path) -> None:
    k = np.linspace(1.0, 2.0, 30)
    with pytest.warns(SinewWarning, match="follows from the other parameters"):
        Runs.of_table({"k": k, "a": 1.0 + k + 1e-3 * np.sin(40.0 * k)}, {"v": k**2}, progress=False).save(tmp_path)
    with pytest.warns(SinewWarning, match="follows from the other parameters"):
        Runs.load(tmp_path)


def test_marks_of_failed_runs_are_told_with_their_rows(theta: dict[str, np.ndarray], tmp_path: Path) -> None:
    outputs = truth(*theta.values())
    outputs["volume [ml]"][[4, 11]] = -9999.0
    with pytest.warns(SinewWarning, match="volume is −9999 in run 4 and 1 more, far from all others"):
        runs = Runs.of_table(theta, outputs, progress=False)
    runs.save(tmp_path)
    with pytest.warns(SinewWarning, match="volume is −9999 in run 4"):
        Runs.load(tmp_path)


def test_bad_tables_say_what_to_give(theta: dict[str, np.ndarray]) -> None:
    outputs = truth(*theta.values())
    for table, results, reason in [
        (np.zeros((3, 2)), outputs, "has no names"),
        (theta, {"volume": np.full(40, np.nan)}, "not a finite number"),
        (theta, {"volume": np.full(40, 2.0)}, "is 2 in all runs"),
        (theta, {"volume": np.zeros(3)}, "3 and 40 runs"),
        ({"k": np.ones(40)}, outputs, "the same parameters"),
        ({"k": theta["k [kPa]"], "volume": theta["angle [deg]"]}, outputs, "is there twice"),
        (theta, {}, "there are no columns"),
    ]:
        with pytest.raises(CaseError, match=reason):
            Runs.of_table(table, results, progress=False)
