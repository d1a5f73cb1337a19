//! Stiffnesses and evenly spread samples of them.

use sinew_energy::{Parameter, Sampling};

/// Stiffnesses on the log scale.
pub(crate) fn parameters(count: usize, low: f64, high: f64) -> Vec<Parameter> {
    let parameter = |i| Parameter {
        name: format!("k{i}"),
        unit: "kPa".into(),
        range: [low, high],
        sampling: Sampling::Log,
    };
    (0..count).map(parameter).collect()
}

/// `count` points in `[low, high]^variables`, evenly spread by the additive recurrence of
/// Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018).
pub(crate) fn points(count: usize, variables: usize, low: f64, high: f64) -> Vec<Vec<f64>> {
    let golden = (0..64).fold(2f64, |g, _| (1.0 + g).powf(1.0 / (variables + 1) as f64));
    let share = |i: usize, d: usize| (0.5 + (i + 1) as f64 / golden.powi(d as i32 + 1)).fract();
    let value = |i, d| low * (high / low).powf(share(i, d));
    (0..count).map(|i| (0..variables).map(|d| value(i, d)).collect()).collect()
}
