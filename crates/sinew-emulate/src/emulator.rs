//! A trained emulator of one body: prediction, storage.

use crate::calibration::Calibration;
use crate::checksums::{self, SEAL};
use crate::evaluate::Errors;
use crate::identity::{self, Identity};
use crate::network::{CurvePoint, Kept, TrainedNetwork};
use crate::parameters::{check_length, extrapolation, not_finite, require_finite, require_some};
use crate::recipe::{Choice, Recipe};
use crate::series::{Regressed, Series};
use crate::store::{content, read_json, write_json};
use crate::{Body, Error, Result, Warning};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew_fem::{HeldStiffness, Solver};
use sinew_gnn::Backend;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// What predicts.
#[derive(Debug)]
pub(crate) enum Model {
    Network(Box<TrainedNetwork>),
    Regressed(Box<Regressed>),
}

impl From<Regressed> for Model {
    fn from(regressed: Regressed) -> Self {
        Self::Regressed(Box::new(regressed))
    }
}

impl From<TrainedNetwork> for Model {
    fn from(network: TrainedNetwork) -> Self {
        Self::Network(Box::new(network))
    }
}

/// An emulator of one body, from [`Recipe::train`] or [`Emulator::load`].
pub struct Emulator<'b> {
    pub(crate) body: &'b Body,
    pub(crate) model: Model,
    /// How it was made, and how far it is to be trusted.
    pub record: Record,
    /// Solvers that are not at work, prepared when they are first needed.
    pub(crate) solvers: Mutex<Vec<Solver<'b>>>,
    /// Stiffness at the centre of the ranges, likewise.
    pub(crate) held: Mutex<Option<Arc<HeldStiffness<'b>>>>,
}

/// How an emulator was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// By which recipe.
    pub recipe: Recipe,
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Wall time of them \[s\].
    pub simulate_s: f64,
    /// Wall time of graph and coordinates \[s\].
    pub prepare_s: f64,
    /// Wall time of training \[s\].
    pub train_s: f64,
    /// Optimiser steps of all stages.
    pub steps: u64,
    /// Errors on the held-out cases on the way; empty for a regression.
    pub history: Vec<CurvePoint>,
    /// Weights of the networks that were kept, where some were trained.
    #[serde(default)]
    pub kept: Option<Kept>,
    /// What was tried and why this was taken, where there was a choice.
    pub choice: Option<Choice>,
    /// How well the error estimate does.
    pub calibration: Calibration,
    /// Errors on the held-out cases.
    pub held_out: Option<Errors>,
    /// Reasons not to trust it; none after a training that went well.
    pub warnings: Vec<Warning>,
}

impl Record {
    pub(crate) fn new(recipe: Recipe) -> Self {
        Self {
            recipe,
            simulations: 0,
            simulate_s: 0.0,
            prepare_s: 0.0,
            train_s: 0.0,
            steps: 0,
            history: Vec::new(),
            kept: None,
            choice: None,
            calibration: Calibration::default(),
            held_out: None,
            warnings: Vec::new(),
        }
    }
}

/// Displacements for some parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The parameters, case by case.
    pub thetas: Vec<Vec<f64>>,
    /// Displacements, case by case, node by node \[length\].
    pub displacement: Vec<f64>,
    /// Reasons not to trust a case: parameters outside their trained ranges, refined fields that are out of balance.
    pub warnings: Vec<Vec<Warning>>,
}

impl Prediction {
    /// Displacement of one case, node by node \[length\].
    ///
    /// # Panics
    /// If there is no such case.
    pub fn field(&self, case: usize) -> &[f64] {
        let length = self.displacement.len() / self.thetas.len().max(1);
        &self.displacement[case * length..(case + 1) * length]
    }

    /// All displacements.
    pub fn fields(&self) -> Vec<Vec<f64>> {
        (0..self.thetas.len()).map(|case| self.field(case).to_vec()).collect()
    }
}

const VERSION: u32 = 2;
const DESCRIPTION: &str = "emulator.json";

#[derive(Serialize, Deserialize)]
struct Description {
    version: u32,
    model: Kind,
    body: Identity,
    record: Record,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Network,
    Regression,
}

impl Kind {
    /// Folder of the files that predict.
    fn part(&self) -> &'static str {
        match self {
            Self::Network => "network",
            Self::Regression => "regression",
        }
    }
}

impl<'b> Emulator<'b> {
    /// What [`Recipe::Series`] makes of a body, without held-out cases that measure it: one solve at the centre of the parameters' ranges,
    /// followed to second order. The quickest way to many answers for a body that nothing has seen. The seed draws clusters of nodes, and the
    /// parameter sets that parts of both orders are tried at.
    ///
    /// ```
    /// # use sinew_emulate::Emulator;
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let (emulator, theta) = (Emulator::series(&beam, 1)?, vec![60.0, 90.0]);
    /// let predicted = emulator.predict(&[theta.clone()])?.displacement;
    /// let corrected = emulator.correct(&theta, 2)?.displacement;
    /// let size = |u: Vec<f64>| u.iter().map(|u| u * u).sum::<f64>().sqrt();
    /// let off = size(predicted.iter().zip(&corrected).map(|(a, b)| a - b).collect());
    /// assert!(off < 0.01 * size(corrected));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A body that cannot be solved at the centre.
    pub fn series(body: &'b Body, seed: u64) -> Result<Self> {
        require_some(body)?;
        let start = Instant::now();
        Ok(Self::of_series(body, Series::of(body, seed)?, start))
    }

