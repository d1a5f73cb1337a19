//! The course of a training over its stages: the curve on the held-out cases, and the weights that are kept.

use super::{Meaning, Plan};
use crate::{
    Backend, Concern, DataSet, Error, Geometry, HistoryPoint, Result, Scales, Surrogate, Trainer,
    TrainingConfig, TrainingObserver, TrainingProgress, TrainingReport, data, network,
};
use sinew_emulate::parts::{Session, expand, scaling, with_anchors};
use sinew_emulate::store::{read_json, write_json};
use sinew_emulate::{CurvePoint, Kept, Progress, TrainingOptions, Warning};
use sinew_fem::Solver;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// The stages of a training and what they leave.
pub(super) struct Course<'c, 'a, 'b> {
    pub session: &'c mut Session<'a, 'b>,
    plan: &'c Plan<'c>,
    pub curve: Vec<CurvePoint>,
    file: Option<PathBuf>,
    /// Steps and seconds of the stages before.
    pub before: (u64, f64),
    /// Weights of the latest stage.
    pub kept: Option<Kept>,
    /// Name of the current stage, and whether a concern of it was said before its end.
    stage: String,
    warned: bool,
}

impl<'c, 'a, 'b> Course<'c, 'a, 'b> {
    pub(super) fn new(session: &'c mut Session<'a, 'b>, plan: &'c Plan<'c>) -> Result<Self> {
        let file = session.folder("curve.json");
        let stored = match &file {
            Some(file) if session.options.resume => read_json(file)?,
            _ => None,
        };
        let (curve, stage) = (stored.unwrap_or_default(), String::new());
        Ok(Self { session, plan, curve, file, before: (0, 0.0), kept: None, stage, warned: false })
    }

    pub(super) fn stage(
        &mut self,
        name: &str,
        data: &DataSet,
        config: &TrainingConfig,
    ) -> Result<Surrogate> {
        self.stage = format!("train {} ({name})", self.plan.recipe);
        self.warned = false;
        let mut trainer = self.trainer(name, data, config)?;
        if self.session.options.budget.is_nothing() {
            return Ok(trainer.into_surrogate());
        }
        let report = trainer.run(self)?;
        if report.interrupted {
            return Err(sinew_emulate::Error::Interrupted { stage: self.stage.clone() }.into());
        }
        self.finish(report);
        Ok(trainer.into_surrogate())
    }

    /// A new trainer, one that starts from what another run has learned, or the one of the checkpoint.
    fn trainer(&self, name: &str, data: &DataSet, config: &TrainingConfig) -> Result<Trainer> {
        let Self { session, plan, .. } = self;
        let checkpoint = session.folder(name);
        let backend: std::result::Result<Backend, String> = session.options.backend.parse();
        let backend = backend.map_err(|reason| sinew_emulate::Error::Network(reason.into()))?;
        let (device, objective) = (backend.device()?, (plan.objective)()?);
        if let Some(folder) = &checkpoint
            && session.options.resume
            && folder.exists()
        {
            return Trainer::resume(folder, data.clone(), objective, &device);
        }
        let surrogate = match &session.options.start {
            Some(run) => {
                Surrogate::load(&run.join("emulator/network"), &device)?.transferred_to(data)?
            }
            None => {
                let sizes = plan.network.on(&data.geometries[0], session.body.parameters.len());
                let scales =
                    Scales::over(&data.geometries, scaling(session.body)?, plan.scale.clone())?;
                Surrogate::new(&sizes, data, scales, config.seed, &device)?
            }
        };
        let mut trainer = Trainer::new(surrogate, data.clone(), objective, config.clone())?;
        trainer.checkpoints = checkpoint;
        Ok(trainer)
    }

    /// Taylor expansion of motions about a displacement in the parameters, through further anchors where there are some, their derivatives among
    /// the features of the geometry. Orders are tried at the first of some parameter sets.
    pub(super) fn expanded(&mut self, geometry: &mut Geometry, anchor: &[f64]) -> Result<Meaning> {
        /// Parameter sets that orders are tried at.
        const TRIED: usize = 32;
        let (session, thetas) = (&mut *self.session, self.plan.thetas);
        let (topology, least_work) = (&geometry.topology, self.plan.least_work);
        let motions = network::at_anchor(session.body, topology, anchor, least_work)?;
        let tried = &thetas[..thetas.len().min(TRIED)];
        let mut solver = Solver::new(session.body)?;
        let (motions, first) = expand(&mut solver, motions, tried)?;
        data::add_features(geometry, &first)?;
        let TrainingOptions { anchors, seed, .. } = *session.options;
        let motions = with_anchors(&mut solver, motions, anchors, seed, session.observer)?;
        Ok(Meaning::Motions(motions))
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

    fn finish(&mut self, report: TrainingReport) {
        let TrainingReport { kept_step, kept_error: error, .. } = report;
        let (step, before) = (self.before.0 + kept_step as u64, self.kept.map_or(0, |k| k.returns));
        self.kept = Some(Kept { step, error, returns: before + report.returns });
        let kept = self.curve.iter().find(|point| point.step == step);
        let error = kept.and_then(|point| point.medians).map_or(String::new(), |[u, ..]| {
            format!(", median error {u:.2e} after {kept_step}, which are kept")
        });
        let done = format!("{} steps{error}", report.steps);
        self.session.observer.finished(&self.stage, &done, report.seconds);
        for concern in report.concerns {
            let (stage, concern) = (self.stage.clone(), concern.to_string());
            self.session.warn(Warning::Training { stage, concern });
        }
        self.before.0 += report.steps as u64;
        self.before.1 += report.seconds;
    }
}

/// Passes the progress of a trainer on to the observer.
impl TrainingObserver for Course<'_, '_, '_> {
    fn progress(&mut self, progress: &TrainingProgress) -> ControlFlow<()> {
        let error = self.curve.last().and_then(|point| point.medians);
        let error = error.map_or(String::new(), |[u, ..]| format!("  median error {u:.2e}"));
        self.session.observer.progress(&Progress {
            stage: &self.stage,
            fraction: progress.share,
            seconds_left: progress.remaining_seconds,
            message: &format!("loss {:.3e}{error}", progress.loss),
        })
    }

    /// Puts an evaluation on the curve; the error that it found.
    fn evaluate(&mut self, surrogate: &Surrogate, point: &HistoryPoint) -> Result<Option<f64>> {
        let (steps, seconds) = self.before;
        let (step, train_s) = (steps + point.step as u64, seconds + point.seconds);
        let mut point = CurvePoint { step, train_s, loss: point.loss, ..CurvePoint::default() };
        let held_out = self.plan.held_out;
        let found = match surrogate.predict(&surrogate.geometries()[0], &held_out.thetas) {
            Ok(fields) => point.measure(&held_out.cases(&fields)?),
            Err(Error::PredictionNotFinite { .. }) => f64::INFINITY,
            Err(other) => return Err(other),
        };
        // A run that was killed after its last checkpoint repeats some evaluations.
        self.curve.retain(|earlier| earlier.step < step);
        self.curve.push(point);
        if let Some(file) = &self.file {
            write_json(file, &self.curve)?;
        }
        Ok(Some(found))
    }

    fn concern(&mut self, concern: &Concern) {
        if !std::mem::replace(&mut self.warned, true) {
            let (stage, concern) = (format!("{}, so far", self.stage), concern.to_string());
            self.session.observer.warning(&Warning::Training { stage, concern });
        }
    }
}
