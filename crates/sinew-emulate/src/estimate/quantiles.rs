//! Quantiles of errors.

use serde::{Deserialize, Serialize};

/// Quantiles by linear interpolation between order statistics, and the largest value. A value that is not finite counts as the largest
/// number (`f64::MAX`): files in JSON hold finite numbers alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// The least.
    pub min: f64,
    /// 2.5 %.
    pub q02_5: f64,
    /// 5 %.
    pub q05: f64,
    /// 25 %.
    pub q25: f64,
    /// The median.
    pub q50: f64,
    /// 75 %.
    pub q75: f64,
    /// 95 %.
    pub q95: f64,
    /// 97.5 %.
    pub q97_5: f64,
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
}

impl Quantiles {
    /// Quantiles of values; all NaN without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let finite = |v: f64| if v.is_nan() { f64::MAX } else { v.clamp(f64::MIN, f64::MAX) };
        let mut sorted: Vec<f64> = values.into_iter().map(finite).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * (sorted.len() as f64 - 1.0);
            let [below, above] = [place.floor(), place.ceil()].map(|at| at as usize);
            match (sorted.get(below), sorted.get(above)) {
                (Some(low), Some(high)) if below < above => {
                    low + (place - below as f64) * (high - low)
                }
                (Some(value), _) => *value,
                _ => f64::NAN,
            }
        };
        let mean = (sorted.iter().sum::<f64>() / sorted.len() as f64).clamp(f64::MIN, f64::MAX);
        let [min, q02_5, q05, q25] = [0.0, 0.025, 0.05, 0.25].map(at);
        let [q50, q75, q95, q97_5, max] = [0.5, 0.75, 0.95, 0.975, 1.0].map(at);
        Self { min, q02_5, q05, q25, q50, q75, q95, q97_5, max, mean }
    }
}
