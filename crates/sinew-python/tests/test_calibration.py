"""Posteriors: those of the program, right about a known truth, and open to arviz."""

from __future__ import annotations

import os
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest

from pysinew import Case, CaseError, Posterior

PATIENT = """
law = { name = "neo-hookean-isochoric", bulk_modulus = 100.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
mesh.ellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [1, 8, 4] }
parameters = { mu = [5.0, 50.0], p = { range = [0.0, 30.0], unit = "mmHg", sampling = "linear" } }
phases = { image = { p = "8 mmHg" }, late = { p = "16 mmHg" } }
data = [{ volume = "endo", phase = "late", unit = "mL", sd = "0.3 %" }]
"""
TRUTH = 18.0


@pytest.fixture(scope="module")
def patient() -> Case:
    return Case.parse(PATIENT, "patient").synthesise({"mu": TRUTH}, seed=2)


@pytest.fixture(scope="module")
def posterior(patient: Case) -> Posterior:
    return patient.calibrate(progress=False)


def test_the_interval_holds_the_truth(posterior: Posterior) -> None:
    low, high = np.quantile(posterior["mu"], [0.025, 0.975])
    assert low < TRUTH < high and high - low < 0.5 * TRUTH
    assert np.array_equal(posterior["mu"], posterior["mu [kPa]"]) and posterior["mu"].ndim == 2
    assert "the solver confirms this posterior" in str(posterior)
    with pytest.raises(KeyError, match="mu"):
        posterior["nu"]


def test_arviz_reads_it(posterior: Posterior) -> None:
    arviz = pytest.importorskip("arviz")
    data = posterior.to_arviz()
    assert np.array_equal(data.posterior["mu [kPa]"].values, posterior["mu"])
    datum = "volume of endo at late"
    assert data.posterior_predictive[datum].shape == posterior["mu"].shape and datum in data.observed_data
    assert float(arviz.summary(data, var_names=["mu [kPa]"])["r_hat"].iloc[0]) < 1.02
    likelihood = data.log_likelihood["data"]
    assert likelihood.dims == ("chain", "draw", "datum") and list(likelihood.datum.values) == [datum]
    # The largest is that of a normal error of 0.3 %, per mL.
    volume = float(posterior.groups["observed_data"][datum])
    assert abs(float(likelihood.max()) + np.log(np.sqrt(2.0 * np.pi) * 0.003 * volume)) < 0.05
    with warnings.catch_warnings():
        # Without its only datum the posterior is the prior, which weights do not reach.
        warnings.simplefilter("ignore")
        found = arviz.loo(data)
    assert np.isfinite(found.elpd_loo if hasattr(found, "elpd_loo") else found.elpd)


def test_draws_are_those_of_the_program_to_the_bit(patient: Case, posterior: Posterior, tmp_path: Path) -> None:
    program = os.environ.get("SINEW_PROGRAM")
    if program is None:
        pytest.skip("SINEW_PROGRAM names no program sinew to compare with")
    (tmp_path / "patient.toml").write_text(patient.text)
    subprocess.run([program, "calibrate", "patient.toml", "--out", "out"], cwd=tmp_path, check=True, capture_output=True)
    table = np.genfromtxt(tmp_path / "out" / "calibrate" / "posterior.csv", delimiter=",", skip_header=1)
    assert np.array_equal(table[:, 2], posterior["mu"].ravel())


def test_keys_and_a_mesh_in_memory_are_a_patient_too(patient: Case, posterior: Posterior) -> None:
    value = float(posterior.groups["observed_data"]["volume of endo at late"])
    made = Case(
        mesh=(patient.points, patient.cells),
        node_sets={"base": patient.node_sets.get("base", np.unique(patient.facet_sets["base"]))},
        facet_sets={"endo": patient.facet_sets["endo"]},
        law={"name": "neo-hookean-isochoric", "bulk_modulus": 100.0},
        loads=[{"pressure": "p", "facets": "endo"}],
        supports=[{"clamped": "base"}],
        parameters={"mu": [5.0, 50.0], "p": {"range": [0.0, 30.0], "unit": "mmHg", "sampling": "linear"}},
        phases={"image": {"p": "8 mmHg"}, "late": {"p": "16 mmHg"}},
        data=[{"volume": "endo", "phase": "late", "value": value, "unit": "mL", "sd": 0.003 * value}],
        calibration={"seed": 5},
    )
    other = made.calibrate(progress=False)
    # Draws by another seed: means agree to their standard errors.
    assert abs(other["mu"].mean() - posterior["mu"].mean()) < 0.2 * posterior["mu"].std()


def test_what_is_no_patient_is_told(bar: Case, patient: Case) -> None:
    with pytest.raises(CaseError, match="phases|data"):
        bar.calibrate(progress=False)
    with pytest.raises(CaseError, match="mu"):
        patient.synthesise({"nu": 18.0})
    with pytest.raises(CaseError, match="give a dictionary"):
        patient.synthesise([18.0])
    data = [case.text for case in (patient.synthesise({"mu [kPa]": 18.0}), patient.synthesise({"mu": "18000 Pa"}))]
    assert data[0] == data[1]
