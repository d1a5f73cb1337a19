//! The course of a training over its stages: the curve on the held-out cases, and the weights that are kept.

use super::{Plan, trainer};
use crate::data::{DataSet, Geometry};
use crate::error::{Error, Result};
use crate::surrogate::Surrogate;
use crate::training::{Concern, HistoryPoint, TrainingConfig, TrainingReport};
use sinew_emulate::parts::Session;
use sinew_emulate::store::{read_json, write_json};
use sinew_emulate::{CurvePoint, Kept, Observer, Progress, TestSet, Warning};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// The stages of a training and what they leave.
pub(super) struct Course {
    pub curve: Vec<CurvePoint>,
    file: Option<PathBuf>,
    /// Steps and seconds of the stages before.
    pub before: (u64, f64),
    /// Weights of the latest stage.
    pub kept: Option<Kept>,
}

impl Course {
    pub(super) fn new(session: &Session<'_, '_>) -> Result<Self> {
        let file = session.folder("curve.json");
        let stored = match &file {
            Some(file) if session.options.resume => read_json(file)?,
            _ => None,
        };
        Ok(Self { curve: stored.unwrap_or_default(), file, before: (0, 0.0), kept: None })
    }

    pub(super) fn stage(
        &mut self,
        session: &mut Session<'_, '_>,
        name: &str,
        data: &DataSet,
        plan: &Plan<'_>,
        config: &TrainingConfig,
    ) -> Result<Surrogate> {
        let stage = format!("train {} ({name})", plan.recipe);
        let checkpoint = session.folder(name);
        let mut trainer = trainer(session, checkpoint.as_deref(), data, plan, config)?;
        let mut watch = Watch {
            course: self,
            observer: &mut *session.observer,
            stage: &stage,
            held_out: plan.held_out,
            geometry: &data.geometries[0],
            warned: false,
        };
        if session.options.budget.is_nothing() {
            return Ok(trainer.into_surrogate());
        }
        let report = trainer.run(&mut watch)?;
        if report.interrupted {
            return Err(sinew_emulate::Error::Interrupted { stage }.into());
        }
        self.finish(session, &stage, report);
        Ok(trainer.into_surrogate())
    }

    /// The network of an earlier stage or of the last, whichever has the lower error. A Taylor expansion about one state
    /// may be worse at the ends of wide ranges than the earlier stage.
    pub(super) fn better(
        &mut self,
        earlier: Option<(Surrogate, Kept)>,
        last: Surrogate,
    ) -> Surrogate {
        let error = |kept: Kept| kept.error.unwrap_or(f64::INFINITY);
        match (earlier, self.kept) {
            (Some((surrogate, first)), Some(kept)) if error(first) < error(kept) => {
                self.kept = Some(Kept { returns: kept.returns, ..first });
                surrogate
            }
            _ => last,
        }
    }

    fn finish(&mut self, session: &mut Session<'_, '_>, stage: &str, report: TrainingReport) {
        let TrainingReport { kept_step, kept_error: error, .. } = report;
        let (step, before) = (self.before.0 + kept_step as u64, self.kept.map_or(0, |k| k.returns));
        self.kept = Some(Kept { step, error, returns: before + report.returns });
        let kept = self.curve.iter().find(|point| point.step == step);
        let error = kept.and_then(|point| point.medians).map_or(String::new(), |[u, ..]| {
            format!(", median error {u:.2e} after {kept_step}, which are kept")
        });
        session.observer.finished(stage, &format!("{} steps{error}", report.steps), report.seconds);
        for concern in report.concerns {
            session.warn(Warning::Training { stage: stage.into(), concern: concern.to_string() });
        }
        self.before.0 += report.steps as u64;
        self.before.1 += report.seconds;
    }
}

/// Receives the progress of a trainer and passes it on to the observer.
struct Watch<'a> {
    course: &'a mut Course,
    observer: &'a mut dyn Observer,
    stage: &'a str,
    held_out: &'a TestSet<'a>,
    geometry: &'a Geometry,
    /// Whether a concern of this stage was said before its end.
    warned: bool,
}

impl crate::training::TrainingObserver for Watch<'_> {
    fn progress(&mut self, progress: &crate::training::TrainingProgress) -> ControlFlow<()> {
        let error = self.course.curve.last().and_then(|point| point.medians);
        let error = error.map_or(String::new(), |[u, ..]| format!("  median error {u:.2e}"));
        self.observer.progress(&Progress {
            stage: self.stage,
            fraction: progress.share,
            seconds_left: progress.remaining_seconds,
            message: &format!("loss {:.3e}{error}", progress.loss),
        })
    }

    /// Puts an evaluation on the curve; the error that it found.
    fn evaluate(&mut self, surrogate: &Surrogate, point: &HistoryPoint) -> Result<Option<f64>> {
        let (steps, seconds) = self.course.before;
        let (step, train_s) = (steps + point.step as u64, seconds + point.seconds);
        let mut point = CurvePoint {
            step,
            train_s,
            loss: point.loss,
            medians: None,
            energy_excess_pct: None,
            error: None,
            inverted: 0,
        };
        let held_out = self.held_out;
        let found = match surrogate.predict(self.geometry, &held_out.thetas) {
            Ok(prediction) => {
                let fields = 0..held_out.thetas.len();
                let fields: Vec<_> = fields.map(|case| prediction.field(case).to_vec()).collect();
                point.measure(&held_out.cases(&fields)?)
            }
            Err(Error::PredictionNotFinite { .. }) => f64::INFINITY,
            Err(other) => return Err(other),
        };
        // A run that was killed after its last checkpoint repeats some evaluations.
        self.course.curve.retain(|earlier| earlier.step < step);
        self.course.curve.push(point);
        if let Some(file) = &self.course.file {
            write_json(file, &self.course.curve)?;
        }
        Ok(Some(found))
    }

    fn concern(&mut self, concern: &Concern) {
        if !std::mem::replace(&mut self.warned, true) {
            let stage = format!("{}, so far", self.stage);
            self.observer.warning(&Warning::Training { stage, concern: concern.to_string() });
        }
    }
}
