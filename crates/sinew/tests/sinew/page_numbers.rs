//! Numbers of a page, as its script reads them.

use serde_json::Value;

/// Bytes in base64.
fn bytes(text: &Value) -> Vec<u8> {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut held, mut count, mut all) = (0u32, 0, Vec::new());
    for letter in text.as_str().unwrap().trim_end_matches('=').bytes() {
        let six = LETTERS.iter().position(|own| *own == letter).unwrap() as u32;
        (held, count) = (held << 6 | six, count + 6);
        if count >= 8 {
            count -= 8;
            all.push((held >> count) as u8);
            held &= (1 << count) - 1;
        }
    }
    all
}

/// Numbers of 32 bits.
pub(crate) fn singles(text: &Value) -> Vec<f64> {
    bytes(text).as_chunks().0.iter().map(|x| f64::from(f32::from_le_bytes(*x))).collect()
}

/// Numbers of 64 bits.
fn doubles(text: &Value) -> Vec<f64> {
    bytes(text).as_chunks().0.iter().map(|x| f64::from_le_bytes(*x)).collect()
}

/// Indices.
pub(crate) fn indices(text: &Value) -> Vec<usize> {
    bytes(text).as_chunks().0.iter().map(|x| u32::from_le_bytes(*x) as usize).collect()
}

/// Rows of so many numbers, of integers with the lowest byte first.
fn unpacked(rows: &Value, size: usize) -> Vec<Vec<f64>> {
    let row = |row: &Value| -> Vec<f64> {
        let (step, bytes) = (row["step"].as_f64().unwrap(), bytes(&row["integers"]));
        let each = bytes.len() / size;
        let zero = (1u64 << (8 * each - 1).min(52)) - 1;
        let whole = |x: &[u8]| x.iter().rev().fold(0, |sum, byte| 256 * sum + u64::from(*byte));
        bytes.chunks(each).map(|x| (whole(x) as f64 - zero as f64) * step).collect()
    };
    rows.as_array().unwrap().iter().map(row).collect()
}

/// A regression as a page has it.
pub(crate) struct Regressed {
    mean: Vec<f64>,
    modes: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    points: Vec<f64>,
    exponents: Vec<Vec<i32>>,
    weights: Vec<Vec<f64>>,
}

impl Regressed {
    pub(crate) fn read(model: &Value) -> Self {
        let lengths: Vec<f64> = serde_json::from_value(model["lengths"].clone()).unwrap();
        let exponents: Vec<Vec<i32>> = serde_json::from_value(model["exponents"].clone()).unwrap();
        let (mean, points) = (doubles(&model["mean"]), doubles(&model["points"]));
        let variables = exponents[0].len().max(1);
        let functions = points.len() / variables * (lengths.len() / variables) + exponents.len();
        let modes = unpacked(&model["modes"], mean.len());
        let weights = unpacked(&model["weights"], functions);
        Self { mean, modes, lengths, points, exponents, weights }
    }

    /// Values at shares of the ranges of θ.
    pub(crate) fn at(&self, shares: &[f64]) -> Vec<f64> {
        let x: Vec<f64> = shares.iter().map(|share| 12f64.sqrt() * (share - 0.5)).collect();
        let kernel = |point: &[f64], lengths: &[f64]| {
            let parts = x.iter().zip(point).zip(lengths);
            (-0.5 * parts.map(|((x, p), length)| ((x - p) / length).powi(2)).sum::<f64>()).exp()
        };
        let points = || self.points.chunks(x.len());
        let sets = self.lengths.chunks(x.len());
        let kernels = sets.flat_map(|set| points().map(move |point| (point, set)));
        let kernels = kernels.map(|(point, set)| kernel(point, set));
        let monomials = self.exponents.iter().map(|exponents| {
            x.iter().zip(exponents).map(|(x, exponent)| x.powi(*exponent)).product::<f64>()
        });
        let functions: Vec<f64> = kernels.chain(monomials).collect();
        let mut values = self.mean.clone();
        for (mode, weights) in self.modes.iter().zip(&self.weights) {
            let coefficient: f64 = functions.iter().zip(weights).map(|(f, w)| f * w).sum();
            values.iter_mut().zip(mode).for_each(|(value, m)| *value += coefficient * m);
        }
        values
    }
}
