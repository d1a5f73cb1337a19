//! Arrays of numbers as text.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// An array of numbers: little-endian bytes in base64, which a browser reads at once and without rounding.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Packed(String);

impl Packed {
    /// Numbers of 32 bits.
    pub fn f32(values: impl IntoIterator<Item = f32>) -> Self {
        Self::of(values.into_iter().map(f32::to_le_bytes))
    }

    /// Numbers of 64 bits.
    pub fn f64(values: impl IntoIterator<Item = f64>) -> Self {
        Self::of(values.into_iter().map(f64::to_le_bytes))
    }

    /// Integers of 16 bits.
    pub fn i16(values: impl IntoIterator<Item = i16>) -> Self {
        Self::of(values.into_iter().map(i16::to_le_bytes))
    }

    /// Indices.
    pub fn u32(values: impl IntoIterator<Item = u32>) -> Self {
        Self::of(values.into_iter().map(u32::to_le_bytes))
    }

    fn of<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> Self {
        let bytes: Vec<u8> = values.flatten().collect();
        Self(STANDARD.encode(bytes))
    }
}
