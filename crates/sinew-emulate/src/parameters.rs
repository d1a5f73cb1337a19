//! Parameters of a body as emulators see them.

use crate::coordinates::ParameterScaling;
use crate::error::{ensure, require_usable};
use crate::sample::{is_inside, share_of};
use crate::{Body, Error, Result, Warning};
use sinew_energy::Parameter;
use sinew_fem::SolveError;

/// The body's parameters as inputs of a network.
pub fn scaling(body: &Body) -> Result<ParameterScaling> {
    Ok(ParameterScaling::new(&body.parameters)?)
}

/// The parameters that lie outside their ranges.
fn outside<'a>(body: &'a Body, theta: &'a [f64]) -> impl Iterator<Item = (&'a Parameter, f64)> {
    let pairs = body.parameters.iter().zip(theta.iter().copied());
    pairs.filter(|(parameter, value)| !is_inside(parameter, *value))
}

/// Warnings about parameters outside the trained ranges.
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

/// θ by name, in the parameters' own units.
pub(crate) fn in_words(body: &Body, theta: &[f64]) -> String {
    let pair = |(p, value): (&Parameter, &f64)| format!("{} = {}", p.name, p.unit.format(*value));
    body.parameters.iter().zip(theta).map(pair).collect::<Vec<_>>().join(", ")
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

/// Requires a parameter to emulate over, and a potential by which emulators learn and answers are refined.
pub(crate) fn check_body(body: &Body) -> Result<()> {
    ensure(body.has_potential(), SolveError::NoPotential)?;
    require_usable(!body.parameters.is_empty(), || {
        let known = body.known.iter().map(|(name, value)| format!("{name} = {value}"));
        let known = known.reduce(|all, next| all + ", " + &next);
        format!(
            "the body has no free parameters ({}), so there is one equilibrium and nothing to emulate: solve it (sinew solve), or give a parameter a range",
            known.unwrap_or("there are none".into())
        )
    })
}

/// Requires finite displacements, equally many for each θ. The error names the parameter farthest outside its range.
pub(crate) fn require_finite(body: &Body, thetas: &[Vec<f64>], displacement: &[f64]) -> Result<()> {
    let length = (displacement.len() / thetas.len().max(1)).max(1);
    let lost = displacement.iter().position(|u| !u.is_finite());
    lost.map_or(Ok(()), |index| Err(not_finite(body, &thetas[index / length])))
}

/// A prediction for θ that is not finite, and the parameter that is farthest outside of its range.
pub fn not_finite(body: &Body, theta: &[f64]) -> Error {
    let beyond = |p: &Parameter, value: f64| (share_of(p, value) - 0.5).abs();
    let all = outside(body, theta);
    let reason = match all.max_by(|a, b| beyond(a.0, a.1).total_cmp(&beyond(b.0, b.1))) {
        Some((Parameter { name, unit, range: [low, high], .. }, value)) => {
            let [value, low, high] = [value, *low, *high].map(|x| unit.format(x));
            format!(
                "{name} = {value} is far outside its range from {low} to {high}: give a value that is nearer"
            )
        }
        None => "every parameter is inside its range, so the emulator is at fault: train it again"
            .into(),
    };
    Error::Refused(format!("the prediction for {} is not finite; {reason}", in_words(body, theta)))
}

/// Requires that training samples lie inside the ranges.
pub(crate) fn require_inside(body: &Body, thetas: &[Vec<f64>]) -> Result<()> {
    for (sample, theta) in thetas.iter().enumerate() {
        check_length(body, theta)?;
        if let Some((p, value)) = outside(body, theta).next() {
            let [value, low, high] = [value, p.range[0], p.range[1]].map(|x| p.unit.format(x));
            let name = &p.name;
            return Err(Error::Refused(format!(
                "sample {sample} has {name} = {value}, outside its range from {low} to {high}: widen the range of the body's parameter, or leave the sample out"
            )));
        }
    }
    Ok(())
}
