//! Predictions that a page is made from, and regressions of them with the digits that it needs.

use crate::Emulator;
use sinew_emulate::parts::norm;
use sinew_emulate::{Counter, Observer, PodRegression, Result};
use sinew_num::try_in_parallel;
use sinew_report::{Model, Packed, PackedRow};

/// Most bytes of a mode's entry, and of a weight: kernels' weights of either sign cancel, and need all digits of 64 bits.
const MOST_BYTES: [usize; 2] = [4, 7];
/// Part of the largest norm of values below which rounding errors are no longer relative to the norm itself.
const SMALL: f64 = 1e-2;

/// A regression as a page evaluates it: modes and weights rounded to as many bytes as a tolerance asks for.
pub(super) struct Compact {
    regression: PodRegression,
    mean: Vec<f64>,
    /// Modes that are kept: their place, and their entries after rounding.
    modes: Vec<(usize, Vec<f64>)>,
    packed: Model,
}

impl Compact {
    /// Keeps `rows` of the values, or all. The rounding error at `thetas` stays within `tolerance` of the norm of the
    /// values, or of [`SMALL`] of the largest norm. Each mode has an equal part of it; a mode with a smaller contribution is dropped.
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
        let mean = kept(parts.mean);
        let modes: Vec<Vec<f64>> = parts.modes.iter().map(|mode| kept(mode)).collect();
        let (most, least) = sizes(&regression, &mean, &modes, thetas)?;
        let share = tolerance / (modes.len() as f64).sqrt();
        // Rounding errors of n entries are independent and even within a step: a norm of step · √(n/12).
        let spread = |count: usize| (count as f64 / 12.0).sqrt();
        // Monomials are largest at corners, where every entry is √3 or its negative.
        let degree = parts.exponents.iter().map(|exponents| exponents.iter().sum::<i32>()).max();
        let corner = 3f64.powf(0.5 * f64::from(degree.unwrap_or(0)));
        let (mut packed_modes, mut weights, mut rounded) = (Vec::new(), Vec::new(), Vec::new());
        for (place, mode) in modes.iter().enumerate() {
            if most[place] * norm(mode) <= share {
                continue;
            }
            let step = share / (most[place] * spread(mode.len()));
            let entries = PackedRow::new(mode, step, MOST_BYTES[0]);
            rounded.push((place, entries.values(mode.len())));
            packed_modes.push(entries);
            let own: Vec<f64> = parts.weights.iter().map(|row| row[place]).collect();
            let step = share * least / (norm(mode) * spread(own.len()) * corner);
            weights.push(PackedRow::new(&own, step, MOST_BYTES[1]));
        }
        let packed = Model {
            mean: Packed::f64(mean.iter().copied()),
            modes: packed_modes,
            lengths: parts.lengths.to_vec(),
            points: Packed::f64(parts.points.concat()),
            exponents: parts.exponents.to_vec(),
            weights,
        };
        Ok(Self { mean, modes: rounded, packed, regression })
    }

    /// Values at θ, as the page has them.
    pub(super) fn at(&self, theta: &[f64]) -> Result<Vec<f64>> {
        let coefficients = self.regression.coefficients(theta)?;
        let mut values = self.mean.clone();
        for (place, mode) in &self.modes {
            let c = coefficients[*place];
            values.iter_mut().zip(mode).for_each(|(value, m)| *value += c * m);
        }
        Ok(values)
    }

    pub(super) fn packed(&self) -> Model {
        self.packed.clone()
    }
}

/// Largest coefficient of each mode relative to the norm of the values there, and the least such norm, none below [`SMALL`] of the largest.
fn sizes(
    regression: &PodRegression,
    mean: &[f64],
    modes: &[Vec<f64>],
    thetas: &[Vec<f64>],
) -> Result<(Vec<f64>, f64)> {
    let mut all = Vec::with_capacity(thetas.len());
    for theta in thetas {
        let coefficients = regression.coefficients(theta)?;
        let mut values = mean.to_vec();
        for (c, mode) in coefficients.iter().zip(modes) {
            values.iter_mut().zip(mode).for_each(|(value, m)| *value += c * m);
        }
        all.push((norm(&values), coefficients));
    }
    let least = SMALL * all.iter().map(|(size, _)| *size).fold(f64::MIN_POSITIVE, f64::max);
    let most = |mode: usize| {
        all.iter().map(|(size, c)| c[mode].abs() / size.max(least)).fold(0.0, f64::max)
    };
    let smallest = all.iter().map(|(size, _)| size.max(least)).fold(f64::INFINITY, f64::min);
    Ok(((0..modes.len()).map(most).collect(), smallest))
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

/// Distance of a regression from values of predictions: mean of those relative to each, and that of all relative to all.
pub(super) fn relative(
    shown: &Compact,
    checked: &Sampled,
    values: impl Fn(&Vec<f64>) -> Vec<f64> + Sync,
) -> Result<[f64; 2]> {
    let pairs = checked.thetas.iter().zip(&checked.fields);
    let each = try_in_parallel(pairs, |(theta, field)| -> Result<_> {
        let (own, truth) = (shown.at(theta)?, values(field));
        let apart: Vec<f64> = own.iter().zip(&truth).map(|(a, b)| a - b).collect();
        Ok([norm(&apart), norm(&truth)])
    })?;
    let ratio = |[apart, size]: [f64; 2]| apart / size.max(f64::MIN_POSITIVE);
    let mean = each.iter().map(|sizes| ratio(*sizes)).sum::<f64>() / each.len().max(1) as f64;
    let all = [0, 1].map(|which| norm(&each.iter().map(|sizes| sizes[which]).collect::<Vec<_>>()));
    Ok([mean, ratio(all)])
}
