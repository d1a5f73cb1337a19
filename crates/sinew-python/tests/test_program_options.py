"""What options of the program give, in Python: checks of a calibration and of a mesh, paths, pages, runs that go on."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from pysinew import CalibrationError, Case, CaseError, Posterior, SinewWarning

from conftest import BAR
from test_calibration import PATIENT, TRUTH

LATER = '{ volume = "endo", phase = "later", unit = "mL", sd = "0.3 %" }'
# Two data, one more than parameters, and few draws: the solver confirms a posterior of one parameter by them as well.
SMALL = (
    PATIENT.replace('late = { p = "16 mmHg" }', 'late = { p = "16 mmHg" }, later = { p = "20 mmHg" }').replace('"0.3 %" }]', f'"0.3 %" }}, {LATER}]')
    + "calibration = { draws = 60, design = 16, checks = 25 }\n"
)


@pytest.fixture(scope="module")
def patient() -> Case:
    return Case.parse(SMALL, "patient").synthesise({"mu": TRUTH}, seed=2)


@pytest.fixture(scope="module")
def program() -> str:
    program = os.environ.get("SINEW_PROGRAM")
    if program is None:
        pytest.skip("SINEW_PROGRAM names no program sinew to compare with")
    return program


def test_a_check_has_the_verdict_of_the_program(patient: Case, program: str, tmp_path: Path) -> None:
    found = patient.check_calibration(progress=False)
    assert found.verdict == "calibrates" and str(found).startswith("the model calibrates these data: ")
    assert 0.5 * TRUTH < found.theta["mu"] < 2.0 * TRUTH and abs(found.misfits["volume of endo at late"]) < 3.0
    (tmp_path / "patient.toml").write_text(patient.text)
    told = subprocess.run([program, "calibrate", "patient.toml", "--check"], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert told.stdout.splitlines() == found.words and not (tmp_path / "out").exists()
    # The first volume as one that no stiffness gives beside the second.
    far = re.sub(r"value = ([\d.]+)", lambda found: f"value = {1.05 * float(found[1])}", patient.text, count=1)
    found = Case.parse(far, "far").check_calibration(progress=False)
    assert found.verdict == "does not" and max(map(abs, found.misfits.values())) > 3.0


def test_a_calibration_goes_on_from_its_folder(patient: Case, program: str, tmp_path: Path) -> None:
    folder = tmp_path / "out" / "calibrate"
    budget, solves = 0.1, folder / "solves.csv"
    # Longer on a slow machine, until a solve is kept.
    while not solves.exists() or len(solves.read_text().splitlines()) < 2:
        budget *= 2.0
        with pytest.raises(CalibrationError, match="the budget of .* s is over .* go on with resume and a larger budget"):
            patient.calibrate(folder=folder, budget=budget, restart=solves.exists(), progress=False)
    with pytest.raises(CalibrationError, match="resume goes on from them, restart starts anew"):
        patient.calibrate(folder=folder, progress=False)
    resumed, at_once = (patient.calibrate(**keys, progress=False) for keys in ({"folder": folder, "resume": True}, {}))
    assert isinstance(resumed, Posterior) and np.array_equal(resumed["mu"], at_once["mu"])
    (tmp_path / "patient.toml").write_text(patient.text)
    subprocess.run([program, "calibrate", "patient.toml", "--out", "theirs"], cwd=tmp_path, check=True, capture_output=True)
    for name in ("posterior.csv", "edpvr.csv", "rest.vtu"):
        assert (folder / name).read_bytes() == (tmp_path / "theirs" / "calibrate" / name).read_bytes(), name
    assert "the solver confirms this posterior" in (folder / "report.html").read_text()


def test_settings_of_a_calibration_that_make_no_sense_are_told(patient: Case, tmp_path: Path) -> None:
    for keys, said in [
        ({"budget": 0}, "budget = 0: give a number above 0"),
        ({"budget": "60s"}, "budget = '60s': give a finite number"),
        ({"budget": float("nan")}, "budget = nan"),
        ({"resume": True}, "name their folder"),
        ({"folder": tmp_path, "resume": True, "restart": True}, "give one"),
    ]:
        with pytest.raises(CaseError, match=said):
            patient.calibrate(**keys, progress=False)
    with pytest.raises(CaseError, match="budget = -1"):
        patient.check_calibration(budget=-1, progress=False)


def test_a_path_is_that_of_the_program(bar: Case, program: str, tmp_path: Path) -> None:
    found = bar.solve({"lambda": 12.0}, along={"mu": (16.0, "8 kPa")}, frames=4, progress=False)
    assert found.theta.tolist() == [[mu, 12.0] for mu in (16.0, 14.0, 12.0, 10.0, 8.0)] and found.failures == {}
    with pytest.warns(SinewWarning) as told:
        bar.solve({"lambda": 17.0}, along="mu=16..20", frames=2, progress=False)
    said = " ".join(str(warning.message) for warning in told)
    assert "lambda = 17 kPa is outside its range" in said and "mu = 20 kPa is outside its range" in said
    by_text = bar.solve([9.0, 12.0], along="mu=16..8", frames=4, progress=False)
    assert np.array_equal(by_text.displacement, found.displacement)
    (tmp_path / "bar.toml").write_text(BAR)
    command = [program, "solve", "bar.toml", "--along", "mu=16..8", "--frames", "4", "--theta", "lambda=12", "--out", "out"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    last = pytest.importorskip("meshio").read(tmp_path / "out" / "solve" / "0004.vtu")
    assert np.array_equal(last.point_data["displacement"], found.displacement[4])


def test_a_path_that_ends_lists_the_frames_behind_its_end() -> None:
    # A wall that bears no high pressure.
    balloon = Case(
        mesh={"ellipsoid": {"short": [20.0, 22.0], "long": [52.0, 54.0], "base": 15.0, "cells": [1, 8, 4]}},
        law="neo-hookean",
        parameters={"mu": [5.0, 50.0], "lambda": [50.0, 500.0], "p": {"range": [0.0, 100.0], "sampling": "linear"}},
        loads=[{"pressure": "p", "facets": "endo"}],
        supports=[{"clamped": "base"}],
    )
    with pytest.warns(SinewWarning, match="frames were found: the path ends between"):
        found = balloon.solve({"mu": 5.0, "lambda": 50.0}, along={"p": (0.0, 100.0)}, frames=4, progress=False)
    first = min(found.failures)
    assert list(found.failures) == list(range(first, 5)) and "the path ends between" in found.failures[first]
    assert np.isfinite(found.displacement[:first]).all() and np.isnan(found.displacement[first:]).all()


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"along": "nu=9..12"}, "along nu=9..12: `nu` is not a parameter"),
        ({"along": "mu=9"}, "along mu=9: give a parameter and two ends"),
        ({"along": {"mu": 9.0}}, "give one parameter with two ends"),
        ({"along": {"mu": (9.0, 12.0), "lambda": (9.0, 12.0)}}, "give one parameter with two ends"),
        ({"along": {"mu": (9.0, np.nan)}}, "not a finite number"),
        ({"along": {"mu": (-9.0, 12.0)}}, "mu = -9"),
        ({"along": "mu=9..12", "frames": 0}, "frames = 0: give a whole number, 1 or more"),
        ({"along": "mu=9..12", "load_steps": True}, "leave load_steps and folder out"),
        ({"along": "mu=9..12", "theta": [[9.0, 12.0], [10.0, 12.0]]}, "one set"),
        ({"frames": 3}, "give along as well"),
    ],
)
def test_a_path_that_makes_no_sense_is_told(bar: Case, keys: dict, said: str) -> None:
    with pytest.raises(CaseError) as error:
        bar.solve(**keys, progress=False)
    assert said in str(error.value)


def test_a_mesh_is_checked_as_by_the_program(bar: Case, program: str, tmp_path: Path) -> None:
    found = bar.check_mesh({"mu": 10.0, "lambda": 12.0}, progress=False)
    own, better = bar.solve([10.0, 12.0]).displacement, bar.quadratic().solve([10.0, 12.0]).displacement[: len(bar.points)]
    distances = np.linalg.norm(own - better, axis=1)
    # Sums in another order.
    assert np.allclose([found.mean, found.largest], [distances.mean(), distances.max()], rtol=1e-12, atol=0.0)
    assert 0.2 < found.loss < 1.0 and found.volumes == {}
    (tmp_path / "bar.toml").write_text(BAR)
    told = subprocess.run(
        [program, "solve", "bar.toml", "--theta", "mu=10,lambda=12", "--check-mesh"], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    assert str(found) in told.stdout
    with pytest.raises(CaseError, match="quadratic cells are not made of quadratic tetrahedra; compare with a finer mesh"):
        bar.quadratic().check_mesh()


def test_a_page_is_that_of_the_program(bar: Case, program: str, tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(BAR)

    def run(*arguments: str) -> str:
        return subprocess.run([program, *arguments, "--out", "out"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout

    run("train", "bar.toml", "--recipe", "regression", "--samples", "9", "--target", "0")
    told = run("export", "bar.toml", "--page")
    facts = bar.load(tmp_path / "out" / "regression").page(tmp_path / "own.html", progress=False)
    assert (tmp_path / "own.html").read_bytes() == (tmp_path / "out" / "regression.html").read_bytes()
    assert facts and all(f"{name}: {value}" in told for name, value in facts.items())
    with pytest.raises(CaseError, match="page is HTML"):
        bar.load(tmp_path / "out" / "regression" / "emulator").page(tmp_path / "own.txt")
