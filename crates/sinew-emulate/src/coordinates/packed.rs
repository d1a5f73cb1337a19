//! Numbers as text that gives back the very same ones: little-endian bytes in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};
use std::sync::Arc;

/// Text of numbers of double precision.
pub fn doubles(values: &[f64]) -> String {
    encoded(values.iter().map(|value| value.to_le_bytes()))
}

/// Text of numbers of single precision.
pub fn singles(values: &[f32]) -> String {
    encoded(values.iter().map(|value| value.to_le_bytes()))
}

/// `count` finite numbers of double precision.
///
/// # Errors
/// Text that is not base64, another count, a number that is not finite.
pub fn read_doubles(text: &str, count: usize) -> Result<Vec<f64>, String> {
    let values: Vec<f64> = decoded(text)?.into_iter().map(f64::from_le_bytes).collect();
    if values.len() != count {
        return Err(format!("{} packed numbers, {count} expected", values.len()));
    }
    let found = values.iter().copied().find(|value| !value.is_finite());
    found.map_or(Ok(values), |value| Err(format!("{value} among the packed numbers")))
}

/// Numbers of single precision.
///
/// # Errors
/// Text that is not base64.
pub fn read_singles(text: &str) -> Result<Vec<f32>, String> {
    Ok(decoded(text)?.into_iter().map(f32::from_le_bytes).collect())
}

/// Numbers of single precision as a field of what is stored.
pub(super) fn serialize<S: Serializer>(values: &[f32], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&singles(values))
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<[f32]>, D::Error> {
    Ok(read_singles(&String::deserialize(from)?).map_err(D::Error::custom)?.into())
}

fn encoded<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> String {
    STANDARD.encode(values.flatten().collect::<Vec<u8>>())
}

fn decoded<const N: usize>(text: &str) -> Result<Vec<[u8; N]>, String> {
    let bytes = STANDARD.decode(text).map_err(|error| format!("packed numbers: {error}"))?;
    match bytes.as_chunks() {
        (numbers, []) => Ok(numbers.to_vec()),
        (_, rest) => Err(format!("packed numbers: {} bytes too many", rest.len())),
    }
}
