//! Stress, strain and error at the surface, as regressions over θ.

use super::compact::{AT_ONCE, Compact, Sampled, relative};
use super::surface::Surface;
use crate::Emulator;
use crate::stresses::at_nodes;
use sinew_emulate::{Counter, Observer, PodRegression, Result};
use sinew_energy::Body;
use sinew_energy::metrics::displacement_error;
use sinew_fem::{CellStress, SolverPool, cell_stresses};
use sinew_num::{in_parallel, try_in_parallel};
use sinew_report::format::digits;
use sinew_report::{Model, Quantity, Source};
use sinew_sample::quantile;

/// Highest total degree of the polynomials.
const DEGREE: usize = 5;
/// Part of the values that rounding may cost: a step of colour is larger.
const ROUNDING: f64 = 1e-3;
/// Shares of all values between which colours lie.
const COLOURED: [f64; 2] = [0.005, 0.995];
/// Predictions without an inverted cell that a regression needs.
const LEAST: usize = 50;

/// Fibre stretch and stress, or the largest principal ones of an isotropic law, each with the distance of its regression from values of the predictions
/// relative to their root mean square; nothing where most predictions invert cells.
pub(super) fn colours(
    body: &Body,
    surface: &Surface,
    fitted: &Sampled,
    checked: &Sampled,
) -> Result<Vec<(Quantity, f64)>> {
    type Read = fn(&CellStress) -> f64;
    let fibres = !body.material.directions(0).is_empty();
    let stress = body.units.stress.as_str();
    let own: [(&str, &str, Read); 2] = match fibres {
        true => [
            ("Fibre stretch", "1", |cell| cell.fibre.map_or(1.0, |fibre| fibre.stretch)),
            ("Fibre stress", stress, |cell| cell.fibre.map_or(0.0, |fibre| fibre.stress)),
        ],
        false => [
            ("Largest stretch", "1", |cell| cell.principal_stretches[0]),
            ("Largest stress", stress, |cell| cell.principal_stresses[0]),
        ],
    };
    let [fitted, checked] = [fitted, checked].map(|sampled| stressed(body, sampled));
    if fitted.thetas.len() < LEAST || checked.thetas.is_empty() {
        return Ok(Vec::new());
    }
    let mut colours = Vec::new();
    for (name, unit, read) in own {
        let of = |cells: &Vec<CellStress>| -> Vec<f64> {
            let values: Vec<f64> = cells.iter().map(read).collect();
            let nodes = at_nodes(body, 1, &values);
            surface.nodes.iter().map(|&node| nodes[node]).collect()
        };
        let values = |sampled: &Sampled<_>| in_parallel(&sampled.fields, of);
        let (samples, truth) = (values(&fitted), values(&checked));
        let regression =
            PodRegression::fit_polynomial(&body.parameters, &fitted.thetas, &samples, DEGREE)?;
        let compact = Compact::of(regression, None, &fitted.thetas, ROUNDING)?;
        let all = truth.concat();
        let scale = COLOURED.map(|share| quantile(&all, share));
        let truth = Sampled { thetas: checked.thetas.clone(), fields: truth };
        let [_, error] = relative(&compact, &truth, Clone::clone)?;
        let quantity = Quantity {
            name: name.into(),
            unit: unit.into(),
            source: Source::Model,
            scale,
            logarithmic: false,
            model: Some(compact.packed()),
        };
        colours.push((quantity, error));
    }
    Ok(colours)
}

/// Predictions that invert no cell, by their stresses.
fn stressed(body: &Body, sampled: &Sampled) -> Sampled<Vec<CellStress>> {
    let pairs = sampled.thetas.iter().zip(&sampled.fields);
    let found = in_parallel(pairs, |(theta, field)| {
        cell_stresses(body, field, theta).ok().map(|cells| (theta.clone(), cells))
    });
    let (thetas, fields) = found.into_iter().flatten().unzip();
    Sampled { thetas, fields }
}

/// Estimates that the error is regressed from.
const ESTIMATES: usize = 250;
/// Estimates that a regression needs.
const LEAST_ESTIMATES: usize = 40;
/// Highest total degree of the polynomials.
pub(super) const ERROR_DEGREE: usize = 4;
/// Least error of a node relative to the mean that has a colour of its own: held nodes have none at all.
const FLOOR: f64 = 1e-2;
/// Rounding error of the pattern \[relative to the norm of its logarithms\]: the pattern locates the error, in colours of a
/// decade each.
const PATTERN: f64 = 0.1;
/// Rounding error of the level \[relative to the norm of its logarithms\].
pub(super) const LEVEL: f64 = 1e-4;
/// Factor within which a shown error is said to be right.
pub(super) const FACTOR: f64 = 3.0;

/// Nodal errors of some parameter sets.
#[derive(Default)]
struct Errors {
    thetas: Vec<Vec<f64>>,
    /// Mean and largest at the surface \[length\].
    levels: Vec<[f64; 2]>,
    /// Relative to the mean, node by node.
    patterns: Vec<Vec<f64>>,
    /// Parameter sets without an estimate.
    refused: usize,
}

