//! Regression on registered shapes.

use super::nested::coarse_displacement;
use super::stage::{Individual, Stage, shape_parameters};
use crate::program::cpu_seconds;
use anyhow::Result;
use sinew::Parameter;
use sinew_emulate::{PodRegression, share_of};
use sinew_fem::{Options, Solver};

/// A method that learned from simulations.
pub(super) struct Rival<'a> {
    /// Description, and simulations behind it.
    pub names: [String; 2],
    /// CPU time of its simulations and its fit \[s\].
    pub cpu_s: f64,
    pub predict: Predict<'a>,
}

/// Displacement of an individual \[length\].
pub(super) type Predict<'a> = Box<dyn Fn(&Individual) -> Result<Vec<f64>> + 'a>;

/// Simulates `count` individuals: their mean, the nearest of them on the scales of their numbers, and regressions over shape numbers
/// and parameters of their fields, and of what solutions on a coarse mesh leave of these; without equilibrium on the coarse mesh an
/// individual is left out.
pub(super) fn rivals(stage: &Stage, stream: u64, count: usize) -> Result<Vec<Rival<'_>>> {
    let start = cpu_seconds();
    let (mut inputs, mut fields, mut parameters) = (Vec::new(), Vec::new(), Vec::new());
    let (mut left, mut coarse_s) = (Vec::new(), 0.0);
    for index in 0..count as u64 {
        let individual = stage.draw(stream, index)?;
        let solved = Solver::new(&individual.body)?.solve(&individual.theta, &Options::default());
        let Ok(solved) = solved else { continue };
        let clock = cpu_seconds();
        let coarse = coarse(stage, &individual)?;
        coarse_s += cpu_seconds() - clock;
        let Some(coarse) = coarse else { continue };
        parameters = all_parameters(&individual);
        inputs.push(input(&individual));
        left.push(solved.displacement.iter().zip(coarse).map(|(u, c)| u - c).collect());
        fields.push(solved.displacement);
    }
    let simulated_s = cpu_seconds() - start - coarse_s;
    let fit = |fields: &[Vec<f64>], before_s: f64| -> Result<(PodRegression, String, f64)> {
        let start = cpu_seconds();
        let regression = PodRegression::fit(&parameters, &inputs, fields)?;
        let (modes, count) = (regression.modes(), fields.len());
        let about = format!("{count} simulations; {modes} modes, {}", in_short(&regression));
        Ok((regression, about, before_s + cpu_seconds() - start))
    };
    let (plain, plain_about, plain_s) = fit(&fields, simulated_s)?;
    let (about_coarse, coarse_about, coarse_s) = fit(&left, simulated_s + coarse_s)?;
    let mut mean = vec![0.0; fields[0].len()];
    for field in &fields {
        mean.iter_mut().zip(field).for_each(|(m, u)| *m += u / fields.len() as f64);
    }
    let of = || format!("{count} simulations");
    let rival =
        |name: &str, about, cpu_s, predict| Rival { names: [name.into(), about], cpu_s, predict };
    Ok(vec![
        rival("mean", of(), simulated_s, Box::new(move |_| Ok(mean.clone()))),
        rival("nearest", of(), simulated_s, Box::new(move |of| Ok(nearest(of, &inputs, &fields)))),
        rival("POD + GP", plain_about, plain_s, Box::new(move |of| Ok(plain.predict(&input(of))?))),
        rival(
            "POD + GP about the coarse solution",
            coarse_about,
            coarse_s,
            Box::new(move |of| {
                // Nothing is added to rest where there is no coarse solution.
                let Some(coarse) = coarse(stage, of)? else { return Ok(of.rest()) };
                let left = about_coarse.predict(&input(of))?;
                Ok(coarse.iter().zip(left).map(|(c, left)| c + left).collect())
            }),
        ),
    ])
}

/// Interpolation of a regression in words, without its lengths.
pub(super) fn in_short(regression: &PodRegression) -> String {
    let text = regression.interpolation().to_string();
    text.split(", lengths").next().unwrap_or_default().into()
}

/// The simulation whose numbers are nearest, on the scales of their ranges.
fn nearest(individual: &Individual, inputs: &[Vec<f64>], fields: &[Vec<f64>]) -> Vec<f64> {
    let (parameters, own) = (all_parameters(individual), input(individual));
    let distance = |other: &[f64]| -> f64 {
        let terms = own.iter().zip(other).zip(&parameters);
        terms.map(|((a, b), p)| (share_of(p, *a) - share_of(p, *b)).powi(2)).sum()
    };
    let nearest = inputs.iter().zip(fields).min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
    nearest.map(|(_, field)| field.clone()).unwrap_or_default()
}

/// The solution on a coarse mesh, at the nodes of the individual's own \[length\]; `None` without a solution.
pub(super) fn coarse(stage: &Stage, individual: &Individual) -> Result<Option<Vec<f64>>> {
    let Some(body) = stage.coarse(individual)? else { return Ok(None) };
    let Individual { body: fine, theta, .. } = individual;
    Ok(coarse_displacement(&body, fine, theta).ok())
}

fn input(individual: &Individual) -> Vec<f64> {
    individual.numbers.iter().chain(&individual.theta).copied().collect()
}

fn all_parameters(individual: &Individual) -> Vec<Parameter> {
    let numbers = shape_parameters(individual.numbers.len());
    numbers.chain(individual.body.parameters.iter().cloned()).collect()
}
