//! Solution and factorised stiffness of one body, for others.

use crate::predict::Predictor;
use crate::store::record::Record;
use crate::{Body, Emulator, Error, Result};
use rayon::prelude::*;
use sinew_fem::{Descent, FrozenTangent, Options, SolveError, Solver};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// Solution of one body and its factorised stiffness, for unseen bodies that share its mesh's connectivity and its supports, whatever their shapes,
/// materials and scars.
///
/// From that solution, quasi-Newton steps with the frozen stiffness ([`FrozenTangent`]) lower the potential energy of another body. Nothing is trained
/// and nothing prepared for it. [`FrozenStiffness::on`] makes an [`Emulator`] of the unseen body, which answers to an accuracy as any other;
/// [`FrozenStiffness::descend`] gives the steps alone. On left ventricles of random shape and parameters, 16 steps reach a
/// median error of 1.2 % in a tenth of the time of a solve, and 32 steps 0.03 %. Beams in large deflection need too many
/// steps to pay. For nearly incompressible bodies of another shape the steps do not converge
/// (`cargo xtask reproduce-populations --no-networks`).
///
/// ```
/// use sinew_emulate::FrozenStiffness;
/// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_mesh::box_tetrahedra;
///
/// let [block, other] = [0.0, 0.2].map(|waist: f64| {
///     let mut mesh = box_tetrahedra([20.0, 10.0, 10.0], [6, 4, 4]);
///     mesh.map_points(|[x, y, z]| [x, y * (1.0 - waist * (x / 20.0)), z]);
///     let stiffness = |name: &str| Parameter::log(name, "kPa", 2.0..=20.0);
///     let scene = Scene::new(mesh, NeoHookean)
///         .parameter(stiffness("mu"))
///         .parameter(stiffness("lambda"))
///         .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
///         .support(Support::clamped("x_min"));
///     scene.lower().expect("a block")
/// });
/// let known = FrozenStiffness::new(&block)?;
/// let answer = known.on(&other)?.answer(&[4.0, 12.0], 1e-3)?;
/// assert!(answer.is_within(1e-3) && answer.steps == 1); // Newton steps of its own
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct FrozenStiffness<'b> {
    held: Arc<FrozenTangent<'b>>,
}

/// Short name of predictions by it.
const KEY: &str = "frozen-stiffness";

/// Quasi-Newton steps of a prediction: from there one or two Newton steps contract.
const STEPS: usize = 16;

/// Cost of a quasi-Newton step [Newton steps]. A Newton step has a factorisation (measured on a left ventricle of 1570
/// nodes: 1.9 ms against 13 ms).
const STEP: f64 = 0.15;

/// Factor by which a start that inverts cells is shortened, and number of times at most.
const SHORTER: f64 = 0.7;
const MOST_TRIALS: usize = 40;

impl<'b> FrozenStiffness<'b> {
    /// Solves a body, best one in the middle of the population, at the centre of its parameters' ranges.
    ///
    /// # Errors
    /// No equilibrium at the centre.
    pub fn new(body: &'b Body) -> Result<Self> {
        let (mut solver, centre) = (Solver::new(body)?, body.centre());
        let known = solver.solve(&centre, &Options::default())?.displacement;
        Ok(Self { held: Arc::new(solver.frozen_tangent(&known, &centre)?) })
    }

    /// Emulator of an unseen body.
    ///
    /// # Errors
    /// A body of other cells or supports.
    pub fn on(&self, body: &'b Body) -> Result<Emulator<'b>> {
        self.held.suits(body)?;
        let mut record = Record::new(KEY);
        record.about = format!("from solution and stiffness of {}", self.held.body().name);
        Ok(Emulator::new(body, Box::new(self.clone()), record))
    }

    /// The descent of a body at each of `thetas`, of at most `steps` steps: displacements, and the residual before and after.
    ///
    /// The relative residual ([`Descent::unbalanced`]) indicates the distance from equilibrium.
    ///
    /// # Errors
    /// A body of other cells or supports, θ that makes no sense, [`SolveError::Inadmissible`] where prescribed motions invert cells at once.
    pub fn descend(&self, body: &Body, thetas: &[Vec<f64>], steps: usize) -> Result<Vec<Descent>> {
        thetas.par_iter().map(|theta| self.descent(body, theta, steps)).collect()
    }

    fn descent(&self, body: &Body, theta: &[f64], steps: usize) -> Result<Descent> {
        let mut start = self.held.displacement.clone();
        for _ in 0..MOST_TRIALS {
            match self.held.descend_on(body, &start, theta, steps) {
                Err(SolveError::Inadmissible { .. }) => {
                    start.iter_mut().for_each(|u| *u *= SHORTER);
                }
                found => return Ok(found?),
            }
        }
        Ok(self.held.descend_on(body, &vec![0.0; start.len()], theta, steps)?)
    }
}

impl fmt::Debug for FrozenStiffness<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FrozenStiffness").field("body", &self.held.body().name).finish()
    }
}

impl Predictor for FrozenStiffness<'_> {
    fn kind(&self) -> &'static str {
        KEY
    }

    fn predict(&self, body: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>> {
        let found = self.descend(body, thetas, STEPS)?;
        Ok(found.into_iter().flat_map(|descent| descent.displacement).collect())
    }

    fn newton_steps(&self) -> f64 {
        STEPS as f64 * STEP
    }

    fn save(&self, _: &Path) -> Result<()> {
        Err(Error::NotStored { kind: KEY })
    }
}
