//! Recipes without networks: decomposition of few simulations, or of what second order leaves of them, with a Gaussian process; a Taylor
//! expansion.

use crate::error::require;
use crate::estimate::evaluate::{TestSet, root_mean_square, timed};
use crate::predict::Predictor;
use crate::predict::regressed::Regressed;
use crate::predict::taylor;
use crate::recipe::Train;
use crate::recipe::session::{Session, Stream};
use crate::sample::simulate::{Simulations, read_simulations};
use crate::store::record::{Candidate, Record};
use crate::{Budget, Design, Result, TrainingOptions, Warning};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::time::Instant;

/// Proper orthogonal decomposition of few simulations and interpolation of its coefficients, see [`crate::PodRegression`].
/// The remainder of the [`Taylor`](super::Taylor) expansion is regressed instead if that halves the leave-one-out error.
/// The number of simulations doubles until the error on the held-out cases meets the target. The fit with the lowest error
/// is taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Regression {
    /// Simulations at first.
    pub simulations: usize,
    /// Simulations at most.
    pub most: usize,
    /// Error to be met on the held-out cases, [`Candidate::error`]. Zero takes the largest number of simulations and gives
    /// no warning.
    pub target: f64,
}

impl Default for Regression {
    fn default() -> Self {
        Self { simulations: 25, most: 200, target: 1e-3 }
    }
}

impl Train for Regression {
    fn key(&self) -> &'static str {
        "regression"
    }

    fn settings(&self) -> Value {
        let Self { simulations, most, target } = self;
        json!({ "recipe": self.key(), "simulations": simulations, "most": most, "target": target })
    }

    fn about(&self, record: &Record) -> String {
        record.taken().map_or_else(String::new, |taken| {
            format!("regression on {} simulations, {}", taken.simulations, taken.detail)
        })
    }

    fn check(&self) -> Result<()> {
        let (target, advice) = (self.target, "give a finite number that is not negative");
        let makes_sense = target >= 0.0 && target.is_finite();
        require(makes_sense, "the target of a regression", target, advice)
    }

    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>> {
        // None for a body that has no solution at the centre of its parameters' ranges.
        let taylor = timed(&mut record.prepare_s, || {
            taylor::solved(session.body, 1, session.options.seed, &mut ()).ok()
        });
        let (body, mut best) = (session.body, None::<(Regressed, f64)>);
        // Fits, notes it in the record, and takes it if it is the best; its error.
        let mut fit = |session: &mut Session<'_, '_>, found: &Simulations| -> Result<f64> {
            let start = Instant::now();
            let (thetas, taylor) = (&found.thetas, taylor.as_ref());
            let (fit, left_out) = Regressed::fit(body, taylor, thetas, &found.fields)?;
            let seconds = start.elapsed().as_secs_f64();
            record.train_s += seconds;
            let fields = held_out.thetas.iter().map(|theta| fit.at(body, theta));
            let cases = held_out.cases(&fields.collect::<Result<Vec<_>>>()?)?;
            let error = root_mean_square(&cases);
            let simulations = found.fields.len();
            let outcome = format!(
                "{simulations} simulations: root mean square error {error:.1e} over the held-out cases"
            );
            session.observer.finished("regression", &outcome, seconds);
            let choice = record.choice.get_or_insert_default();
            choice.target = self.target;
            choice.candidates.push(Candidate {
                simulations,
                error,
                seconds: found.seconds + seconds,
                detail: format!("{left_out:.1e} by leaving one out, {}", fit.detail()),
            });
            if best.as_ref().is_none_or(|(_, best)| error < *best) {
                choice.taken = choice.candidates.len() - 1;
                best = Some((fit, error));
            }
            Ok(error)
        };
        if let Some(folder) = &session.options.simulations {
            let mut found = read_simulations(body, folder)?;
            found.keep(self.most);
            session.simulate_s += found.seconds;
            fit(session, &found)?;
        } else {
            let most = self.most.max(self.simulations);
            // The first samples of Sobol's sequence are themselves a design, so that none is wasted when more follow.
            let thetas = session.thetas(Design::Sobol, most, Stream::Regression)?;
            let most = thetas.len();
            let mut count = self.simulations.clamp(2, most.max(2)).min(most);
            let mut found = Simulations::default();
            loop {
                let tried = found.thetas.len() + found.failures.len();
                let name = format!("regression {count}");
                found.extend(session.simulate(&name, &thetas[tried..count])?);
                let error = fit(session, &found)?;
                let affordable = match session.options.budget {
                    Budget::Seconds(budget) => 3.0 * session.simulate_s < budget,
                    _ => true,
                };
                if error <= self.target || count >= most || !affordable {
                    break;
                }
                count = (2 * count).min(most);
            }
        }
        session.simulations = record.taken().map_or(0, |taken| taken.simulations);
        let (fit, error) = best.expect("a fit was made");
        if self.target > 0.0 && error > self.target {
            session.warn(Warning::TargetMissed { error, target: self.target });
        }
        Ok(Box::new(fit))
    }
}

/// Taylor expansion of second order about the solution at the centre of the parameters' ranges, and further anchors: nothing is trained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Taylor;

impl Train for Taylor {
    fn key(&self) -> &'static str {
        taylor::KEY
    }

    fn settings(&self) -> Value {
        json!({ "recipe": self.key() })
    }

    fn has_anchors(&self) -> bool {
        true
    }

    fn about(&self, record: &Record) -> String {
        taylor::about(record.simulations)
    }

    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        _: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>> {
        let TrainingOptions { anchors, seed, .. } = *session.options;
        let taylor = timed(&mut record.prepare_s, || {
            taylor::solved(session.body, anchors, seed, session.observer)
        })?;
        session.simulations = anchors;
        Ok(Box::new(Regressed { taylor: Some(taylor), regression: None }))
    }
}
