"""Sinew in Python: soft-tissue mechanics, and emulators whose error is known.

    case = Case.scene("OnceClampedBeam")
    emulator = case.train()
    print(emulator.estimate(emulator.predict({"mu": "80 kPa", "lambda": 60.0})))
"""

from ._native import __version__
from .case import Case, Parameter, Unloaded
from .emulator import Emulator
from .errors import CalibrationError, CaseError, EmulatorError, SinewError, SinewWarning, SolveError
from .posterior import Check, Posterior
from .results import Answers, Corrections, Estimate, Fields, MeshCheck, Predictions, Solutions
from .runs import LeftOut, Runs

__all__ = [
    "Answers",
    "CalibrationError",
    "Case",
    "CaseError",
    "Check",
    "Corrections",
    "Emulator",
    "EmulatorError",
    "Estimate",
    "Fields",
    "LeftOut",
    "MeshCheck",
    "Parameter",
    "Posterior",
    "Predictions",
    "Runs",
    "SinewError",
    "SinewWarning",
    "Solutions",
    "SolveError",
    "Unloaded",
    "__version__",
]
