"""`sinew serve` from Python: tinyDA samples the three models as a hierarchy and finds a known θ."""

from __future__ import annotations

import os
import subprocess
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

tda = pytest.importorskip("tinyDA")
umbridge = pytest.importorskip("umbridge")
stats = pytest.importorskip("scipy.stats")

CASE = """
law = "neo-hookean"
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
mesh.ellipsoid = { short = [22.0, 36.0], long = [58.0, 74.0], base = 0.0, cells = [1, 8, 4] }
parameters = { mu = [8.0, 16.0], lambda = 20.0, p = { range = [2.0, 6.0], unit = "mmHg" } }
training = { held_out = 4, recipe = "regression", samples = 12 }
"""
TRUTH = np.array([11.0, 4.1])
"""Stiffness [kPa] and pressure [mmHg] that the data are made with."""
PRIOR = stats.multivariate_normal([12.0, 4.0], np.diag([2.0**2, 0.1**2]))
"""A stiffness that is hardly known, and a pressure that was measured."""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    program = os.environ.get("SINEW_PROGRAM")
    if program is None:
        pytest.skip("SINEW_PROGRAM names no program sinew to serve")
    folder: Path = tmp_path_factory.mktemp("served")
    (folder / "heart.toml").write_text(CASE)
    subprocess.run([program, "train", "heart.toml"], cwd=folder, check=True, capture_output=True)
    command = [program, "serve", "heart.toml", "--port", "0"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield next(line.split(" at ")[1].strip() for line in server.stdout if line.startswith("serving"))
        finally:
            server.kill()


def test_tinyda_finds_a_known_theta_on_the_three_models(address: str) -> None:
    models = [umbridge.HTTPModel(address, name) for name in umbridge.supported_models(address)]
    assert [model.name for model in models] == ["emulator", "corrected", "solver"]
    exact = np.array(models[-1]([list(TRUTH)])[0])
    noise = 0.01 * exact
    data = exact + noise * np.random.default_rng(3).standard_normal(len(exact))
    likelihood = tda.GaussianLogLike(data, np.diag(noise**2))
    # The prior reaches beyond the ranges, where an emulator has to be allowed to extrapolate.
    config = {"extrapolate": True}
    served = [tda.UmBridgeModel(model, umbridge_config=config) for model in models]
    hierarchy = [tda.Posterior(PRIOR, likelihood, model) for model in served]
    np.random.seed(1)
    proposal = tda.AdaptiveMetropolis(C0=np.diag([0.5**2, 0.05**2]), period=50)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = tda.sample(
            hierarchy, proposal, iterations=300, n_chains=1, initial_parameters=PRIOR.mean, subsampling_rate=[8, 3], force_sequential=True
        )
    for level, model in enumerate(models):
        chain = np.array([link.parameters for link in found[f"chain_l{level}_0"]])
        settled = chain[len(chain) // 5 :]
        low, high = np.quantile(settled, [0.025, 0.975], axis=0)
        print(f"{model.name}: {len(chain)} links, mu {low[0]:.2f} to {high[0]:.2f} kPa, p {low[1]:.2f} to {high[1]:.2f} mmHg")
        assert np.all((low < TRUTH) & (TRUTH < high)), (model.name, low, high)
        # The data tell the stiffness: the prior's interval has 7.8 kPa.
        assert high[0] - low[0] < 4.0
