//! Inverse elastostatics: the body at rest whose loaded state is given by an image.

mod lu;
mod newton;
mod state;
mod tangent;

pub use state::{Loading, UnloadOptions, Unloaded};

use crate::elements::{State, System, Unknowns, check_length, check_state, is_moved_rim};
use crate::solve::units;
use crate::{CellValue, Options, Solution, SolveError, Solver};
use lu::Lu;
use sinew_energy::{Body, Fibres};
use state::{Image, Level, Trial, volume_ratios};
use std::time::Instant;
use thiserror::Error;

/// A result whose error is that of unloading.
type Result<T, E = UnloadError> = std::result::Result<T, E>;

/// Residual of the linear systems of derivatives \[relative\].
const ACCURACY: f64 = 1e-13;

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
/// let loaded = Solver::new(&unloaded.rest)?.solve(&theta, &Options::default())?;
/// for (node, x) in image.positions.iter().enumerate() {
///     let rest = unloaded.rest.positions[node];
///     let apart = (0..3).map(|i| rest[i] + loaded.displacement[3 * node + i] - x[i]);
///     assert!(apart.map(f64::abs).fold(0.0, f64::max) < 1e-9); // mm
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// After S. Govindjee, P. A. Mihalic, Int. J. Numer. Meth. Engng 43 (1998), by Newton's method with the exact derivative of the
/// forward balance at (x; X), which is not symmetric. Loading the result therefore returns the image to rounding
/// errors, in every formulation. Supports, springs, loads
/// per volume and area, and parameters are those of the body at rest; a prescribed motion leads from rest to the image.
///
/// A converged search is checked: the body at rest may cross itself, the image may be unstable, and loading may lead to
/// another equilibrium. Each has its [`UnloadError`]. See [`Loading`] for the last check.
#[doc(alias("inverse design", "stress-free configuration", "prestress"))]
pub struct Unload<'p> {
    image: Image<'p>,
    /// The last factor of the derivative in the positions at rest.
    factor: Lu,
}

impl<'p> Unload<'p> {
    /// Prepares for a body that was lowered on the image; its directions are those in the image, and move with the tissue.
    ///
    /// # Errors
    /// A body whose supports leave a part of it free to move; [`UnloadError::Unsuited`].
    pub fn new(image: &'p Body) -> Result<Self> {
        let unsuited = |reason: &str| Err(UnloadError::Unsuited(reason.into()));
        if image.pressure_field.is_some() {
            return unsuited(
                "a body with a field of pressure cannot be unloaded; take averaged volume ratios and a large bulk modulus",
            );
        }
        if image.pressures.iter().any(|pressure| pressure.thesis) {
            return unsuited(
                "the thesis' formula for a pressure only reproduces its numbers; unload under the pressure itself",
            );
        }
        let system = System::new(image)?;
        if let Some(node) = is_moved_rim(image) {
            // A pressure's potential is counted from the plane that its rim slides in.
            return unsuited(&format!(
                "node {node} on the rim of a pressure slides along a plane that its support moves; prescribe no displacement there, or hold \
                 the node along all axes"
            ));
        }
        let factor = Lu::new(&system.factor);
        Ok(Self { image: Image { system, fibres: Fibres::default() }, factor })
    }

    /// Chooses fibres that move with the tissue, the default, or are kept at rest as they are in the image.
    pub fn fibres(mut self, fibres: Fibres) -> Self {
        self.image.fibres = fibres;
        self
    }

    /// The body at rest for θ, starting from the image itself; under a load that rises step by step where that fails.
    ///
    /// # Errors
    /// θ that makes no sense, and each way in which there is no body at rest, see [`UnloadError`].
    pub fn solve(&mut self, theta: &[f64], options: &UnloadOptions) -> Result<Unloaded> {
        let motion = vec![0.0; self.image.system.body.prescribed.len()];
        self.solve_near(&motion, theta, options)
    }