    /// About the solution at the centre of the parameters' ranges, where a solver has it already.
    pub(crate) fn series_about(
        mut solver: Solver<'b>,
        body: &'b Body,
        solved: &[f64],
        seed: u64,
    ) -> Result<Self> {
        let start = Instant::now();
        let series = Series::about_solved(&mut solver, solved, seed)?;
        Ok(Self { solvers: Mutex::new(vec![solver]), ..Self::of_series(body, series, start) })
    }

    fn of_series(body: &'b Body, series: Series, start: Instant) -> Self {
        let mut record = Record::new(Recipe::Series);
        record.prepare_s = start.elapsed().as_secs_f64();
        record.simulations = 1;
        Self::new(body, Regressed { series: Some(series), regression: None }.into(), record)
    }

    pub(crate) fn new(body: &'b Body, model: Model, record: Record) -> Self {
        Self { body, model, record, solvers: Mutex::default(), held: Mutex::new(None) }
    }

    pub(crate) fn into_parts(self) -> (Model, Record) {
        (self.model, self.record)
    }

    /// The body.
    pub fn body(&self) -> &'b Body {
        self.body
    }

    /// Displacements for each of `thetas`. Those outside the trained ranges are marked.
    ///
    /// # Errors
    /// θ of the wrong length, not finite, not positive where samples are uniform in the logarithm, or so far outside its ranges
    /// that a displacement is not finite.
    pub fn predict(&self, thetas: &[Vec<f64>]) -> Result<Prediction> {
        self.predict_by(thetas, |network| Ok(network.fixed.predict(thetas)?))
    }

    /// As [`Emulator::predict`], but as if a network had never seen the geometry, which takes message passing, and is less
    /// accurate than with the embeddings that training gave to its nodes. The same as `predict` for a regression.
    ///
    /// # Errors
    /// As [`Emulator::predict`].
    pub(crate) fn predict_in_full(&self, thetas: &[Vec<f64>]) -> Result<Prediction> {
        self.predict_by(thetas, |network| {
            Ok(network.surrogate.predict_unseen(&network.geometry, thetas)?)
        })
    }

    fn predict_by(
        &self,
        thetas: &[Vec<f64>],
        by: impl Fn(&TrainedNetwork) -> Result<sinew_gnn::Prediction>,
    ) -> Result<Prediction> {
        thetas.iter().try_for_each(|theta| check_length(self.body, theta))?;
        let displacement = match &self.model {
            Model::Network(network) => match by(network) {
                Err(Error::Network(sinew_gnn::Error::PredictionNotFinite { sample })) => {
                    return Err(not_finite(self.body, &thetas[sample]));
                }
                predicted => predicted?.displacement,
            },
            Model::Regressed(regressed) => {
                let fields: Result<Vec<_>> =
                    thetas.par_iter().map(|theta| regressed.predict(self.body, theta)).collect();
                fields?.concat()
            }
        };
        require_finite(self.body, thetas, &displacement)?;
        let warnings = thetas.iter().map(|theta| extrapolation(self.body, theta)).collect();
        Ok(Prediction { thetas: thetas.to_vec(), displacement, warnings })
    }

    /// Writes a folder that [`Emulator::load`] reads, with checksums of its files.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let model = match &self.model {
            Model::Network(_) => Kind::Network,
            Model::Regressed(_) => Kind::Regression,
        };
        let part = folder.join(model.part());
        match &self.model {
            Model::Network(network) => network.surrogate.save(&part)?,
            Model::Regressed(regressed) => regressed.save(&part)?,
        }
        let (body, record, part) = (identity::of(self.body), self.record.clone(), model.part());
        let description = Description { version: VERSION, model, body, record };
        write_json(&folder.join(DESCRIPTION), &description)?;
        checksums::seal(folder, DESCRIPTION, part)
    }

    /// Reads an emulator of `body`.
    ///
    /// # Errors
    /// A folder without an emulator, files that are damaged, an emulator of another body.
    pub fn load(folder: &Path, body: &'b Body) -> Result<Self> {
        let file = folder.join(DESCRIPTION);
        if !file.exists() && !folder.join(SEAL).exists() {
            return Err(Error::NoEmulator { folder: folder.into() });
        }
        let sealed = checksums::check(folder)?;
        let Description { version, model, body: stored, record } =
            read_json(&file)?.ok_or_else(|| Error::NoEmulator { folder: folder.into() })?;
        if version != VERSION {
            return Err(content(&file, &format!("version {version} for {VERSION}")));
        }
        if let Some((what, stored, found)) = identity::difference(&stored, &identity::of(body)) {
            return Err(Error::OtherBody { folder: folder.into(), what, stored, found });
        }
        checksums::require(&sealed, folder, DESCRIPTION, model.part())?;
        let part = folder.join(model.part());
        let model = match model {
            Kind::Network => TrainedNetwork::load(&part, Backend::default())?.into(),
            Kind::Regression => Regressed::load(&part, body)?.into(),
        };
        Ok(Self::new(body, model, record))
    }
}
