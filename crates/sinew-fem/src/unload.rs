//! The body at rest of which an image shows the loaded state: inverse elastostatics.

mod entries;
mod error;
mod multifrontal;
mod newton;
mod point;
mod sensitivity;
mod state;
mod tangent;
mod unloaded;
mod verdict;

pub use error::UnloadError;
pub use unloaded::{Loading, Unloaded};

use crate::sparsity::patch_nodes_of;
use crate::supports::is_moved_rim;
use crate::system::System;
use crate::{Options, SolveError};
use entries::Places;
use multifrontal::Multifrontal;
use sinew_energy::{Body, Fibres, ForceBalance};
use std::time::Instant;

/// Finds the body at rest whose loaded state is an image.
///
/// The scene is lowered *on the image*: its mesh is that of the loaded state x. The unknowns are the positions X at rest. With
/// f = ∂X/∂x the stress of the law at F = f⁻¹ is in balance with the loads, whose surfaces are known:
///
/// ```
/// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{Options, Solver, Unload, UnloadOptions};
/// use sinew_mesh::box_tetrahedra;
///
/// // A beam that was scanned under its own weight and a pressure from below.
/// let scene = Scene::new(box_tetrahedra([60.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 20.0..=80.0))
///     .parameter(Parameter::log("lambda", "kPa", 20.0..=80.0))
///     .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
///     .support(Support::clamped("x_min"));
/// let image = scene.lower()?;
/// let theta = [30.0, 60.0];
/// let unloaded = Unload::new(&image)?.solve(&theta, &UnloadOptions::default())?;
///
/// // Loading the body at rest gives the image back; this was checked already.
/// let loaded = Solver::new(&unloaded.rest.body)?.solve(&theta, &Options::default())?;
/// for (node, x) in image.positions.iter().enumerate() {
///     let rest = unloaded.rest.body.positions[node];
///     let apart = (0..3).map(|i| rest[i] + loaded.displacement[3 * node + i] - x[i]);
///     assert!(apart.map(f64::abs).fold(0.0, f64::max) < 1e-9); // mm
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// After S. Govindjee, P. A. Mihalic, Int. J. Numer. Meth. Engng 43 (1998), by Newton's method with the exact derivative of the
/// forward balance at (x; X), which is not symmetric. So the round trip closes to rounding errors for every formulation. Supports, springs, loads
/// per volume and area, and parameters are those of the body at rest; a prescribed motion leads from rest to the image.
///
/// A search that converges is no answer yet: the body at rest may cross itself, the image may be unstable, and loading may lead to another
/// equilibrium. Each has its [`UnloadError`].
pub struct Unload<'p> {
    image: Image<'p>,
    factor: Multifrontal,
}

/// How a body at rest is searched and checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnloadOptions {
    /// Most Newton iterations, all load steps together.
    pub iterations: usize,
    /// Most of them at one load.
    pub iterations_per_load: usize,
    /// Smallest load step before the search gives up [part of the load].
    pub least_load_step: f64,
    /// Whether the body at rest is loaded from rest to see that it comes to the image, beside the check that the image is one of its
    /// stable equilibria. `None` saves that solve, where the body at rest is a neighbour of one that was loaded.
    pub load: Option<Options>,
}

impl Default for UnloadOptions {
    fn default() -> Self {
        Self {
            iterations: 300,
            iterations_per_load: 25,
            least_load_step: 1e-3,
            load: Some(Options::default()),
        }
    }
}

/// The image with what is prepared once.
pub(self) struct Image<'p> {
    system: System<'p>,
    places: Places,
    /// Nodes of each patch, ascending.
    patch_nodes: Vec<Vec<usize>>,
    fibres: Fibres,
}

impl<'p> Unload<'p> {
    /// Prepares for a body that was lowered on the image; its directions are those in the image, and move with the tissue.
    ///
    /// # Errors
    /// A body that is malformed, whose supports leave a part of it free to move, or whose loads were changed after it was lowered.
    pub fn new(image: &'p Body) -> Result<Self, UnloadError> {
        Self::prepare(System::new(image)?)
    }

    /// The same with pressures that act on surfaces with a loose rim.
    ///
    /// # Errors
    /// As for [`Unload::new`], and [`UnloadError::PressureField`].
    pub fn balance(image: &'p ForceBalance) -> Result<Self, UnloadError> {
        if image.pressure_field.is_some() {
            return Err(UnloadError::PressureField);
        }
        Self::prepare(System::balance(image)?)
    }

    fn prepare(system: System<'p>) -> Result<Self, UnloadError> {
        let body = system.body;
        if !body.is_loaded_as_lowered() {
            let (what, problem) = ("nodal forces or springs", "are not those of its loads");
            return Err(SolveError::Malformed { what, problem }.into());
        }
        if let Some(node) = is_moved_rim(body) {
            return Err(UnloadError::MovedRim { node });
        }
        let places = Places::new(&system.sparsity, body.prescribed.len());
        let patch_nodes = body.patches.iter().map(|points| patch_nodes_of(body, points)).collect();
        let factor = Multifrontal::new(&system.sparsity);
        let image = Image { system, places, patch_nodes, fibres: Fibres::default() };
        Ok(Self { image, factor })
    }

    /// With fibres that move with the tissue, the default, or are kept at rest as they are in the image.
    pub fn fibres(mut self, fibres: Fibres) -> Self {
        self.image.fibres = fibres;
        self
    }

    /// The body at rest for θ, starting from the image itself; under a load that rises step by step where that fails.
    ///
    /// # Errors
    /// θ that makes no sense, and each way in which there is no body at rest, see [`UnloadError`].
    pub fn solve(
        &mut self,
        theta: &[f64],
        options: &UnloadOptions,
    ) -> Result<Unloaded, UnloadError> {
        let motion = vec![0.0; self.image.system.body.prescribed.len()];
        self.solve_from_motion(motion, theta, options)
    }

    /// The same, starting from the body at rest for another θ that should be near.
    ///
    /// # Errors
    /// As for [`Unload::solve`], and a body of another image.
    pub fn solve_from(
        &mut self,
        near: &Unloaded,
        theta: &[f64],
        options: &UnloadOptions,
    ) -> Result<Unloaded, UnloadError> {
        self.solve_from_motion(near.motion.clone(), theta, options)
    }

    fn solve_from_motion(
        &mut self,
        motion: Vec<f64>,
        theta: &[f64],
        options: &UnloadOptions,
    ) -> Result<Unloaded, UnloadError> {
        let start = Instant::now();
        self.image.system.check_theta(theta).map_err(SolveError::from)?;
        crate::check::check_displacement(self.image.system.body, &motion)?;
        let mut iterations = 0;
        if let Some(trial) = self.at_once(motion, theta, options, &mut iterations)
            && let Ok(loading) = self.image.judge(&trial, theta, options)
        {
            let found = (trial, iterations, 1);
            return Ok(Unloaded::new(&self.image, found, theta, loading, start));
        }
        // Of several bodies at rest, the one that a rising load leads to; the verdict is the one on it.
        let (trial, load_steps) = self.step_by_step(theta, options, &mut iterations)?;
        let loading = self.image.judge(&trial, theta, options)?;
        let found = (trial, iterations, load_steps);
        Ok(Unloaded::new(&self.image, found, theta, loading, start))
    }
}
