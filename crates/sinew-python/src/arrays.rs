//! Numbers between numpy and Rust, by their indices: an array's memory may be in any order.

use numpy::ndarray::Ix;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

/// Rows of a matrix.
pub(crate) fn rows(array: &PyReadonlyArray2<'_, f64>) -> Vec<Vec<f64>> {
    array.as_array().rows().into_iter().map(|row| row.to_vec()).collect()
}

/// Rows of three coordinates; the caller has looked at the shape.
pub(crate) fn triples(array: &PyReadonlyArray2<'_, f64>) -> Vec<[f64; 3]> {
    array.as_array().rows().into_iter().map(|row| std::array::from_fn(|axis| row[axis])).collect()
}

/// Vector.
pub(crate) fn vector<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, values)
}

/// Matrix, row by row.
pub(crate) fn matrix<T: numpy::Element>(
    py: Python<'_>,
    values: Vec<T>,
    shape: [Ix; 2],
) -> PyResult<Bound<'_, PyArray2<T>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}

/// Array of three axes, the last running first.
pub(crate) fn cube(
    py: Python<'_>,
    values: Vec<f64>,
    shape: [Ix; 3],
) -> PyResult<Bound<'_, PyArray3<f64>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}

/// Matrix of rows of one length.
pub(crate) fn stacked<'py>(
    py: Python<'py>,
    rows: &[Vec<f64>],
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    matrix(py, rows.concat(), [rows.len(), columns])
}