    /// Starts from a motion from the image to the body at rest \[length\]: that of another θ, or one that is extrapolated.
    ///
    /// # Errors
    /// As for [`Unload::solve`], and a motion of the wrong length or that is not finite.
    pub fn solve_near(
        &mut self,
        motion: &[f64],
        theta: &[f64],
        options: &UnloadOptions,
    ) -> Result<Unloaded> {
        let start = Instant::now();
        check_state(self.image.system.body, motion, theta)?;
        let mut iterations = 0;
        let whole = Level::whole(theta);
        let at_once = self.newton(motion.to_vec(), &whole, options, &mut iterations);
        let judged = at_once.and_then(|trial| {
            let loading = self.image.judge(&trial, theta, options).ok()?;
            Some((trial, 1, loading))
        });
        let (trial, load_steps, loading) = match judged {
            Some(found) => found,
            // Of several bodies at rest, that of a rising load is taken and judged.
            None => {
                let (trial, steps) = self.step_by_step(theta, options, &mut iterations)?;
                let loading = self.image.judge(&trial, theta, options)?;
                (trial, steps, loading)
            }
        };
        Ok(Unloaded {
            volume_ratios: volume_ratios(self.image.system.body, &trial.rest),
            motion: trial.motion,
            rest: trial.rest,
            theta: theta.to_vec(),
            fibres: self.image.fibres,
            residual: trial.force,
            force_scale: trial.scale,
            loading,
            iterations,
            load_steps,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Another one of the same image, for another thread; it shares what is prepared, and the last factor.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn fresh(&self) -> Result<Self, SolveError> {
        let Image { system, fibres } = &self.image;
        let image = Image { system: system.like(system.body)?, fibres: *fibres };
        Ok(Self { image, factor: self.factor.clone() })
    }

    /// Derivative ∂X/∂θ of the positions at rest: one vector like [`Unloaded::motion`] per entry of θ.
    ///
    /// By the implicit function theorem, with exact derivatives throughout and one factorisation for all entries.
    ///
    /// # Errors
    /// The body of another image, or [`UnloadError::Singular`].
    pub fn sensitivity(&mut self, unloaded: &Unloaded) -> Result<Vec<Vec<f64>>> {
        self.sensitivity_along(unloaded, &units(unloaded.theta.len()))
    }

    /// Change of the positions at rest along directions in θ, one vector like [`Unloaded::motion`] each.
    ///
    /// # Errors
    /// As for [`Unload::sensitivity`], and directions that are not as long as θ.
    pub fn sensitivity_along(
        &mut self,
        unloaded: &Unloaded,
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        let Unloaded { motion, theta, .. } = unloaded;
        check_state(self.image.system.body, motion, theta)?;
        directions.iter().try_for_each(|along| check_length(theta.len(), along))?;
        let level = Level::whole(theta);
        let trial = Trial::new(&self.image, motion.clone(), &level);
        let trial = trial.ok_or(UnloadError::Singular)?;
        let tangent = self.image.tangent(trial.at(), &level, None).ok_or(UnloadError::Singular)?;
        if !self.factor.factorise(&self.image.system.sparsity, &tangent.entries) {
            return Err(UnloadError::Singular);
        }
        let system = self.image.system.like(&trial.rest)?;
        let column = |direction: &Vec<f64>| {
            let mut right =
                system.rate_by_theta(State::whole(&trial.displacement, theta), direction);
            right.iter_mut().for_each(|r| *r = -*r);
            let change = self.linear(&tangent.entries, &right, ACCURACY);
            let change = change.ok_or(UnloadError::Singular)?;
            Ok(self.image.system.sparsity.scattered(change))
        };
        directions.iter().map(column).collect()
    }

    /// The image taken as the body at rest, for images without load.
    ///
    /// # Errors
    /// A cell of the image that is inverted.
    pub fn image_at_rest(&self) -> Result<Body, SolveError> {
        let motion = vec![0.0; self.image.system.body.prescribed.len()];
        self.image.moved(&motion).ok_or(SolveError::Inadmissible { cell: 0 })
    }

    /// Another loaded state of a body at rest: the equilibrium for other loads and tensions in θ, from a displacement near it \[length\],
    /// counted from rest.
    ///
    /// # Errors
    /// As for [`crate::Solver::solve_from`].
    pub fn loaded(
        &self,
        rest: &Body,
        near: &[f64],
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution, SolveError> {
        Solver::of(self.image.system.like(rest)?).solve_from(near, theta, options)
    }

    /// Directional derivatives δx of a loaded state's positions in θ \[length\], `3 × nodes` for each direction. The body at rest changes along
    /// `rest_directions`, one for each direction in θ, or is held where there are none:
    /// `K δx = −(∂r/∂θ δθ + ∂r/∂X δX + ∂r/∂d ∂d/∂X δX)`, with exact derivatives throughout and one factorisation.
    ///
    /// # Errors
    /// A state or directions that do not fit the body, a stiffness that is singular, and derivatives that overflow.
    pub fn loaded_slopes(
        &self,
        rest: &Body,
        state: &Solution,
        theta_directions: &[Vec<f64>],
        rest_directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        let Solution { displacement, theta, .. } = state;
        theta_directions.iter().try_for_each(|along| check_length(theta.len(), along))?;
        let mut system = self.image.system.like(rest)?;
        check_state(system.body, displacement, theta)?;
        let moved = self.image.forces_by_rest(rest, state, rest_directions)?;
        let shift = system.factorise_at(&Unknowns::of(displacement), theta, 1.0)?;
        let slope = |(index, direction): (usize, &Vec<f64>)| {
            let mut right = system.rate_by_theta(State::whole(displacement, theta), direction);
            if let Some(moved) = moved.get(index) {
                right.iter_mut().zip(moved).for_each(|(r, m)| *r += m);
            }
            Ok(system.slope(right, shift)?)
        };
        theta_directions.iter().enumerate().map(slope).collect()
    }
}

/// Failure of unloading.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum UnloadError {
    /// A body or θ that makes no sense.
    #[error(transparent)]
    Body(#[from] SolveError),
    /// A formulation, load or support that is not unloaded.
    #[error("{0}")]
    Unsuited(String),
    /// No body at rest.
    #[error(
        "no unloaded configuration was found in {iterations} iterations: the image bears {part:.4} of the load, where cells at rest are \
         {least} to {largest} times as large; the load may be too large for this shape, or theta too soft: \
         check the units of pressure and stiffness, reduce the load, stiffen the material, or mesh a wall of one layer of linear \
         tetrahedra with two"
    )]
    NotFound { part: f64, iterations: usize, least: CellValue, largest: CellValue },
    /// The body at rest passes through itself.
    #[error(
        "the unloaded body crosses itself: {pairs} pairs of triangles of its surface, the first at cells {} and {}; the material is too soft \
         for this load, or the load is too large",
        cells[0], cells[1]
    )]
    CrossesItself { pairs: usize, cells: [usize; 2] },
    /// The image is an unstable equilibrium.
    #[error(
        "the image is an unstable equilibrium of the unloaded body: its stiffness has {negative_pivots} negative eigenvalues; no such state can \
         have been seen, so theta or the load are not those of the image"
    )]
    Unstable { negative_pivots: usize },
    /// Loading leads elsewhere.
    #[error(
        "the unloaded body, loaded from rest, comes to another equilibrium: {distance:.3e} away from the image at node {node}; the image is on \
         a branch that a rising load does not lead to"
    )]
    OtherBranch { distance: f64, node: usize },
    /// Loading fails.
    #[error(
        "the image is a stable equilibrium of the unloaded body, but raising the load from rest does not reach it: {0}"
    )]
    NotLoaded(SolveError),
    /// A derivative that does not exist.
    #[error(
        "the positions at rest have no derivative in theta here (a limit point of unloading); move theta a little"
    )]
    Singular,
}

impl Image<'_> {
    /// Changes of the unbalanced forces of a state, whose places are held, along directions of the positions at rest: the state is
    /// an image of its own.
    fn forces_by_rest(
        &self,
        rest: &Body,
        state: &Solution,
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        if directions.is_empty() {
            return Ok(Vec::new());
        }
        directions.iter().try_for_each(|along| check_length(rest.prescribed.len(), along))?;
        let singular = || UnloadError::from(SolveError::Singular);
        let (displacement, level) = (&state.displacement, Level::whole(&state.theta));
        let seen = rest.moved(displacement, self.fibres).ok_or_else(singular)?;
        let seen = Image { system: self.system.like(&seen)?, fibres: self.fibres };
        let tangent = seen.tangent((rest, displacement), &level, None).ok_or_else(singular)?;
        let sparsity = &seen.system.sparsity;
        let product = |along: &Vec<f64>| {
            let along: Vec<f64> = sparsity.gather(along).collect();
            let mut forces = vec![0.0; along.len()];
            tangent.entries.multiply(sparsity, &along, &mut forces);
            forces
        };
        Ok(directions.iter().map(product).collect())
    }
}
