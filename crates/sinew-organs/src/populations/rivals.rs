//! What regression on registered shapes makes of simulations.

use super::measure::cpu_seconds;
use super::stage::{Individual, Stage, shape_parameters};
use anyhow::Result;
use sinew::Parameter;
use sinew_emulate::{PodRegression, share_of};
use sinew_fem::{Options, Solver, coarse_displacement};

/// Simulations of individuals of a population, and what is fitted to them.
pub(super) struct Rivals {
    inputs: Vec<Vec<f64>>,
    fields: Vec<Vec<f64>>,
    mean: Vec<f64>,
    plain: Fit,
    about_coarse: Fit,
    /// CPU time of the simulations \[s\].
    pub simulated_s: f64,
}

/// A regression of fields, or of what solutions on a coarse mesh leave of them.
pub(super) struct Fit {
    regression: PodRegression,
    /// CPU time with the simulations \[s\].
    pub cpu_s: f64,
    /// What the regression is.
    pub about: String,
}

impl Rivals {
    /// Simulates `count` individuals and fits regressions over shape numbers and parameters; without equilibrium on the coarse mesh an
    /// individual is left out.
    ///
    /// # Errors
    /// Individuals that cannot be drawn; a regression that cannot be fitted.
    pub(super) fn new(stage: &Stage, stream: u64, count: usize) -> Result<Self> {
        let start = cpu_seconds();
        let (mut inputs, mut fields, mut parameters) = (Vec::new(), Vec::new(), Vec::new());
        let (mut left, mut coarse_s) = (Vec::new(), 0.0);
        for index in 0..count as u64 {
            let individual = stage.draw(stream, index)?;
            let solved =
                Solver::new(&individual.body)?.solve(&individual.theta, &Options::default());
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
        let fit = |fields: &[Vec<f64>], before_s: f64| -> Result<Fit> {
            let start = cpu_seconds();
            let regression = PodRegression::fit(&parameters, &inputs, fields)?;
            let interpolation = regression.interpolation().to_string();
            let (modes, count) = (regression.modes(), fields.len());
            let interpolation = interpolation.split(", lengths").next().unwrap_or_default();
            let about = format!("{count} simulations; {modes} modes, {interpolation}");
            Ok(Fit { regression, cpu_s: before_s + cpu_seconds() - start, about })
        };
        let [plain, about_coarse] =
            [fit(&fields, simulated_s)?, fit(&left, simulated_s + coarse_s)?];
        let mut mean = vec![0.0; fields[0].len()];
        for field in &fields {
            mean.iter_mut().zip(field).for_each(|(m, u)| *m += u / fields.len() as f64);
        }
        Ok(Self { inputs, fields, mean, plain, about_coarse, simulated_s })
    }

    /// The regression of the fields, and of what a coarse solution leaves.
    pub(super) fn fits(&self) -> [&Fit; 2] {
        [&self.plain, &self.about_coarse]
    }

    /// The mean of the simulations.
    pub(super) fn mean(&self) -> Vec<f64> {
        self.mean.clone()
    }

    /// The simulation whose numbers are nearest, on the scales of their ranges.
    pub(super) fn nearest(&self, individual: &Individual) -> Vec<f64> {
        let parameters = all_parameters(individual);
        let own = input(individual);
        let distance = |other: &[f64]| -> f64 {
            let terms = own.iter().zip(other).zip(&parameters);
            terms.map(|((a, b), p)| (share_of(p, *a) - share_of(p, *b)).powi(2)).sum()
        };
        let pairs = self.inputs.iter().zip(&self.fields);
        let nearest = pairs.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
        nearest.map(|(_, field)| field.clone()).unwrap_or_default()
    }

    /// What regression predicts.
    ///
    /// # Errors
    /// Numbers that do not belong to the population.
    pub(super) fn predict(&self, individual: &Individual) -> Result<Vec<f64>> {
        Ok(self.plain.regression.predict(&input(individual))?)
    }

    /// What regression adds to the solution on a coarse mesh; nothing is added to rest where there is none.
    ///
    /// # Errors
    /// As [`Rivals::predict`].
    pub(super) fn predict_about_coarse(
        &self,
        stage: &Stage,
        individual: &Individual,
    ) -> Result<Vec<f64>> {
        let Some(coarse) = coarse(stage, individual)? else {
            return Ok(vec![0.0; 3 * individual.body.nodes]);
        };
        let left = self.about_coarse.regression.predict(&input(individual))?;
        Ok(coarse.iter().zip(left).map(|(c, left)| c + left).collect())
    }
}

/// The solution on a coarse mesh, at the nodes of the individual's own \[length\]; `None` where there is none.
///
/// # Errors
/// A body that cannot be lowered.
pub(super) fn coarse(stage: &Stage, individual: &Individual) -> Result<Option<Vec<f64>>> {
    let Some(body) = stage.coarse(individual)? else { return Ok(None) };
    let Individual { body: fine, theta, .. } = individual;
    Ok(coarse_displacement(&body, fine, theta, &Options::default()).ok())
}

fn input(individual: &Individual) -> Vec<f64> {
    individual.numbers.iter().chain(&individual.theta).copied().collect()
}

fn all_parameters(individual: &Individual) -> Vec<Parameter> {
    let numbers = shape_parameters(individual.numbers.len());
    numbers.chain(individual.body.parameters.iter().cloned()).collect()
}
