//! Decomposition of few simulations, or of what second order leaves of them, and a Gaussian process.

use crate::emulator::Model;
use crate::recipe::Candidate;
use crate::series::{Regressed, Series};
use crate::session::{Session, Stream};
use crate::simulate::{Simulations, read_simulations};
use crate::{Budget, Design, Record, Result, Warning};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Proper orthogonal decomposition of few simulations and interpolation of its coefficients, see [`crate::PodRegression`]; or of
/// what [`Recipe::Series`](crate::Recipe::Series) leaves of them, where that halves the error by leaving one out.
/// The number of simulations doubles until the leave-one-out error meets the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Regression {
    /// Simulations at first.
    pub simulations: usize,
    /// Simulations at most.
    pub most: usize,
    /// Leave-one-out error to be met, root mean square norm relative to that of the displacements; zero asks for the most
    /// simulations without expecting anything of them.
    pub target: f64,
}

impl Default for Regression {
    fn default() -> Self {
        Self { simulations: 25, most: 200, target: 1e-3 }
    }
}

impl Regression {
    pub(crate) fn model(
        &self,
        session: &mut Session<'_, '_>,
        record: &mut Record,
    ) -> Result<Model> {
        let (regression, error) = self.fit(session, record)?;
        if self.target > 0.0 && error > self.target {
            session.warn(Warning::TargetMissed { error, target: self.target });
        }
        Ok(regression.into())
    }

    /// The regression and its leave-one-out error; every number of simulations that was tried is in the record.
    pub(crate) fn fit(
        &self,
        session: &mut Session<'_, '_>,
        record: &mut Record,
    ) -> Result<(Regressed, f64)> {
        if let Some(folder) = &session.options.simulations {
            return self.fit_stored(session, folder, record);
        }
        let most = self.most.max(self.simulations);
        // The first samples of Sobol's sequence are themselves a design, so that none is wasted when more follow.
        let thetas = session.thetas(Design::Sobol, most, Stream::Regression)?;
        let most = thetas.len();
        let mut count = self.simulations.clamp(2, most.max(2)).min(most);
        let series = series(session, record);
        let mut found = Simulations::default();
        loop {
            let tried = found.thetas.len() + found.failures.len();
            found.extend(session.simulate(&format!("regression {count}"), &thetas[tried..count])?);
            let start = Instant::now();
            let (fit, error) =
                Regressed::fit(session.body, series.as_ref(), &found.thetas, &found.fields)?;
            let seconds = start.elapsed().as_secs_f64();
            record.train_s += seconds;
            session.simulations = found.fields.len();
            self.tried(record, &found, &fit, error, seconds);
            let outcome = format!("{count} simulations: error {error:.1e} by leaving one out");
            session.observer.finished("regression", &outcome, seconds);
            let affordable = match session.options.budget {
                Budget::Seconds(budget) => 3.0 * session.simulate_s < budget,
                _ => true,
            };
            if error <= self.target || count >= most || !affordable {
                return Ok((fit, error));
            }
            count = (2 * count).min(most);
        }
    }

    /// One fit to simulations that are there.
    fn fit_stored(
        &self,
        session: &mut Session<'_, '_>,
        folder: &std::path::Path,
        record: &mut Record,
    ) -> Result<(Regressed, f64)> {
        let mut found = read_simulations(session.body, folder)?;
        found.keep(self.most);
        session.simulate_s += found.seconds;
        session.simulations = found.fields.len();
        let series = series(session, record);
        let start = Instant::now();
        let (fit, error) =
            Regressed::fit(session.body, series.as_ref(), &found.thetas, &found.fields)?;
        let seconds = start.elapsed().as_secs_f64();
        record.train_s += seconds;
        self.tried(record, &found, &fit, error, seconds);
        Ok((fit, error))
    }

    /// Notes a fit that was tried, and took these seconds, as the one that is taken so far.
    fn tried(
        &self,
        record: &mut Record,
        found: &Simulations,
        fit: &Regressed,
        error: f64,
        seconds: f64,
    ) {
        let choice = record.choice.get_or_insert_default();
        (choice.target, choice.taken) = (self.target, choice.candidates.len());
        choice.candidates.push(Candidate {
            recipe: "regression".into(),
            simulations: found.fields.len(),
            error,
            seconds: found.seconds + seconds,
            detail: fit.detail(),
        });
    }
}

/// The series of second order; none for a body that has no solution at the centre of its parameters' ranges.
fn series(session: &Session<'_, '_>, record: &mut Record) -> Option<Series> {
    let start = Instant::now();
    let series = Series::of(session.body, session.options.seed).ok();
    record.prepare_s += start.elapsed().as_secs_f64();
    series
}
