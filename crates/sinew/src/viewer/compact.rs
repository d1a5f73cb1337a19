//! Predictions that a page is made from, and regressions of them with the digits that it needs.

use crate::Emulator;
use rayon::prelude::*;
use sinew_emulate::parts::norm;
use sinew_emulate::{Counter, Observer, PodRegression, Result};
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
    ) -> Result<Self> {
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
    pub(super) fn at(&self, theta: &[f64]) -> Result<Vec<f64>> {
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
) -> Result<(Vec<f64>, f64)> {
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

/// Predictions that regressions of the page are fitted to.
pub(super) const PREDICTIONS: usize = 500;
/// Predictions between two signs of progress.
pub(super) const AT_ONCE: usize = 20;

/// Parameter sets with their predictions.
pub(super) struct Sampled<F = Vec<f64>> {
    /// θ, set by set.
    pub(super) thetas: Vec<Vec<f64>>,
    /// Displacements, or other values of these, set by set.
    pub(super) fields: Vec<F>,
}

/// Predictions with signs of progress.
pub(super) fn predicted(
    emulator: &Emulator<'_>,
    thetas: &[Vec<f64>],
    observer: &mut dyn Observer,
) -> Result<Vec<Vec<f64>>> {
    let mut counter = Counter::new(observer, "predict for the page", 0, thetas.len());
    let mut fields = Vec::with_capacity(thetas.len());
    for some in thetas.chunks(AT_ONCE) {
        fields.extend(emulator.predict(some)?.fields());
        let _ = counter.step(some.len(), "");
        counter.check()?;
    }
    Ok(fields)
}

/// Mean relative distance of a regression from values of predictions.
pub(super) fn relative(
    shown: &Compact,
    checked: &Sampled,
    values: impl Fn(&Vec<f64>) -> Vec<f64> + Sync,
) -> Result<f64> {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let pairs = checked.thetas.par_iter().zip(&checked.fields);
    let each: Vec<f64> = pairs
        .map(|(theta, field)| {
            let (own, truth) = (shown.at(theta)?, values(field));
            let apart = norm(&mut own.iter().zip(&truth).map(|(a, b)| a - b));
            Ok(apart / norm(&mut truth.iter().copied()).max(f64::MIN_POSITIVE))
        })
        .collect::<Result<_>>()?;
    Ok(each.iter().sum::<f64>() / each.len().max(1) as f64)
}
