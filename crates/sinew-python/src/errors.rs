//! Errors as the exceptions of `pysinew.errors`, in the same words as the program's.

use pyo3::prelude::*;
use pyo3::types::PyType;
use sinew::EmulatorError as E;
use sinew::SolveError;
use sinew::calibrate::CalibrateError;
use sinew_fem::UnloadError;
use std::error::Error;

/// Module of the exceptions.
const MODULE: &str = "pysinew.errors";
/// A mistake of the user: a case, a mesh, θ, an option.
const CASE: &str = "CaseError";
/// No equilibrium, or none that could be found.
const SOLVE: &str = "SolveError";
/// An emulator that cannot be made, stored or asked.
const EMULATOR: &str = "EmulatorError";
/// A posterior that the solver does not confirm.
const CALIBRATION: &str = "CalibrationError";

/// An error on its way to Python; a text is about a mistake of the user.
pub(crate) struct Failure(Box<dyn Error + Send + Sync>);

pub(crate) type Result<T, E = Failure> = std::result::Result<T, E>;

impl<E: Into<Box<dyn Error + Send + Sync>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

/// The exception with the error's own words, or that of Python.
impl From<Failure> for PyErr {
    fn from(Failure(error): Failure) -> Self {
        let error = match error.downcast::<Self>() {
            Ok(raised) => return *raised,
            Err(error) => error,
        };
        Python::attach(|py| {
            let class = || {
                py.import(MODULE)?
                    .getattr(class(&*error))?
                    .cast_into::<PyType>()
                    .map_err(Self::from)
            };
            match class() {
                Ok(class) => Self::from_type(class, in_python(&error.to_string())),
                Err(missing) => missing,
            }
        })
    }
}

/// Commands of the program, and the calls of Python that do the same.
const CALLS: [(&str, &str); 4] = [
    ("`sinew solve --check-mesh`", "`Case.check_mesh`"),
    ("`sinew solve --load-steps`", "`Case.solve(load_steps=True)`"),
    ("`sinew solve`", "`Case.solve`"),
    ("`sinew unload`", "`Case.unload`"),
];

/// Texts in words of Python.
pub(crate) fn said<T: ToString>(texts: impl IntoIterator<Item = T>) -> Vec<String> {
    texts.into_iter().map(|text| in_python(&text.to_string())).collect()
}

/// A text with calls of Python for commands of the program, and keywords for options: `--load-steps` is `load_steps`, and what names a folder is `folder`.
fn in_python(text: &str) -> String {
    let text =
        CALLS.iter().fold(text.to_string(), |text, (command, call)| text.replace(command, call));
    let mut parts = text.split("--");
    let mut said = parts.next().unwrap_or_default().to_string();
    for part in parts {
        // Commands in quotes and names of files stay as they are.
        if said.matches('`').count() % 2 == 1 || said.ends_with(char::is_alphanumeric) {
            said += "--";
            said += part;
            continue;
        }
        let end = part.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(part.len());
        match &part[..end] {
            "name" | "out" => said += "folder",
            "" => said += "--",
            option => said += &option.replace('-', "_"),
        }
        said += &part[end..];
    }
    said
}

/// Name of the class of an error.
fn class(error: &(dyn Error + 'static)) -> &'static str {
    if let Some(error) = error.downcast_ref::<E>() {
        return match error {
            E::Solve(_) => SOLVE,
            E::ThetaLength { .. } | E::Setting { .. } | E::Samples(_) => CASE,
            _ => EMULATOR,
        };
    }
    if let Some(error) = error.downcast_ref::<CalibrateError>() {
        return match error {
            CalibrateError::Input(_) => CASE,
            CalibrateError::NoStart { .. } => SOLVE,
            _ => CALIBRATION,
        };
    }
    if error.is::<SolveError>() || error.is::<UnloadError>() { SOLVE } else { CASE }
}
