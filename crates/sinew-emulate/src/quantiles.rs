//! Quantiles of errors.

use serde::{Deserialize, Serialize};

/// Quantiles by linear interpolation between order statistics, and the largest value. NaN counts as the largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
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
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
}

impl Quantiles {
    /// Of values; all NaN without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> =
            values.into_iter().map(|v| if v.is_nan() { f64::NAN } else { v }).collect();
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
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        let [q05, q25, q50, q75, q95, max] = [0.05, 0.25, 0.5, 0.75, 0.95, 1.0].map(at);
        Self { q05, q25, q50, q75, q95, max, mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_ladder() {
        let q = Quantiles::of((0..=20).rev().map(f64::from));
        assert_eq!([q.q05, q.q25, q.q50, q.q75, q.q95, q.max], [1.0, 5.0, 10.0, 15.0, 19.0, 20.0]);
        assert_eq!(q.mean, 10.0);
        assert_eq!(Quantiles::of([1.0, 2.0]).q25, 1.25);
        assert!(Quantiles::of([]).q50.is_nan());
        assert!(Quantiles::of([1.0, f64::NAN, 2.0]).max.is_nan());
    }
}
