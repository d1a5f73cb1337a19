//! A trained emulator of one body: prediction, storage.

use crate::coordinates::Motions;
use crate::error::ensure;
use crate::parameters::{check_body, check_length, extrapolation, require_finite};
use crate::predict::Predictor;
use crate::predict::regressed::{self, Regressed};
use crate::predict::taylor;
use crate::store::identity::{self, Identity};
use crate::store::record::Record;
use crate::store::{SEAL, check_seal, content, files, read_json, require_sealed, seal, write_json};
use crate::{Body, Error, Result, TrainingOptions, Warning};
use serde::{Deserialize, Serialize};
use sinew_fem::{FrozenStiffness, Solver, SolverPool};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

/// An emulator of one body, from [`Train::train`](crate::Train::train) or [`Emulator::load`].
#[doc(alias("surrogate", "metamodel", "ROM"))]
pub struct Emulator<'b> {
    pub(crate) body: &'b Body,
    /// Predictor of the displacements; [`Predictor::regression`] is there where a regression predicts alone.
    pub predictor: Box<dyn Predictor + 'b>,
    /// Provenance, and the measures of how far it is to be trusted.
    pub record: Record,
    pub(crate) solvers: SolverPool<'b>,
    /// Stiffness at the centre of the ranges, factorised when it is first needed.
    pub(crate) held: OnceLock<FrozenStiffness<'b>>,
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

const VERSION: u32 = 5;
const DESCRIPTION: &str = "emulator.json";

#[derive(Serialize, Deserialize)]
struct Description {
    version: u32,
    model: String,
    body: Identity,
    record: Record,
}

/// Reads the files of a kind of predictor.
pub type Load = dyn Fn(&Path, &Body) -> Result<Box<dyn Predictor>>;

impl<'b> Emulator<'b> {
    /// Taylor expansion of second order about one solve at the centre of the parameters' ranges, as
    /// [`recipe::Taylor`](crate::recipe::Taylor) but without held-out cases: the quickest way to many answers for an unseen
    /// body. The seed draws the clusters of nodes and the parameter sets at which the damping of both orders is chosen.
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
    /// let (emulator, theta) = (Emulator::taylor(&beam, 1)?, vec![60.0, 90.0]);
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
    pub fn taylor(body: &'b Body, seed: u64) -> Result<Self> {
        Self::taylor_with_anchors(body, 1, seed)
    }

    /// [`Emulator::taylor`] through `anchors` solved states with their derivatives. The first is at the centre; each further one is where the
    /// checked error is largest.
    ///
    /// ```
    /// # use sinew_emulate::Emulator;
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// # let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    /// #     .parameter(Parameter::log("mu", "kPa", 20.0..=100.0))
    /// #     .parameter(Parameter::log("lambda", "kPa", 20.0..=100.0))
    /// #     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    /// #     .support(Support::clamped("x_min"))
    /// #     .lower()?;
    /// let theta = vec![25.0, 90.0];
    /// let error = |emulator: Emulator<'_>| -> Result<f64, Box<dyn std::error::Error>> {
    ///     let predicted = emulator.predict(&[theta.clone()])?;
    ///     Ok(emulator.estimate(&predicted, 0)?.distance.ok_or("no equilibrium is near")?.mean) // mm
    /// };
    /// let (one, four) = (Emulator::taylor(&beam, 1)?, Emulator::taylor_with_anchors(&beam, 4, 1)?);
    /// assert_eq!(four.record.simulations, 4);
    /// assert!(error(four)? < 0.2 * error(one)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A body that cannot be solved at the centre or at another anchor, no anchors or more than 50.
    pub fn taylor_with_anchors(body: &'b Body, anchors: usize, seed: u64) -> Result<Self> {
        check_body(body)?;
        TrainingOptions { anchors, ..TrainingOptions::default() }.check()?;
        let start = Instant::now();
        Ok(Self::of_taylor(body, taylor::solved(body, anchors, seed, &mut ())?, anchors, start))
    }

