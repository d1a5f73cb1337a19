//! A regression with the digits that a page needs.

use sinew_emulate::parts::norm;
use sinew_emulate::{PodRegression, RegressionError};
use sinew_report::{Model, Packed, PackedRows};

/// Most bits of a mode's entry: those of a number of 32 bits.
const MODE_BITS: u32 = 24;
/// Most bits of a weight, which a browser's numbers hold with a byte to spare.
const WEIGHT_BITS: u32 = 44;

/// A regression as a page evaluates it: modes and weights rounded to as many bits as a tolerance asks for.
pub(super) struct Compact {
    regression: PodRegression,
    mean: Vec<f32>,
    /// Modes that are kept: their place, and their entries after rounding.
    modes: Vec<(usize, Vec<f32>)>,
    packed: Model,
}

impl Compact {
    /// Keeps `rows` of the values, or all. The rounding error at `thetas` stays within `tolerance` of the norm of the
    /// values. Each mode has an equal part of it; a mode with a smaller contribution is dropped.
    pub(super) fn of(
        regression: PodRegression,
        rows: Option<&[usize]>,
        thetas: &[Vec<f64>],
        tolerance: f64,
    ) -> Result<Self, RegressionError> {
        let parts = regression.parts();
        let kept = |values: &[f64]| -> Vec<f64> {
            rows.map_or_else(|| values.to_vec(), |rows| rows.iter().map(|&r| values[r]).collect())
        };
        let mean: Vec<f32> = kept(parts.mean).iter().map(|&value| value as f32).collect();
        let modes: Vec<Vec<f64>> = parts.modes.iter().map(|mode| kept(mode)).collect();
        let (most, least) = sizes(&regression, &mean, &modes, thetas)?;
        let share = tolerance / (modes.len() as f64).sqrt();
        // Rounding errors of n entries are independent and even within a step: a norm of step · √(n/12).
        let spread = |count: usize| (count as f64 / 12.0).sqrt();
        let (mut packed_modes, mut weights) = (PackedRows::default(), PackedRows::default());
        let mut rounded = Vec::new();
        for (place, mode) in modes.iter().enumerate() {
            if most[place] * norm(mode) <= share {
                continue;
            }
            let step = share / (most[place] * spread(mode.len()));
            let entries = packed_modes.push(mode, step, MODE_BITS);
            rounded.push((place, entries.iter().map(|&entry| entry as f32).collect()));
            let own: Vec<f64> = parts.weights.iter().map(|row| row[place]).collect();
            weights.push(&own, share * least / (norm(mode) * spread(own.len())), WEIGHT_BITS);
        }
        let packed = Model {
            mean: Packed::f32(mean.iter().copied()),
            modes: packed_modes.packed(),
            lengths: parts.lengths.to_vec(),
            points: Packed::f64(parts.points.concat()),
            exponents: parts.exponents.to_vec(),
            weights: weights.packed(),
        };
        Ok(Self { mean, modes: rounded, packed, regression })
    }

    /// Values at θ, as the page has them.
    pub(super) fn at(&self, theta: &[f64]) -> Result<Vec<f64>, RegressionError> {
        let coefficients = self.regression.coefficients(theta)?;
        let mut values: Vec<f64> = self.mean.iter().map(|&m| f64::from(m)).collect();
        for (place, mode) in &self.modes {
            let c = coefficients[*place];
            values.iter_mut().zip(mode).for_each(|(value, &m)| *value += c * f64::from(m));
        }
        Ok(values)
    }

    pub(super) fn packed(&self) -> Model {
        self.packed.clone()
    }
}

/// Largest coefficient of each mode relative to the norm of the values there, and the least such norm.
fn sizes(
    regression: &PodRegression,
    mean: &[f32],
    modes: &[Vec<f64>],
    thetas: &[Vec<f64>],
) -> Result<(Vec<f64>, f64), RegressionError> {
    let (mut most, mut least) = (vec![0.0f64; modes.len()], f64::INFINITY);
    for theta in thetas {
        let coefficients = regression.coefficients(theta)?;
        let mut values: Vec<f64> = mean.iter().map(|&m| f64::from(m)).collect();
        for (c, mode) in coefficients.iter().zip(modes) {
            values.iter_mut().zip(mode).for_each(|(value, m)| *value += c * m);
        }
        let size = norm(&values).max(f64::MIN_POSITIVE);
        least = least.min(size);
        most.iter_mut().zip(&coefficients).for_each(|(most, c)| *most = most.max(c.abs() / size));
    }
    Ok((most, least))
}
