//! Outputs of stored runs as models.

use crate::output::mean_and_largest;
use sinew_emulate::{Emulated, Result, RunsEmulator, share_of};
use sinew_energy::{Parameter, Sampling, Unit};

/// Names of the outputs with their units.
pub(super) fn names(runs: &RunsEmulator) -> Vec<String> {
    let left = runs.left_out().iter();
    match &runs.mesh {
        None => left.map(|left| Unit::from(left.unit.as_str()).head(&left.name)).collect(),
        Some(_) => ["mean u", "largest u", "95 % error"].map(Into::into).into(),
    }
}

/// Outputs of numbers, or the standard deviations of their errors, with derivatives by θ row by row; of displacements without.
pub(super) fn at(
    runs: &RunsEmulator,
    deviations: bool,
    theta: &[f64],
) -> Result<(Vec<f64>, Vec<Vec<f64>>)> {
    let pairs = || runs.parameters.iter().zip(theta);
    let shares: Vec<f64> = pairs().map(|(parameter, x)| share_of(parameter, *x)).collect();
    if runs.mesh.is_some() {
        let found = runs.predict(theta)?.remove(0);
        let [mean, largest] = mean_and_largest(&found.values);
        return Ok((vec![mean, largest, found.half_width], Vec::new()));
    }
    let rate =
        |(Parameter { range: [low, high], sampling, .. }, x): (&Parameter, &f64)| match sampling {
            Sampling::Log => 1.0 / (x * (high / low).ln()),
            Sampling::Linear => 1.0 / (high - low),
        };
    let read = |of: Emulated| {
        let (value, slopes) = match deviations {
            true => (of.deviation, of.deviation_slopes),
            false => (of.value, of.value_slopes),
        };
        (value, slopes.iter().zip(pairs().map(rate)).map(|(slope, rate)| slope * rate).collect())
    };
    let places: Vec<usize> = (0..runs.left_out().len()).collect();
    Ok(runs.at_shares(&shares, &places).into_iter().map(read).unzip())
}
