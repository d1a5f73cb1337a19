//! Results as dictionaries of arrays.

use crate::arrays::Array;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::case::{branched_in_words, doubtful_displacements};
use sinew::{Body, Simulations, locking_in_words};
use sinew_emulate::{Answers, Method};
use sinew_fem::locking;

/// Solutions at every row of θ: displacements (NaN for failed rows), failures by row, seconds by row, warnings.
pub(crate) fn solutions<'py>(
    py: Python<'py>,
    body: &Body,
    thetas: &[Vec<f64>],
    found: Simulations,
) -> PyResult<Bound<'py, PyDict>> {
    let first = found.thetas.first().zip(found.fields.first());
    let stiff = first.and_then(|(theta, field)| locking(body, theta, field).ok().flatten());
    let mut warnings: Vec<String> = stiff.iter().map(locking_in_words).collect();
    let fields: Vec<_> = found.fields.iter().map(Vec::as_slice).collect();
    warnings.extend(doubtful_displacements(body, &fields));
    warnings.extend(branched_in_words(body, &found, "load_steps=True"));
    let (failures, seconds, fields) = by_row(thetas, found, 3 * body.nodes);
    let result = PyDict::new(py);
    result.set_item("displacement", Array::new(fields, [thetas.len(), body.nodes, 3]))?;
    result.set_item("failures", failures)?;
    result.set_item("seconds", Array::vector(seconds))?;
    result.set_item("warnings", warnings)?;
    Ok(result)
}

/// Answers: displacements (NaN for failed rows), their errors, sources, warnings and failures by row, the method.
pub(crate) fn answers<'py>(
    py: Python<'py>,
    body: &Body,
    found: &Answers,
) -> PyResult<Bound<'py, PyDict>> {
    let count = found.answers.len();
    let mut fields = Vec::with_capacity(count * 3 * body.nodes);
    let (mut error, mut source, mut said, mut failures) = (vec![], vec![], vec![], vec![]);
    for (row, answer) in found.answers.iter().enumerate() {
        match answer {
            Ok(answer) => {
                fields.extend(&answer.displacement);
                error.push(answer.error);
                source.push(match answer.method {
                    Method::Solver => "solved",
                    _ => "predicted",
                });
                said.push(answer.warnings.iter().map(ToString::to_string).collect());
            }
            Err(reason) => {
                fields.resize(fields.len() + 3 * body.nodes, f64::NAN);
                error.push(f64::NAN);
                source.push("none");
                said.push(Vec::new());
                failures.push((row, reason.to_string()));
            }
        }
    }
    let result = PyDict::new(py);
    result.set_item("displacement", Array::new(fields, [count, body.nodes, 3]))?;
    result.set_item("error", Array::vector(error))?;
    result.set_item("source", source)?;
    result.set_item("set_warnings", said)?;
    result.set_item("failures", failures)?;
    result.set_item("method", found.plan.method().name())?;
    Ok(result)
}

/// Failures by row, seconds by row, and all displacements, NaN for failed rows.
fn by_row(
    thetas: &[Vec<f64>],
    found: Simulations,
    length: usize,
) -> (Vec<(usize, String)>, Vec<f64>, Vec<f64>) {
    let mut failed = found.failures.into_iter().peekable();
    let mut solved = found.fields.into_iter().zip(found.solve_seconds);
    let (mut failures, mut seconds) = (Vec::new(), Vec::new());
    let mut all = Vec::with_capacity(thetas.len() * length);
    for (row, theta) in thetas.iter().enumerate() {
        if let Some(failure) = failed.next_if(|failure| failure.theta == *theta) {
            failures.push((row, failure.reason));
            seconds.push(f64::NAN);
            all.resize(all.len() + length, f64::NAN);
        } else if let Some((field, own)) = solved.next() {
            seconds.push(own);
            all.extend(field);
        }
    }
    (failures, seconds, all)
}
