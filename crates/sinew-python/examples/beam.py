"""A beam under its own weight: solutions, an emulator, its error, and what it is for.

Run it with `python beam.py`; it takes some seconds.
"""

import numpy as np

from pysinew import Case

case = Case.scene("OnceClampedBeam")
print(case)

# The solver, at one parameter set and at several.
theta = {"mu": "80 kPa", "lambda": 60.0}
solution = case.solve(theta)
print(f"tip: {solution.displacement[:, 2].min():.2f} mm")
sweep = case.solve({"mu": np.linspace(50.0, 100.0, 6), "lambda": 60.0})
for mu, u in zip(sweep.theta[:, 0], sweep.displacement):
    print(f"  mu = {mu:5.1f} kPa: {u[:, 2].min():7.2f} mm")

# An emulator of it, and how far it is from the solver on sets that it has not seen.
emulator = case.train("regression", samples=50, seed=1)
print(emulator)
unseen = case.sample(20, seed=2, design="uniform")
prediction, truth = emulator.predict(unseen), case.solve(unseen)
error = np.linalg.norm(prediction.displacement - truth.displacement, axis=2).mean(axis=1)
estimate = emulator.estimate(prediction)
print(f"true error {np.median(error):.1e} mm, estimated {np.median(estimate.mean):.1e} mm (medians)")
assert np.all(np.abs(np.log2(estimate.mean / error)) < 1.0), "estimates are within a factor of two"

# One Newton step squares it.
corrected = emulator.correct(unseen)
after = np.linalg.norm(corrected.displacement - truth.displacement, axis=2).mean(axis=1)
print(f"after one Newton step {np.median(after):.1e} mm")
assert np.median(after) < 0.05 * np.median(error)

# Which stiffness gives a tip half way between the extremes? Predictions are cheap enough to try ten thousand.
mu = np.linspace(50.0, 100.0, 10_000)
tips = emulator.predict({"mu": mu, "lambda": 60.0}).displacement[:, :, 2].min(axis=1)
wanted = 0.5 * (tips.min() + tips.max())
best = mu[np.argmin(np.abs(tips - wanted))]
answer = case.answers({"mu": best, "lambda": 60.0}, accuracy=1e-6)
print(f"mu = {best:.2f} kPa: {answer.displacement[:, 2].min():.3f} mm for {wanted:.3f} mm")
assert abs(answer.displacement[:, 2].min() - wanted) < 0.01 * abs(wanted)
