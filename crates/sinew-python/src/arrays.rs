//! Numbers between numpy and Rust, by their indices: an array's memory may be in any order.

use numpy::{Element, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;

/// Rows of a matrix.
pub(crate) struct Rows(pub(crate) Vec<Vec<f64>>);

/// Entries of an array, the last axis running first.
pub(crate) struct Flat<T = f64>(pub(crate) Vec<T>);

/// An array for numpy: entries, the last axis running first, and shape.
pub(crate) struct Array<T = f64>(Vec<T>, Vec<usize>);

impl<T> Array<T> {
    pub(crate) fn new(entries: Vec<T>, shape: impl Into<Vec<usize>>) -> Self {
        Self(entries, shape.into())
    }

    pub(crate) fn vector(entries: Vec<T>) -> Self {
        let length = entries.len();
        Self(entries, vec![length])
    }
}

impl Array {
    /// Matrix of rows of one length.
    pub(crate) fn stacked(rows: &[Vec<f64>], columns: usize) -> Self {
        Self(rows.concat(), vec![rows.len(), columns])
    }
}

impl<'py, T: Element> IntoPyObject<'py> for Array<T> {
    type Target = PyArrayDyn<T>;
    type Output = Bound<'py, PyArrayDyn<T>>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyArray1::from_vec(py, self.0).reshape(self.1)
    }
}

impl FromPyObject<'_, '_> for Rows {
    type Error = PyErr;

    fn extract(found: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let array: PyReadonlyArray2<'_, f64> = found.extract()?;
        Ok(Self(array.as_array().rows().into_iter().map(|row| row.to_vec()).collect()))
    }
}

impl<T: Element + Copy> FromPyObject<'_, '_> for Flat<T> {
    type Error = PyErr;

    fn extract(found: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let array: PyReadonlyArrayDyn<'_, T> = found.extract()?;
        Ok(Self(array.as_array().iter().copied().collect()))
    }
}

/// Triples of a list of numbers.
pub(crate) fn triples(Flat(numbers): Flat) -> Vec<[f64; 3]> {
    numbers.as_chunks().0.to_vec()
}

/// Numbers of nodes.
pub(crate) fn indices<'n>(nodes: impl IntoIterator<Item = &'n usize>) -> Vec<i64> {
    nodes.into_iter().map(|&node| node as i64).collect()
}
