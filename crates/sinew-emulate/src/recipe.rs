//! Recipes: how a body becomes an emulator.

pub(crate) mod options;
mod plain;
pub(crate) mod progress;
pub(crate) mod session;
#[cfg(feature = "terminal")]
pub(crate) mod terminal;

pub use plain::{Regression, Taylor};

use crate::error::require_usable;
use crate::estimate::evaluate::TestSet;
use crate::predict::Predictor;
use crate::recipe::session::{Session, is_finished};
use crate::store::record::Record;
use crate::{Body, Calibration, Emulator, Observer, Result, TrainingOptions};
use serde_json::Value;
use std::fmt::Debug;

/// A recipe: what it is called, its settings, and how it makes a predictor of a body.
pub trait Train: Debug {
    /// Short name for files and tables.
    fn key(&self) -> &'static str;

    /// Settings, stored with a run and compared when one is resumed.
    fn settings(&self) -> Value;

    /// Description of its predictor, in one line.
    fn about(&self, record: &Record) -> String;

    /// Refuses settings that make no sense.
    ///
    /// # Errors
    /// Such a setting, with advice.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Whether it stands about solved states, of which [`TrainingOptions::anchors`] says how many.
    fn has_anchors(&self) -> bool {
        false
    }

    /// Sizes of its network, which a run that it starts from must share; `None` where it trains none of its own.
    fn network(&self) -> Option<Value> {
        None
    }

    /// Makes the predictor; what it costs is noted in the session and in the record.
    ///
    /// # Errors
    /// Simulations of which most fail, a training that diverges, files that cannot be written, an observer that breaks.
    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>>;

    /// Trains an emulator of a body and checks its error estimate.
    ///
    /// Runs the simulations of the recipe, trains, and checks the error estimate on held-out simulations. A folder in the
    /// options stores all results as they are made: a killed run resumes from it, and the emulator is stored in its subfolder
    /// `emulator`. A network keeps the weights with the lowest error on the held-out simulations ([`Record::kept`]). Reasons
    /// not to trust the result are in [`Record::warnings`].
    ///
    /// # Errors
    /// Invalid settings, a body without free parameters, a folder with a run that is neither to be resumed nor to be replaced,
    /// simulations of which most fail, a training that diverges, files that cannot be written, an observer that breaks.
    fn train<'b>(
        &self,
        body: &'b Body,
        options: &TrainingOptions,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'b>>
    where
        Self: Sized,
    {
        train_with(self, body, options, observer, &[])
    }
}

/// Trains as [`Train::train`] does, where a finished run may have left predictors of other `kinds` ([`Emulator::load_with`]).
///
/// # Errors
/// As [`Train::train`].
pub fn train_with<'b>(
    recipe: &dyn Train,
    body: &'b Body,
    options: &TrainingOptions,
    observer: &mut dyn Observer,
    kinds: &[(&str, &crate::emulator::Load)],
) -> Result<Emulator<'b>> {
    recipe.check()?;
    let (key, anchors) = (recipe.key(), options.anchors);
    require_usable(anchors < 2 || recipe.has_anchors(), || {
        format!(
            "the recipe `{key}` has no anchors, and {anchors} were asked for; choose taylor or pi, or leave them out"
        )
    })?;
    let described = (key, recipe.settings(), recipe.network());
    let mut session = Session::begin(body, described, options, observer)?;
    if let Some(folder) = &options.folder
        && is_finished(folder)
    {
        return Emulator::load_with(&folder.join("emulator"), body, kinds);
    }
    let held_out = session.held_out()?;
    let mut record = Record::new(key);
    // Held-out cases are no part of what the recipe costs.
    session.simulate_s = 0.0;
    let predictor = recipe.predictor(&mut session, &held_out, &mut record)?;
    record.simulations = session.simulations;
    record.simulate_s = session.simulate_s;
    record.about = recipe.about(&record);
    let mut emulator = Emulator::new(body, predictor, record);
    let (calibration, errors) = Calibration::on(&emulator, &held_out)?;
    calibration.warnings().into_iter().for_each(|warning| session.warn(warning));
    emulator.record.warnings = session.warnings;
    emulator.record.calibration = calibration;
    emulator.record.held_out = Some(errors);
    if let Some(folder) = &options.folder {
        emulator.save(&folder.join("emulator"))?;
    }
    Ok(emulator)
}
