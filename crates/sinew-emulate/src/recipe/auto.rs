//! The recipe that held-out cases prefer.

use super::{Hybrid, Recipe, Regression};
use crate::emulator::{Emulator, Model};
use crate::evaluate::{Errors, TestSet, root_mean_square};
use crate::session::Session;
use crate::{Record, Result, Warning};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Tries regression on more and more simulations, and networks only where its error on the held-out cases misses the target;
/// the least error there wins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Auto {
    /// Regression, with the error that settles the choice.
    pub regression: Regression,
    /// What is tried where regression misses it.
    pub rivals: Vec<Recipe>,
}

impl Default for Auto {
    fn default() -> Self {
        Self { regression: Regression::default(), rivals: vec![Hybrid::default().into()] }
    }
}

/// A recipe that was tried, and how well it did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Short name of the recipe.
    pub recipe: String,
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Root mean square of `‖u − û‖ / ‖u‖` over the held-out cases, raised by the share of them whose prediction inverts a cell: the
    /// same measure for every candidate.
    pub error: f64,
    /// Wall time of simulations and training \[s\].
    pub seconds: f64,
    /// What was tried, in words.
    pub detail: String,
}

/// What was tried and what was taken; printed, it says why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// In the order they were tried.
    pub candidates: Vec<Candidate>,
    /// Index of the one that was taken.
    pub taken: usize,
    /// Error that settles the choice for a regression.
    pub target: f64,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for candidate in &self.candidates {
            let Candidate { recipe, simulations, error, seconds, detail } = candidate;
            writeln!(
                f,
                "{recipe} on {simulations} simulations: error {error:.1e} after {seconds:.1} s ({detail})"
            )?;
        }
        let Some(taken) = self.candidates.get(self.taken) else { return Ok(()) };
        let (recipe, error, target) = (&taken.recipe, taken.error, self.target);
        if error <= target {
            write!(
                f,
                "{recipe} was taken, for its error {error:.1e} meets the target of {target:.1e}"
            )
        } else {
            write!(
                f,
                "{recipe} was taken, for nothing met the target of {target:.1e} and its error {error:.1e} is the least"
            )
        }
    }
}

impl Auto {
    pub(crate) fn model(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Model> {
        let target = self.regression.target;
        let (regression, error) = self.regression.fit(session, held_out, record)?;
        let mut best = (Model::from(regression), error);
        let mut choice = record.choice.take().unwrap_or_default();
        for rival in self.rivals.iter().filter(|_| error > target) {
            let mut own = Record::new(rival.clone());
            let (spent, solved) = (session.simulate_s, session.simulations);
            let model = rival.model(session, held_out, &mut own)?;
            let emulator = Emulator::new(session.body, model, own);
            let fields = emulator.predict(&held_out.thetas)?.fields();
            let cases = held_out.cases(&fields)?;
            let error = root_mean_square(&cases);
            let seconds = session.simulate_s - spent + emulator.record.train_s;
            let median = Errors::of(&cases).relative.q50;
            choice.candidates.push(Candidate {
                recipe: rival.key().into(),
                simulations: session.simulations,
                error,
                seconds,
                detail: format!("{} steps, median {median:.1e}", emulator.record.steps),
            });
            let (model, own) = emulator.into_parts();
            if error < best.1 {
                choice.taken = choice.candidates.len() - 1;
                best = (model, error);
                *record = Record { recipe: record.recipe.clone(), ..own };
            } else {
                session.simulations = solved;
            }
        }
        if best.1 > target {
            session.warn(Warning::TargetMissed { error: best.1, target });
        }
        record.choice = Some(choice);
        Ok(best.0)
    }
}
