//! The recipe that held-out cases prefer.

use super::{DataDriven, Recipe, Regression};
use serde::{Deserialize, Serialize};
use sinew_emulate::parts::{Session, require_finite, root_mean_square};
use sinew_emulate::{Candidate, Errors, Predictor, Record, Result, TestSet, Train, Warning};

/// Tries regression on more and more simulations, and networks only where its error on the held-out cases misses the target;
/// the recipe with the least error there is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Auto {
    /// Regression, with the error that settles the choice.
    pub regression: Regression,
    /// Recipes that are tried where regression misses it.
    pub rivals: Vec<Recipe>,
}

impl Default for Auto {
    fn default() -> Self {
        Self { regression: Regression::default(), rivals: vec![DataDriven::default().into()] }
    }
}

impl Auto {
    pub(crate) fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>> {
        let target = self.regression.target;
        let (regression, error) = self.regression.fit(session, held_out, record)?;
        let mut best = (regression, error);
        let mut choice = record.choice.take().unwrap_or_default();
        for rival in self.rivals.iter().filter(|_| error > target) {
            let mut own = Record::new(rival.key());
            let (spent, solved) = (session.simulate_s, session.simulations);
            let model = rival.predictor(session, held_out, &mut own)?;
            let predicted = model.predict(session.body, &held_out.thetas)?;
            require_finite(session.body, &held_out.thetas, &predicted)?;
            let length = predicted.len() / held_out.thetas.len().max(1);
            let fields: Vec<_> = predicted.chunks(length.max(1)).map(<[f64]>::to_vec).collect();
            let cases = held_out.cases(&fields)?;
            let error = root_mean_square(&cases);
            let seconds = session.simulate_s - spent + own.train_s;
            let median = Errors::of(&cases).relative.q50;
            choice.candidates.push(Candidate {
                recipe: rival.key().into(),
                simulations: session.simulations,
                error,
                seconds,
                detail: rival
                    .with_settings(format!("{} steps, median {median:.1e}", own.steps), &own),
            });
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