/// Error of the page over θ.
pub(super) struct ErrorModel {
    /// Logarithms of the mean and the largest; `None` where too few predictions have an estimate.
    pub(super) level: Option<Model>,
    /// Pattern of the error over the body.
    pub(super) quantity: Option<Quantity>,
    /// Number of test cases in which it is right, in words.
    pub(super) told: String,
}

impl ErrorModel {
    pub(super) fn of(
        emulator: &Emulator<'_>,
        shown: &Compact,
        surface: &Surface,
        fitted: &Sampled,
        checked: &Sampled,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let all = fitted.thetas.iter().zip(&fitted.fields).take(ESTIMATES);
        let cases: Vec<_> = all.chain(checked.thetas.iter().zip(&checked.fields)).collect();
        let (first, last) = cases.split_at(cases.len() - checked.thetas.len());
        let mut counter = Counter::new(observer, "estimate its errors", 0, cases.len());
        let known = errors(emulator, shown, surface, first, &mut counter)?;
        let test = errors(emulator, shown, surface, last, &mut counter)?;
        let refused = known.refused + test.refused;
        if known.thetas.len() < LEAST_ESTIMATES || test.thetas.is_empty() {
            let told = format!(
                "none: {refused} of {} predictions are not near an equilibrium",
                cases.len()
            );
            return Ok(Self { level: None, quantity: None, told });
        }
        let parameters = &emulator.body().parameters;
        let logarithms: Vec<Vec<f64>> =
            known.levels.iter().map(|levels| levels.map(f64::ln).to_vec()).collect();
        let level =
            PodRegression::fit_polynomial(parameters, &known.thetas, &logarithms, ERROR_DEGREE)?;
        let mut right = 0;
        for (theta, levels) in test.thetas.iter().zip(&test.levels) {
            let ratio = levels[0] / level.predict(theta)?[0].exp();
            right += usize::from((1.0 / FACTOR..=FACTOR).contains(&ratio));
        }
        let mut told = format!(
            "within a factor of {FACTOR} of the checked one in {right} of {} cases",
            test.thetas.len()
        );
        if refused > 0 {
            told += &format!("; {refused} of {} predictions have none", cases.len());
        }
        let pattern = PodRegression::fit_polynomial(parameters, &known.thetas, &known.patterns, 2)?;
        let pattern = Compact::of(pattern, None, &known.thetas, PATTERN)?;
        let quantity = Quantity {
            name: "Error".into(),
            unit: emulator.body().units.length.clone(),
            source: Source::Error,
            scale: scale(&known),
            logarithmic: true,
            model: Some(pattern.packed()),
        };
        let level = Compact::of(level, None, &known.thetas, LEVEL)?.packed();
        Ok(Self { level: Some(level), quantity: Some(quantity), told })
    }
}

/// Nodal distances of the displacements on the page from the equilibria of checked error estimates.
fn errors(
    emulator: &Emulator<'_>,
    shown: &Compact,
    surface: &Surface,
    cases: &[(&Vec<f64>, &Vec<f64>)],
    counter: &mut Counter<'_>,
) -> Result<Errors> {
    let solvers = SolverPool::new(emulator.body());
    let mut found = Errors::default();
    for some in cases.chunks(AT_ONCE) {
        let each = try_in_parallel(some, |(theta, field)| -> Result<_> {
            let estimate = solvers.with(|solver| solver.error_estimate(field, theta))?;
            let Ok(distance) = estimate.distance else { return Ok(None) };
            let (truth, own) = (surface.of_field(&distance.equilibrium), shown.at(theta)?);
            Ok(Some(displacement_error(&truth, &own)))
        })?;
        for ((theta, _), nodal) in some.iter().zip(each) {
            let Some(nodal) = nodal else {
                found.refused += 1;
                continue;
            };
            let mean = nodal.iter().sum::<f64>() / nodal.len() as f64;
            let largest = nodal.iter().copied().fold(0.0, f64::max);
            // A page that is exact to the last digit has no error to speak of.
            let mean = mean.max(f64::MIN_POSITIVE);
            found.thetas.push(theta.to_vec());
            found.levels.push([mean, largest.max(mean)]);
            found.patterns.push(nodal.iter().map(|e| (e / mean).max(FLOOR).ln()).collect());
        }
        let _ = counter.step(some.len(), "");
        counter.check()?;
    }
    Ok(found)
}

/// Ends of the error's scale: 0.3 times the 5 % quantile of the means, and the largest error but one in twenty.
fn scale(known: &Errors) -> [f64; 2] {
    let quantile = |which: usize, share: f64| {
        let all: Vec<f64> = known.levels.iter().map(|levels| levels[which]).collect();
        let value = sinew_sample::quantile(&all, share);
        // Two digits are enough for the ends of a scale.
        digits(value, 2).parse().unwrap_or(value)
    };
    [0.3 * quantile(0, 0.05), quantile(1, 0.95)]
}
