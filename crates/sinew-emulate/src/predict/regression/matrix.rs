//! Stored matrices: their shape and their entries, column by column.

use nalgebra::DMatrix;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub(super) fn serialize<S: Serializer>(
    matrix: &DMatrix<f64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    (matrix.nrows(), matrix.ncols(), matrix.as_slice()).serialize(serializer)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<DMatrix<f64>, D::Error> {
    let (rows, columns, entries) = <(usize, usize, Vec<f64>)>::deserialize(deserializer)?;
    if rows * columns != entries.len() {
        return Err(D::Error::custom("a matrix whose entries do not fill its shape"));
    }
    Ok(DMatrix::from_vec(rows, columns, entries))
}
