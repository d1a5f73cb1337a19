//! One solution and one stiffness for a population of bodies.

use crate::{Body, Result};
use rayon::prelude::*;
use sinew_fem::{Descent, HeldStiffness, Options, SolveError, Solver};

/// An emulator of bodies that share their mesh's connectivity and their supports, whatever their shapes, materials and scars, which is not
/// trained and prepares nothing for a new body: from the solution of one body, quasi-Newton steps with its stiffness
/// ([`HeldStiffness`]) lower the potential energy of another.
///
/// What is left of the forces ([`Descent::unbalanced`]) tells how near an answer is. On left ventricles of random shape and parameters 16 leave 1.2 % in the median in a tenth of
/// the time of a solve, 32 leave 0.03 %; beams that bend far need more than they are worth, and
/// nearly incompressible bodies of another shape are not reached at all (`cargo xtask reproduce-populations --no-networks`).
///
/// ```
/// use sinew_emulate::OneStiffness;
/// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{Options, Solver};
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
/// let emulator = OneStiffness::new(&block)?;
/// let theta = vec![4.0, 12.0];
/// let found = emulator.predict(&other, std::slice::from_ref(&theta), 20)?.remove(0);
/// assert!(found.unbalanced() < 1e-2);
/// let exact = Solver::new(&other)?.solve(&theta, &Options::default())?.displacement;
/// let norm = |u: &mut dyn Iterator<Item = f64>| u.map(|u| u * u).sum::<f64>().sqrt();
/// let off = norm(&mut found.displacement.iter().zip(&exact).map(|(a, b)| a - b)) / norm(&mut exact.iter().copied());
/// assert!(off < 0.01, "{off}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct OneStiffness<'b> {
    held: HeldStiffness<'b>,
}

/// A start that turns cells over is made shorter by this, and so often.
const SHORTER: f64 = 0.7;
const MOST_TRIALS: usize = 40;

impl<'b> OneStiffness<'b> {
    /// Solves a body, best one in the middle of the population, at the centre of its parameters' ranges.
    ///
    /// # Errors
    /// No equilibrium at the centre.
    pub fn new(body: &'b Body) -> Result<Self> {
        let (mut solver, centre) = (Solver::new(body)?, body.centre());
        let known = solver.solve(&centre, &Options::default())?.displacement;
        Ok(Self { held: solver.held_stiffness(&known, &centre)? })
    }

    /// The descent of a body at each of `thetas`, of at most `steps` steps: displacements, and the residual before and after.
    ///
    /// # Errors
    /// A body of other cells or supports, θ that makes no sense, [`SolveError::Inadmissible`] where prescribed motions turn cells over at once.
    pub fn predict(&self, body: &Body, thetas: &[Vec<f64>], steps: usize) -> Result<Vec<Descent>> {
        thetas.par_iter().map(|theta| self.descend(body, theta, steps)).collect()
    }

    fn descend(&self, body: &Body, theta: &[f64], steps: usize) -> Result<Descent> {
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
