"""Exceptions and warnings, in the words of the program `sinew`."""

from __future__ import annotations

__all__ = ["CalibrationError", "CaseError", "EmulatorError", "SinewError", "SinewWarning", "SolveError"]


class SinewError(Exception):
    """Any error of this package."""


class CaseError(SinewError, ValueError):
    """A case, a mesh, parameters or options that make no sense, with the place and what to do."""


class SolveError(SinewError, RuntimeError):
    """No equilibrium, or none that could be found."""


class EmulatorError(SinewError, RuntimeError):
    """An emulator that cannot be trained, stored, read or asked."""


class CalibrationError(SinewError, RuntimeError):
    """Data that no posterior was found for which the solver confirms."""


class SinewWarning(UserWarning):
    """A reason not to trust a result."""
