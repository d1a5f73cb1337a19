//! What regression on registered shapes makes of simulations.

use super::measure::cpu_seconds;
use super::stage::{Individual, Stage};
use anyhow::Result;
use sinew::Parameter;
use sinew_emulate::{PodRegression, share_of};
use sinew_fem::{Options, Solver};

/// Simulations of individuals of a population, and what is fitted to them.
pub struct Rivals {
    inputs: Vec<Vec<f64>>,
    fields: Vec<Vec<f64>>,
    mean: Vec<f64>,
    regression: PodRegression,
    /// CPU time of simulations alone and with the regression \[s\].
    pub cpu_s: [f64; 2],
    /// What the regression is.
    pub about: String,
}

/// Shape numbers count as parameters over this many deviations to either side.
const RANGE: f64 = 1.7320508075688772;

impl Rivals {
    /// Simulates `count` individuals and fits a regression over shape numbers and parameters.
    ///
    /// # Errors
    /// Individuals that cannot be drawn; a regression that cannot be fitted.
    pub fn new(stage: &Stage, stream: u64, count: usize) -> Result<Self> {
        let start = cpu_seconds();
        let (mut inputs, mut fields, mut parameters) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..count as u64 {
            let individual = stage.draw(stream, index)?;
            let solver =
                Solver::new(&individual.body)?.solve(&individual.theta, &Options::default());
            let Ok(solved) = solver else { continue };
            if parameters.is_empty() {
                parameters = all_parameters(&individual);
            }
            inputs.push(input(&individual));
            fields.push(solved.displacement);
        }
        let simulated = cpu_seconds();
        let regression = PodRegression::fit(&parameters, &inputs, &fields)?;
        let mut mean = vec![0.0; fields[0].len()];
        for field in &fields {
            mean.iter_mut().zip(field).for_each(|(m, u)| *m += u / fields.len() as f64);
        }
        let about = format!(
            "{} simulations; {} modes, {}",
            fields.len(),
            regression.modes(),
            regression.interpolation().to_string().split(", lengths").next().unwrap_or_default()
        );
        let cpu_s = [simulated - start, cpu_seconds() - start];
        Ok(Self { inputs, fields, mean, regression, cpu_s, about })
    }

    /// The mean of the simulations.
    pub fn mean(&self) -> Vec<f64> {
        self.mean.clone()
    }

    /// The simulation whose numbers are nearest, on the scales of their ranges.
    pub fn nearest(&self, individual: &Individual) -> Vec<f64> {
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

    /// What the regression predicts.
    ///
    /// # Errors
    /// Numbers that do not belong to the population.
    pub fn predict(&self, individual: &Individual) -> Result<Vec<f64>> {
        Ok(self.regression.predict(&input(individual))?)
    }
}

fn input(individual: &Individual) -> Vec<f64> {
    individual.numbers.iter().chain(&individual.theta).copied().collect()
}

fn all_parameters(individual: &Individual) -> Vec<Parameter> {
    let numbers = (0..individual.numbers.len())
        .map(|i| Parameter::linear(format!("shape {}", i + 1), "", -RANGE..=RANGE));
    numbers.chain(individual.body.parameters.iter().cloned()).collect()
}
