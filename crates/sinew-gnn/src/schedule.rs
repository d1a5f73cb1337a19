//! Learning rate over the course of training.

use serde::{Deserialize, Serialize};

/// Development of the learning rate, as a factor of its peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// The peak throughout.
    Constant,
    /// Linear warm-up over 5 % of the steps but at most 200, then half a cosine down to 1e-3 of the peak.
    #[default]
    WarmupCosine,
}

/// Share of the steps spent on warm-up.
const WARMUP_SHARE: f64 = 0.05;
/// Longest warm-up, in steps.
const WARMUP_STEPS: f64 = 200.0;
/// Factor at the end of the cosine.
const COSINE_END: f64 = 1e-3;

impl Schedule {
    /// Factor of step `step` (from zero) of `total` steps. Under a time budget `total` is an estimate.
    pub(crate) fn factor(self, step: usize, total: f64) -> f64 {
        let step = step as f64;
        match self {
            Self::Constant => 1.0,
            Self::WarmupCosine => {
                let warmup = (WARMUP_SHARE * total).min(WARMUP_STEPS);
                if step < warmup {
                    return (step + 1.0) / (warmup + 1.0);
                }
                let share = ((step - warmup) / (total - warmup).max(1.0)).min(1.0);
                COSINE_END + (1.0 - COSINE_END) * 0.5 * (1.0 + (std::f64::consts::PI * share).cos())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cosine_rises_to_the_peak_and_falls_to_its_end() {
        let factors: Vec<f64> =
            (0..1000).map(|step| Schedule::WarmupCosine.factor(step, 1000.0)).collect();
        assert!(factors[..50].windows(2).all(|pair| pair[0] < pair[1]));
        assert!(factors[50..].windows(2).all(|pair| pair[0] > pair[1]));
        assert_eq!(factors[50], 1.0);
        assert!((factors[525] - 0.5005).abs() < 1e-12);
        assert!(factors[999] < 1.01e-3);
        // A long run warms up for 200 steps only.
        assert_eq!(Schedule::WarmupCosine.factor(200, 1e6), 1.0);
    }
}
