//! Calibration: posteriors of a patient's parameters, and patients that are made.

use crate::case::NativeCase;
use crate::errors::Result;
use crate::relay;
use pyo3::prelude::*;
use sinew::calibrate::calibrate as sampled;
use sinew::calibration::{arviz, in_words, observed};
use sinew::{Case, PatientFile, theta_of};

/// Groups of draws for arviz as JSON, and the result in lines; the seed is the case's own where none is given.
#[pyfunction]
pub(crate) fn calibrate(
    case: &NativeCase,
    seed: Option<u64>,
    listener: &Bound<'_, PyAny>,
) -> Result<(String, Vec<String>)> {
    let case = case.case.clone();
    relay::run(listener, move |observer| -> Result<_> {
        let file = PatientFile::of(case)?;
        let prepared = file.prepare()?;
        let patient = prepared.patient()?;
        let mut options = file.options();
        options.seed = seed.unwrap_or(options.seed);
        let mut solves = observed(&patient, observer);
        let posterior = sampled(&prepared.problem, &mut solves, &options)?;
        Ok((arviz(&prepared, &posterior).to_json(), in_words(&prepared, &posterior)))
    })
}

/// The case with data that the solver gives at θ, with noise.
#[pyfunction]
pub(crate) fn synthesise(
    py: Python<'_>,
    case: &NativeCase,
    theta: Vec<(String, String)>,
    seed: u64,
) -> Result<NativeCase> {
    let case = case.case.clone();
    let made = py.detach(|| -> Result<Case> {
        let file = PatientFile::of(case)?;
        let theta = theta_of(&theta, &file.parameters()?)?;
        let text = file.synthesise(&theta, seed)?;
        let mut made = Case::parse(&text, &file.case.name)?;
        made.mesh = file.case.mesh;
        Ok(made)
    })?;
    NativeCase::lowered(py, made)
}
