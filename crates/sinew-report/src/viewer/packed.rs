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

    /// Indices.
    pub fn u32(values: impl IntoIterator<Item = u32>) -> Self {
        Self::of(values.into_iter().map(u32::to_le_bytes))
    }

    fn of<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> Self {
        let bytes: Vec<u8> = values.flatten().collect();
        Self(STANDARD.encode(bytes))
    }
}

/// Rows of numbers, each rounded to integers of its own number of bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedRows {
    bits: Vec<u32>,
    steps: Vec<f64>,
    bytes: Vec<u8>,
    /// Bits that no byte is filled with yet, and how many.
    held: (u64, u32),
}

impl PackedRows {
    /// Adds a row, rounded to multiples of about `step` but to at most so many bits, of which one is the sign; its numbers after
    /// rounding.
    pub fn push(&mut self, row: &[f64], step: f64, most_bits: u32) -> Vec<f64> {
        let largest = row.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let needed = (largest / step.max(f64::MIN_POSITIVE)).max(1.0).log2().ceil();
        let bits = (needed.min(f64::from(most_bits)) as u32 + 1).clamp(2, most_bits);
        let half = (1u64 << (bits - 1)) - 1;
        let step = (largest / half as f64).max(f64::MIN_POSITIVE);
        self.bits.push(bits);
        self.steps.push(step);
        let mut rounded = Vec::with_capacity(row.len());
        for x in row {
            let integer = (x / step).round();
            rounded.push(integer * step);
            self.write((integer + half as f64) as u64, bits);
        }
        rounded
    }

    /// Appends an integer, its lowest bit first.
    fn write(&mut self, integer: u64, bits: u32) {
        let (mut held, mut count) = self.held;
        held |= integer << count;
        count += bits;
        while count >= 8 {
            self.bytes.push(held as u8);
            held >>= 8;
            count -= 8;
        }
        self.held = (held, count);
    }

    /// Form on a page: bits and steps row by row, and all integers one after the other, each raised by its largest.
    pub fn packed(&self) -> Rows {
        let last = (self.held.1 > 0).then_some(self.held.0 as u8);
        let bytes: Vec<u8> = self.bytes.iter().copied().chain(last).collect();
        Rows {
            bits: self.bits.clone(),
            steps: Packed::f64(self.steps.iter().copied()),
            integers: Packed(STANDARD.encode(bytes)),
        }
    }
}

/// Rows of numbers as text, of a [`PackedRows`].
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rows {
    bits: Vec<u32>,
    steps: Packed,
    integers: Packed,
}