    /// Taylor expansion about a known solution at the centre of the parameters' ranges.
    pub(crate) fn taylor_about(mut solver: Solver<'b>, solved: &[f64], seed: u64) -> Result<Self> {
        let (start, body) = (Instant::now(), solver.body());
        let taylor = taylor::about_solved(&mut solver, solved, seed)?;
        let emulator = Self::of_taylor(body, taylor, 1, start);
        emulator.solvers.add(solver);
        Ok(emulator)
    }

    fn of_taylor(body: &'b Body, taylor: Motions, anchors: usize, start: Instant) -> Self {
        let mut record = Record::new(taylor::KEY);
        record.simulations = anchors;
        record.about = taylor::about(anchors);
        record.prepare_s = start.elapsed().as_secs_f64();
        Self::new(body, Box::new(Regressed { taylor: Some(taylor), regression: None }), record)
    }

    /// Emulator of a predictor of `body`.
    pub fn new(body: &'b Body, predictor: Box<dyn Predictor + 'b>, record: Record) -> Self {
        Self { body, predictor, record, solvers: SolverPool::new(body), held: OnceLock::new() }
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
        let body = self.body;
        thetas.iter().try_for_each(|theta| check_length(body, theta))?;
        let displacement = self.predictor.predict(body, thetas)?;
        require_finite(body, thetas, &displacement)?;
        let warnings = thetas.iter().map(|theta| extrapolation(body, theta)).collect();
        Ok(Prediction { thetas: thetas.to_vec(), displacement, warnings })
    }

    /// Writes a folder that [`Emulator::load`] reads, with checksums of its files.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let kind = self.predictor.kind();
        self.predictor.save(&folder.join(kind))?;
        let (body, record, model) = (identity::of(self.body), self.record.clone(), kind.into());
        let description = Description { version: VERSION, model, body, record };
        write_json(&folder.join(DESCRIPTION), &description)?;
        seal(folder, files(folder, DESCRIPTION, kind)?)
    }

    /// Reads an emulator of `body` whose predictor is a Taylor expansion or a regression.
    ///
    /// # Errors
    /// A folder without an emulator, files that are damaged, an emulator of another body or with another kind of predictor.
    pub fn load(folder: &Path, body: &'b Body) -> Result<Self> {
        Self::load_with(folder, body, &[])
    }

    /// Loads an emulator as [`Emulator::load`] does, with predictors of other kinds.
    ///
    /// # Errors
    /// As [`Emulator::load`].
    pub fn load_with(folder: &Path, body: &'b Body, kinds: &[(&str, &Load)]) -> Result<Self> {
        let file = folder.join(DESCRIPTION);
        let exists = file.exists() || folder.join(SEAL).exists();
        ensure(exists, Error::NoEmulator { folder: folder.into() })?;
        let sealed = check_seal(folder)?;
        let Description { version, model, body: stored, record } =
            read_json(&file)?.ok_or_else(|| Error::NoEmulator { folder: folder.into() })?;
        let other = content(&file, &format!("version {version} for {VERSION}"));
        ensure(version == VERSION, other)?;
        if let Some((what, stored, found)) = identity::difference(&stored, &identity::of(body)) {
            return Err(Error::Refused(format!(
                "the emulator in {} was trained for another body: {what} was {stored} and is {found}; load it with the mesh, law, loads and supports that it was trained for",
                folder.display()
            )));
        }
        check_body(body)?;
        require_sealed(&sealed, folder, &files(folder, DESCRIPTION, &model)?)?;
        let part = folder.join(&model);
        let predictor = match kinds.iter().find(|(kind, _)| *kind == model) {
            Some((_, load)) => load(&part, body),
            None if model == regressed::KIND => Ok(Box::new(Regressed::load(&part, body)?) as _),
            None => Err(Error::Refused(format!(
                "{} holds an emulator of the kind `{model}`, which this build does not load; build with the feature `networks`, or load it with the crate that trained it",
                folder.display()
            ))),
        };
        Ok(Self::new(body, predictor?, record))
    }
}
