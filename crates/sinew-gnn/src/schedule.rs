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
