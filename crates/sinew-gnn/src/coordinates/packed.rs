//! Numbers as text that gives back the very same ones: little-endian bytes in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

pub(super) fn doubles(values: &[f64]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

/// `count` finite numbers.
pub(super) fn read_doubles(text: &str, count: usize) -> Result<Vec<f64>, String> {
    let bytes =
        STANDARD.decode(text).map_err(|error| format!("numbers of the outputs: {error}"))?;
    let (numbers, rest) = bytes.as_chunks();
    let values: Vec<f64> = numbers.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect();
    if values.len() != count || !rest.is_empty() {
        return Err(format!("{} numbers of the outputs, {count} expected", values.len()));
    }
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("{value} among the numbers of the outputs")),
        None => Ok(values),
    }
}
