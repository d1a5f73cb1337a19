//! Quantiles of error samples.

use serde::{Deserialize, Serialize};

/// Quantiles and mean of one error measure over all samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
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
}

impl Quantiles {
    /// Field names and values in the order of tables.
    pub fn entries(&self) -> [(&'static str, f64); 7] {
        [
            ("q2_5", self.q2_5),
            ("q25", self.q25),
            ("q50", self.q50),
            ("q75", self.q75),
            ("q97_5", self.q97_5),
            ("q100", self.q100),
            ("mean", self.mean),
        ]
    }
}

/// Quantiles with linear interpolation between order statistics (type 7 of Hyndman
/// and Fan 1996, the default of numpy and R), and the mean. Sorts `samples`.
///
/// Returns `None` if there are no samples or one of them is NaN.
pub fn quantiles(samples: &mut [f64]) -> Option<Quantiles> {
    if samples.is_empty() || samples.iter().any(|value| value.is_nan()) {
        return None;
    }
    samples.sort_unstable_by(f64::total_cmp);
    let at = |probability: f64| quantile_of_sorted(samples, probability);
    Some(Quantiles {
        q2_5: at(0.025),
        q25: at(0.25),
        q50: at(0.5),
        q75: at(0.75),
        q97_5: at(0.975),
        q100: at(1.0),
        mean: samples.iter().sum::<f64>() / samples.len() as f64,
    })
}

/// `sorted` must not be empty, `probability` lies in \[0, 1\].
fn quantile_of_sorted(sorted: &[f64], probability: f64) -> f64 {
    let position = probability * (sorted.len() - 1) as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    let (low, high) = (sorted[below], sorted[above]);
    // Equal neighbours first: the difference of two infinities would be NaN.
    if low == high {
        return low;
    }
    low + (position - below as f64) * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_numpy() {
        // np.quantile([3, 1, 4, 1.5, 9.25, 2.6, 5.3], [.025, .25, .5, .75, .975, 1])
        let mut samples = [3.0, 1.0, 4.0, 1.5, 9.25, 2.6, 5.3];
        let found = quantiles(&mut samples).unwrap();
        let numpy = [1.075, 2.05, 3.0, 4.65, 8.6575, 9.25, 3.807_142_857_142_857];
        for ((name, value), expected) in found.entries().into_iter().zip(numpy) {
            // Both interpolate in f64 and differ by rounding only.
            assert!((value - expected).abs() < 1e-14, "{name}: {value}");
        }
    }

    #[test]
    fn one_sample_is_every_quantile() {
        let found = quantiles(&mut [0.5]).unwrap();
        assert!(found.entries().iter().all(|&(_, value)| value == 0.5));
    }

    #[test]
    fn nothing_and_nan_have_no_quantiles() {
        assert_eq!(quantiles(&mut []), None);
        assert_eq!(quantiles(&mut [1.0, f64::NAN]), None);
    }
}
