//! Quantiles of samples, and a density of their logarithms.

use crate::ReportError;
use serde::{Deserialize, Serialize};

/// Quantiles, mean and, of many samples, the density.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Smallest sample.
    pub q0: f64,
    /// 2.5 % quantile.
    pub q2_5: f64,
    /// Lower quartile.
    pub q25: f64,
    /// Median.
    pub q50: f64,
    /// Upper quartile.
    pub q75: f64,
    /// 97.5 % quantile.
    pub q97_5: f64,
    /// Largest sample.
    pub q100: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Points (x, density per factor of ten) of [`Distribution::with_density`]; may be empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub density: Vec<[f64; 2]>,
}

impl Distribution {
    /// Quantiles with linear interpolation between order statistics (type 7 of Hyndman and Fan 1996, the default of
    /// numpy and R), and the mean. `None` if there are no samples or one is NaN.
    ///
    /// ```
    /// let found = sinew_report::Distribution::of(vec![4.0, 1.0, 2.0, 3.0]).expect("samples");
    /// assert_eq!((found.q25, found.q50, found.q100), (1.75, 2.5, 4.0));
    /// ```
    pub fn of(mut samples: Vec<f64>) -> Option<Self> {
        if samples.is_empty() || samples.iter().any(|value| value.is_nan()) {
            return None;
        }
        samples.sort_unstable_by(f64::total_cmp);
        let at = |probability: f64| {
            let position = probability * (samples.len() - 1) as f64;
            let below = position.floor() as usize;
            let (low, high) = (samples[below], samples[(below + 1).min(samples.len() - 1)]);
            // Equal neighbours first: the difference of two infinities would be NaN.
            if low == high { low } else { low + (position - below as f64) * (high - low) }
        };
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let [q0, q2_5, q25, q50] = [0.0, 0.025, 0.25, 0.5].map(at);
        let [q75, q97_5, q100] = [0.75, 0.975, 1.0].map(at);
        Some(Self { q0, q2_5, q25, q50, q75, q97_5, q100, mean, density: Vec::new() })
    }

    /// Distribution with the density over log₁₀ x ([`density`]); `field` names the samples in errors.
    ///
    /// # Errors
    /// [`ReportError::Missing`] without samples, [`ReportError::Number`] for one that is NaN, infinite or negative.
    pub fn with_density(field: &str, samples: Vec<f64>) -> Result<Self, ReportError> {
        if let Some(&value) = samples.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
            return Err(ReportError::Number(format!("a sample of {field}"), value));
        }
        let density = density(&samples);
        let found = Self::of(samples).ok_or_else(|| ReportError::Missing(field.into()))?;
        Ok(Self { density, ..found })
    }

    /// Quantiles ascending, then the mean.
    pub(crate) fn values(&self) -> [f64; 8] {
        let Self { q0, q2_5, q25, q50, q75, q97_5, q100, mean, .. } = *self;
        [q0, q2_5, q25, q50, q75, q97_5, q100, mean]
    }
}

/// Bins per factor of ten: 7 % wide each, finer than any bandwidth drawn from them.
const BINS: f64 = 32.0;
/// Decades that are counted; exact zeros, as at clamped nodes, and rounding have no place on a logarithmic axis.
const DECADES: [f64; 2] = [-16.0, 8.0];
/// Smallest bandwidth in bins (0.08 decades). Errors of neighbouring nodes are correlated, so Silverman's rule
/// overestimates the number of independent samples.
const MIN_BANDWIDTH: f64 = 2.5;
/// The Gaussian is cut here, where 6e-5 of its mass is left.
const REACH: f64 = 4.0;

/// Gaussian kernel density of log₁₀ x from counts in narrow bins: points (x, density per decade) whose integral over
/// log₁₀ x is 1. Bandwidth by Silverman's rule (1986, eq. 3.31). Empty if no sample lies between 1e-16 and 1e8.
pub fn density(samples: &[f64]) -> Vec<[f64; 2]> {
    let [first, end] = DECADES.map(|decade| decade * BINS);
    let mut counts = vec![0.0; (end - first) as usize];
    for sample in samples {
        let bin = (sample.log10() * BINS).floor();
        if (first..end).contains(&bin) {
            counts[(bin - first) as usize] += 1.0;
        }
    }
    let total: f64 = counts.iter().sum();
    if total == 0.0 {
        return Vec::new();
    }
    let bandwidth = bandwidth(&counts, total);
    let reach = (REACH * bandwidth).ceil() as usize;
    let scale = BINS / (total * bandwidth * (2.0 * std::f64::consts::PI).sqrt());
    let from = counts.iter().position(|n| *n > 0.0).unwrap_or(0);
    let to = counts.iter().rposition(|n| *n > 0.0).unwrap_or(0);
    (from as i64 - reach as i64..=(to + reach) as i64)
        .map(|at| {
            let near = (at - reach as i64).max(from as i64)..=(at + reach as i64).min(to as i64);
            let weight = |bin: i64| {
                let distance = (bin - at) as f64 / bandwidth;
                counts[bin as usize] * (-0.5 * distance * distance).exp()
            };
            let centre = (first + at as f64 + 0.5) / BINS;
            [10f64.powf(centre), scale * near.map(weight).sum::<f64>()]
        })
        .collect()
}

/// 0.9 min(σ, IQR/1.34) n^(-1/5) in bins.
fn bandwidth(counts: &[f64], total: f64) -> f64 {
    let moment = |f: &dyn Fn(f64) -> f64| -> f64 {
        counts.iter().enumerate().map(|(i, n)| n * f(i as f64)).sum::<f64>() / total
    };
    let mean = moment(&|x| x);
    let deviation = moment(&|x| (x - mean) * (x - mean)).sqrt();
    let quantile = |probability: f64| {
        let sums = counts.iter().scan(0.0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        sums.take_while(|sum| *sum < probability * total).count() as f64
    };
    let range = (quantile(0.75) - quantile(0.25)) / 1.34;
    let spread = if range > 0.0 { deviation.min(range) } else { deviation };
    (0.9 * spread * total.powf(-0.2)).max(MIN_BANDWIDTH)
}
