//! Errors as the exceptions of `pysinew.errors`, in the same words as the program's.

use pyo3::prelude::*;
use pyo3::types::PyType;
use std::fmt::Display;

/// Module of the exceptions.
const MODULE: &str = "pysinew.errors";

/// An exception class of [`MODULE`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// A mistake of the user: a case, a mesh, θ, an option.
    Case,
    /// No equilibrium, or none that could be found.
    Solve,
    /// An emulator that cannot be made, stored or asked.
    Emulator,
    /// A posterior that the solver does not confirm.
    Calibration,
}

impl Kind {
    fn class(self) -> &'static str {
        match self {
            Self::Case => "CaseError",
            Self::Solve => "SolveError",
            Self::Emulator => "EmulatorError",
            Self::Calibration => "CalibrationError",
        }
    }

    /// The exception with the error's own words.
    pub(crate) fn of(self, py: Python<'_>, error: impl Display) -> PyErr {
        let class =
            || py.import(MODULE)?.getattr(self.class())?.cast_into::<PyType>().map_err(PyErr::from);
        match class() {
            Ok(class) => PyErr::from_type(class, error.to_string()),
            Err(missing) => missing,
        }
    }
}

/// The exception of an emulator's error.
pub(crate) fn emulator(py: Python<'_>, error: &sinew_emulate::Error) -> PyErr {
    use sinew_emulate::Error as E;
    let kind = match error {
        E::Solve(_) => Kind::Solve,
        E::ThetaLength { .. } | E::Setting { .. } | E::Samples(_) => Kind::Case,
        _ => Kind::Emulator,
    };
    kind.of(py, error)
}
