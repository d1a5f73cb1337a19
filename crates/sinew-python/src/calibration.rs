//! Calibration: posteriors of a patient's parameters, and patients that are made.

use crate::case::NativeCase;
use crate::errors::Kind;
use crate::relay;
use pyo3::prelude::*;
use sinew::calibrate::{CalibrateError, calibrate as sampled};
use sinew::calibration::{arviz, in_words, observed};
use sinew::{Case, PatientFile, theta_of};

/// Class of an exception with its words.
type Failure = (Kind, String);

/// Groups of draws for arviz as JSON, and the result in lines; the seed is the case's own where none is given.
#[pyfunction]
pub(crate) fn calibrate(
    py: Python<'_>,
    case: &NativeCase,
    seed: Option<u64>,
    listener: &Bound<'_, PyAny>,
) -> PyResult<(String, Vec<String>)> {
    let case = case.case.clone();
    let found = relay::run(py, listener, move |observer| -> Result<_, Failure> {
        let wrong = |error: sinew::CaseError| (Kind::Case, error.to_string());
        let file = PatientFile::of(case).map_err(wrong)?;
        let prepared = file.prepare().map_err(wrong)?;
        let patient = prepared.patient().map_err(|reason| (Kind::Case, reason))?;
        let mut options = file.options();
        options.seed = seed.unwrap_or(options.seed);
        let mut solves = observed(&patient, observer);
        let posterior = sampled(&prepared.problem, &mut solves, &options).map_err(told)?;
        Ok((arviz(&prepared, &posterior).to_json(), in_words(&prepared, &posterior)))
    })?;
    found.map_err(|(kind, reason)| kind.of(py, reason))
}

fn told(error: CalibrateError) -> Failure {
    let kind = match &error {
        CalibrateError::Input(_) | CalibrateError::Unreachable { .. } => Kind::Case,
        CalibrateError::NoStart { .. } => Kind::Solve,
        _ => Kind::Calibration,
    };
    (kind, error.to_string())
}

/// The case with data that the solver gives at θ, with noise.
#[pyfunction]
pub(crate) fn synthesise(
    py: Python<'_>,
    case: &NativeCase,
    theta: Vec<(String, String)>,
    seed: u64,
) -> PyResult<NativeCase> {
    let case = case.case.clone();
    let made = py.detach(|| -> Result<Case, String> {
        let file = PatientFile::of(case).map_err(|error| error.to_string())?;
        let pairs: Vec<(&str, &str)> =
            theta.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
        let parameters = file.parameters().map_err(|error| error.to_string())?;
        let theta = theta_of(&pairs, &parameters).map_err(|error| error.to_string())?;
        let text = file.synthesise(&theta, seed).map_err(|error| error.to_string())?;
        let mut made = Case::parse(&text, &file.case.name).map_err(|error| error.to_string())?;
        made.mesh = file.case.mesh;
        Ok(made)
    });
    NativeCase::lowered(py, made.map_err(|reason| Kind::Case.of(py, reason))?)
}
