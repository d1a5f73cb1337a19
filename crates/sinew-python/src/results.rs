//! Results as dictionaries of arrays.

use crate::arrays::Array;
use crate::errors::said;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew::case::{branched_in_words, doubtful_displacements, locking_at_most};
use sinew::output::by_row;
use sinew::{Body, Simulations, locking_in_words};
use sinew_emulate::{Answer, Answers, Error, Method};

/// Solutions at every row of θ: displacements (NaN for failed rows), failures by row, seconds by row, warnings.
pub(crate) fn solutions<'py>(
    py: Python<'py>,
    body: &Body,
    thetas: &[Vec<f64>],
    found: &Simulations,
) -> PyResult<Bound<'py, PyDict>> {
    let fields: Vec<_> = found.fields.iter().map(Vec::as_slice).collect();
    let mut warnings = doubts(py, body, &found.thetas, &fields);
    warnings.extend(branched_in_words(body, found, "load_steps=True"));
    let rows = by_row(thetas, found);
    let place = |row: &Result<usize, String>| row.as_ref().ok().copied();
    let seconds = |row: &_| place(row).map_or(f64::NAN, |at| found.solve_seconds[at]);
    let field = |row: &_| place(row).map(|at| &found.fields[at]);
    let result = PyDict::new(py);
    result.set_item("displacement", by_nodes(body, rows.iter().map(field)))?;
    let pressure = |row: &_| found.pressures.get(place(row)?);
    let pressures: Vec<_> = rows.iter().map(pressure).collect();
    result.set_item("pressure", by_row_or_nan(&pressures))?;
    result.set_item("failures", failures(&rows))?;
    result.set_item("seconds", Array::vector(rows.iter().map(seconds).collect()))?;
    result.set_item("warnings", warnings)?;
    Ok(result)
}

/// Answers: displacements (NaN for failed rows), their errors, sources, warnings and failures by row, the method.
pub(crate) fn answers<'py>(
    py: Python<'py>,
    body: &Body,
    thetas: &[Vec<f64>],
    found: &Answers,
) -> PyResult<Bound<'py, PyDict>> {
    type Row = Result<Answer, Error>;
    let rows = found.answers.iter();
    let error = |row: &Row| row.as_ref().map_or(f64::NAN, |answer| answer.error);
    let source = |row: &Row| match row {
        Ok(answer) if answer.method == Method::Solver => "solved",
        Ok(_) => "predicted",
        Err(_) => "none",
    };
    let fields = rows.clone().map(|row| row.as_ref().ok().map(|answer| &answer.displacement));
    let states = thetas.iter().zip(fields.clone());
    let states: (Vec<_>, Vec<_>) =
        states.filter_map(|(theta, field)| Some((theta.clone(), &field?[..]))).unzip();
    let result = PyDict::new(py);
    result.set_item("displacement", by_nodes(body, fields))?;
    result.set_item("error", Array::vector(rows.clone().map(error).collect()))?;
    result.set_item("source", rows.clone().map(source).collect::<Vec<_>>())?;
    result.set_item(
        "set_warnings",
        rows.map(|row| said(row.iter().flat_map(|answer| &answer.warnings))).collect::<Vec<_>>(),
    )?;
    result.set_item("failures", failures(&found.answers))?;
    result.set_item("warnings", doubts(py, body, &states.0, &states.1))?;
    result.set_item("method", found.plan.method().name())?;
    Ok(result)
}

/// Doubts about the states of a body at sets of parameters, found without the interpreter's lock.
pub(crate) fn doubts(
    py: Python<'_>,
    body: &Body,
    thetas: &[Vec<f64>],
    fields: &[&[f64]],
) -> Vec<String> {
    py.detach(|| {
        let states = thetas.iter().zip(fields.iter().copied());
        let stiff = locking_at_most(body, states).ok().flatten();
        let stiff = stiff.iter().map(locking_in_words);
        said(stiff.chain(doubtful_displacements(body, fields)))
    })
}

/// Displacements by row and node, NaN where there are none.
pub(crate) fn by_nodes<'a>(
    body: &Body,
    rows: impl ExactSizeIterator<Item = Option<&'a Vec<f64>>>,
) -> Array {
    let (count, missing) = (rows.len(), vec![f64::NAN; 3 * body.nodes]);
    let fields = rows.flat_map(|field| field.unwrap_or(&missing).clone()).collect();
    Array::new(fields, [count, body.nodes, 3])
}

/// Numbers by row, NaN where there are none; without a column where no row has any.
pub(crate) fn by_row_or_nan(rows: &[Option<&Vec<f64>>]) -> Array {
    let width = rows.iter().flatten().map(|row| row.len()).max().unwrap_or(0);
    let missing = vec![f64::NAN; width];
    let all = rows.iter().flat_map(|row| row.unwrap_or(&missing).clone()).collect();
    Array::new(all, [rows.len(), width])
}

/// Rows without a result, with the reason.
fn failures<T, E: ToString>(rows: &[Result<T, E>]) -> Vec<(usize, String)> {
    let rows = rows.iter().enumerate();
    rows.filter_map(|(row, found)| Some((row, found.as_ref().err()?.to_string()))).collect()
}
