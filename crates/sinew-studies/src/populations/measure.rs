//! A method on individuals that it has not seen: errors raw and corrected, beside times.

use super::stage::Individual;
use anyhow::Result;
use serde::{Deserialize, Serialize};
use sinew_fem::{Options, Solver};
use sinew_num::{difference, norm};
use std::time::Instant;

/// Newton steps that predictions are corrected by.
pub(super) const CORRECTIONS: usize = 2;

/// Two solutions farther apart than this \[relative\] are two equilibria: solves end many orders of magnitude nearer to theirs.
const ANOTHER: f64 = 1e-3;

/// Individuals with their true displacements.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// Description.
    pub name: String,
    /// The individuals that the solver solved.
    pub individuals: Vec<Individual>,
    /// Their displacements \[length\].
    pub truths: Vec<Vec<f64>>,
    /// Mean wall time \[s\] and median of the iterations of a cold solve.
    pub solve: [f64; 2],
    /// Individuals that the solver found no equilibrium for, and that are left out.
    pub unsolved: usize,
}

/// Results of a method on a group; an entry for each individual.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Outcome {
    /// The method.
    pub method: String,
    /// Simulations and training behind it.
    pub about: String,
    /// The group.
    pub group: String,
    /// CPU time of everything before the first individual: simulations and training \[s\].
    pub cpu_s: f64,
    /// Wall time of the answers \[s\].
    pub answer_s: Vec<f64>,
    /// `‖u − û‖ / ‖u‖` raw and after each Newton step.
    pub errors: Vec<Vec<f64>>,
    /// `|V − V̂| / V` of the cavity, raw, where there is one.
    pub volumes: Vec<f64>,
    /// Size of the first Newton step over the error of the prediction, which it estimates, where there is a step.
    pub estimates: Vec<f64>,
    /// Iterations of a solve that starts from the prediction, where it ends.
    pub iterations: Vec<f64>,
    /// Predictions that such a solve does not end from.
    pub unfinished: usize,
    /// Predictions that no Newton step corrects, for they turn cells over.
    pub inverted: usize,
    /// Predictions from which a solve ends at another equilibrium than from rest.
    pub elsewhere: usize,
    /// Number of these whose equilibrium has less energy than the one reached from rest.
    pub lower: usize,
}

impl Outcome {
    /// Share of all predictions whose error estimate is within a factor two \[%\].
    pub(super) fn estimates_within_two(&self) -> f64 {
        let within = self.estimates.iter().filter(|ratio| (0.5..=2.0).contains(*ratio)).count();
        100.0 * within as f64 / self.errors[0].len() as f64
    }
}

impl Group {
    /// Solves individuals; those without an equilibrium are left out.
    pub(super) fn new(name: &str, all: impl Iterator<Item = Result<Individual>>) -> Result<Self> {
        let mut group = Self { name: name.into(), ..Self::default() };
        let mut iterations = Vec::new();
        for individual in all {
            let individual = individual?;
            let start = Instant::now();
            let solved =
                Solver::new(&individual.body)?.solve(&individual.theta, &Options::default());
            let Ok(solved) = solved else {
                group.unsolved += 1;
                continue;
            };
            group.solve[0] += start.elapsed().as_secs_f64();
            iterations.push(solved.history.iterations.len());
            group.truths.push(solved.displacement);
            group.individuals.push(individual);
        }
        anyhow::ensure!(!group.truths.is_empty(), "{name}: no individual has an equilibrium");
        iterations.sort_unstable();
        group.solve =
            [group.solve[0] / group.truths.len() as f64, iterations[iterations.len() / 2] as f64];
        Ok(group)
    }

    /// Measures a method that predicts the displacement of an individual.
    pub(super) fn measure(
        &self,
        [method, about]: [&str; 2],
        cpu_s: f64,
        predict: impl Fn(&Individual) -> Result<Vec<f64>>,
    ) -> Result<Outcome> {
        let mut outcome = Outcome {
            method: method.into(),
            about: about.into(),
            group: self.name.clone(),
            cpu_s,
            errors: vec![Vec::new(); CORRECTIONS + 1],
            ..Outcome::default()
        };
        for (individual, truth) in self.individuals.iter().zip(&self.truths) {
            let start = Instant::now();
            let predicted = predict(individual)?;
            outcome.answer_s.push(start.elapsed().as_secs_f64());
            outcome.errors[0].push(distance(&predicted, truth));
            let (body, theta) = (&individual.body, &individual.theta);
            let volumes = body.cavity_volumes(truth).into_iter();
            let volumes = volumes.zip(body.cavity_volumes(&predicted)).take(1);
            outcome.volumes.extend(volumes.map(|(v, w)| (v - w).abs() / v));
            let mut solver = Solver::new(body)?;
            match solver.solve_from(&predicted, theta, &Options::default()) {
                Ok(solved) => {
                    outcome.iterations.push(solved.history.iterations.len() as f64);
                    if distance(&solved.displacement, truth) > ANOTHER {
                        let lower = solved.energy < body.value(truth, theta);
                        outcome.elsewhere += 1;
                        outcome.lower += usize::from(lower);
                    }
                }
                Err(_) => outcome.unfinished += 1,
            }
            let steps = solver.newton_steps(&predicted, theta, CORRECTIONS);
            outcome.inverted += usize::from(steps.is_err());
            let steps = steps.unwrap_or_default();
            if let Some(step) = steps.first() {
                let [estimate, error] =
                    [&step.displacement, truth].map(|u| norm(&difference(&predicted, u)));
                // A step that gets nowhere estimates nothing.
                if estimate > 0.0 && error > 0.0 {
                    outcome.estimates.push(estimate / error);
                }
            }
            let mut last = outcome.errors[0][outcome.errors[0].len() - 1];
            for (step, errors) in outcome.errors[1..].iter_mut().enumerate() {
                last = steps.get(step).map_or(last, |step| distance(&step.displacement, truth));
                errors.push(last);
            }
        }
        Ok(outcome)
    }
}

/// `‖u − û‖ / ‖u‖` over all nodes together.
fn distance(found: &[f64], truth: &[f64]) -> f64 {
    norm(&difference(found, truth)) / norm(truth)
}
