//! Calibration: posteriors of a patient's parameters, checks before it, and patients that are made.

use crate::case::NativeCase;
use crate::errors::{Result, said};
use crate::relay;
use pyo3::prelude::*;
use sinew::calibrate::{Solves, Verdict, calibrate as sampled, check_identifiability};
use sinew::calibration::{
    ahead_in_words, arviz, in_words, kept, setting_in_words, too_stiff, written,
};
use sinew::report::Provenance;
use sinew::{Case, PatientFile, theta_of};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Groups of draws for arviz as JSON, the result in lines, and warnings.
type Drawn = (String, Vec<String>, Vec<String>);

/// A posterior; the seed is the case's own where none is given. In a folder solves and results are kept, as by the program.
#[pyfunction]
pub(crate) fn calibrate(
    case: &NativeCase,
    seed: Option<u64>,
    budget: Option<f64>,
    folder: Option<PathBuf>,
    again: [bool; 2],
    listener: &Bound<'_, PyAny>,
) -> Result<Drawn> {
    let (case, clock) = (case.case.clone(), Instant::now());
    relay::run(listener, move |observer| -> Result<_> {
        let file = PatientFile::of(case)?;
        let prepared = file.prepare()?;
        let patient = prepared.patient()?;
        let mut options = file.options();
        options.seed = seed.unwrap_or(options.seed);
        let mut solves = Solves::new(&patient);
        solves.observer = Some(observer);
        solves.budget = budget.map(duration);
        if let Some(folder) = &folder {
            solves = kept(solves, folder, &file, &prepared, again)?;
        }
        let posterior = sampled(&prepared.problem, &mut solves, &options)?;
        let mut doubts = prepared.warnings();
        if let Some(folder) = &folder {
            let provenance = Provenance::of_this_run("pysinew", env!("CARGO_MANIFEST_DIR"));
            let provenance = provenance.finished(clock.elapsed().as_secs_f64());
            let provenance = Provenance { seed: Some(options.seed), ..provenance };
            doubts.extend(written(&file, &prepared, &patient, &posterior, provenance, folder)?.1);
        } else if let Ok(states) = patient.states_checked(&posterior.mode.theta, false) {
            doubts.extend(too_stiff(&states));
        }
        Ok((arviz(&prepared, &posterior).to_json(), in_words(&prepared, &posterior), said(doubts)))
    })
}

/// Time of so many seconds; the longest there is for more.
fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// A check before sampling, a dictionary in Python.
#[derive(IntoPyObject)]
pub(crate) struct Checked {
    verdict: &'static str,
    words: Vec<String>,
    theta: Vec<(String, f64)>,
    misfits: Vec<(String, f64)>,
    warnings: Vec<String>,
}

/// Whether the model calibrates the data, at the most likely parameters.
#[pyfunction]
pub(crate) fn check_calibration(
    case: &NativeCase,
    budget: Option<f64>,
    listener: &Bound<'_, PyAny>,
) -> Result<Checked> {
    let case = case.case.clone();
    relay::run(listener, move |observer| -> Result<_> {
        let file = PatientFile::of(case)?;
        let prepared = file.prepare()?;
        let patient = prepared.patient()?;
        let mut solves = Solves::new(&patient);
        solves.observer = Some(observer);
        solves.budget = budget.map(duration);
        let problem = &prepared.problem;
        let (mode, seen) = check_identifiability(problem, &mut solves)?;
        let (verdict, reason) = seen.verdict(problem, &mode);
        let ahead = ahead_in_words(&prepared, &mode, &seen);
        let unknowns = problem.unknowns.iter().zip(&mode.theta);
        let data = problem.data.iter().zip(&mode.misfits);
        Ok(Checked {
            verdict: match verdict {
                Verdict::Calibrates => "calibrates",
                Verdict::DoesNot => "does not",
                Verdict::CannotTell => "cannot tell",
            },
            words: [vec![reason, String::new()], setting_in_words(&prepared), ahead].concat(),
            theta: unknowns.map(|(own, theta)| (own.name.clone(), own.shown(*theta))).collect(),
            misfits: data.map(|(datum, misfit)| (datum.name.clone(), *misfit)).collect(),
            warnings: said(
                prepared
                    .warnings()
                    .into_iter()
                    .chain(patient.states_checked(&mode.theta, false).iter().flat_map(too_stiff)),
            ),
        })
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
