//! Parameters of a body as emulators see them.

use crate::sampling::share_of;
use crate::{Body, Error, Result, Warning};
use sinew_energy::Parameter;
use sinew_gnn::{ParameterRange, ParameterScaling};

/// Relative slack within which a value counts as inside its range: rounding of a bound that went through a logarithm or
/// a text file.
const SLACK: f64 = 1e-9;

/// The body's parameters as inputs of a network.
pub(crate) fn scaling(body: &Body) -> Result<ParameterScaling> {
    Ok(ParameterScaling::new(body.parameters.iter().map(ParameterRange::from).collect())?)
}

/// The parameters that lie outside their ranges.
fn outside<'a>(body: &'a Body, theta: &'a [f64]) -> impl Iterator<Item = (&'a Parameter, f64)> {
    let inside =
        |(p, value): &(&Parameter, f64)| (-SLACK..=1.0 + SLACK).contains(&share_of(p, *value));
    body.parameters.iter().zip(theta.iter().copied()).filter(move |pair| !inside(pair))
}

/// What to say about parameters outside the trained ranges.
pub(crate) fn extrapolation(body: &Body, theta: &[f64]) -> Vec<Warning> {
    let warning = |(p, value): (&Parameter, f64)| Warning::OutsideRange {
        parameter: p.name.clone(),
        value: p.unit.shown(value),
        low: p.unit.shown(p.range[0]),
        high: p.unit.shown(p.range[1]),
        unit: p.unit.name().into(),
    };
    outside(body, theta).map(warning).collect()
}

/// Requires one value per parameter.
pub(crate) fn check_length(body: &Body, theta: &[f64]) -> Result<()> {
    let (found, expected) = (theta.len(), body.parameters.len());
    if found == expected {
        return Ok(());
    }
    let names: Vec<_> = body.parameters.iter().map(|p| p.name.as_str()).collect();
    Err(Error::ThetaLength { found, expected, names: names.join(", ") })
}

/// Requires that training samples lie inside the ranges.
pub(crate) fn require_inside(body: &Body, thetas: &[Vec<f64>]) -> Result<()> {
    for (sample, theta) in thetas.iter().enumerate() {
        check_length(body, theta)?;
        if let Some((p, value)) = outside(body, theta).next() {
            let [value, low, high] = [value, p.range[0], p.range[1]].map(|x| p.unit.said(x));
            return Err(Error::OutsideRange {
                sample,
                parameter: p.name.clone(),
                value,
                low,
                high,
            });
        }
    }
    Ok(())
}
