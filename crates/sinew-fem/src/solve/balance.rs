//! Equilibria that are not minima: incompressible bodies and pressures on surfaces with a loose rim.

use crate::elements::check::check_length;
use crate::elements::system::{System, Unknowns};
use crate::solve::path::Path;
use crate::solve::search::Equilibrium;
use crate::solve::watch::{Log, Progress};
use crate::{History, LockingWarning, Options, SolveError};
use sinew_energy::ForceBalance;
use std::time::Instant;

/// Finds equilibria of a body for which there is no potential to minimise.
///
/// Newton's method on the balance of forces, under rising load. The linear systems are solved by GMRES; the
/// Cholesky factor of the symmetric part of the stiffness preconditions the displacements, the mass matrix
/// of the pressures over the local moduli their Schur complement, so that 5–30 iterations do.
///
/// ```
/// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::Guccione};
/// use sinew_fem::{BalanceSolver, Options};
/// use sinew_mesh::box_tetrahedra;
///
/// // Problem 1 of Land et al. (2015) on a coarse mesh: a beam under pressure from below.
/// let mesh = box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]).quadratic();
/// let law = Guccione.nearly_incompressible(3.0); // the field of pressure brings the rest
/// let scene = Scene::new(mesh, law)
///     .directions(vec![Guccione::frame([1.0, 0.0, 0.0]); 60])
///     .parameter(Parameter::log("C", "kPa", 2.0..=2.0))
///     .parameter(Parameter::log("b_f", "1", 8.0..=8.0))
///     .parameter(Parameter::log("b_t", "1", 2.0..=2.0))
///     .parameter(Parameter::log("b_fs", "1", 4.0..=4.0))
///     .load(Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.004) })
///     .support(Support::clamped("x_min"));
/// let body = scene.lower_mixed()?;
/// let solution = BalanceSolver::new(&body)?.solve(&[2.0, 8.0, 2.0, 4.0], &Options::default())?;
/// let corner = scene.mesh.points.iter().position(|&x| x == [10.0, 0.0, 1.0]).unwrap();
/// let z = 1.0 + solution.displacement[3 * corner + 2];
/// assert!((z - 4.05).abs() < 0.1, "{z}"); // mm; 4.16 on fine meshes
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct BalanceSolver<'p> {
    pub(crate) system: System<'p>,
}

/// An equilibrium of forces.
#[derive(Clone, Debug, PartialEq)]
pub struct BalanceSolution {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// The field of pressure at [`sinew_energy::PressureField::nodes`] \[stress\], compression negative; empty
    /// without one.
    pub pressure: Vec<f64>,
    /// Parameters of law and loads.
    pub theta: Vec<f64>,
    /// Fraction of all loads.
    pub load_factor: f64,
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Norm of the changes of volume that the pressures should prevent \[length³\].
    pub volume_residual: f64,
    /// Norm of the loads and reactions \[stress·length²\], to compare the residual with.
    pub force_scale: f64,
    /// Least volume ratio J of all quadrature points.
    pub least_volume_ratio: f64,
    /// Negative pivots of the symmetric part of the stiffness of the displacements.
    pub negative_pivots: usize,
    /// Elements that are too stiff for this body, so that the displacement is too small.
    pub locking: Option<LockingWarning>,
    /// Number of load steps, 1 when the whole load was taken at once.
    pub load_steps: usize,
    /// Iterations of all linear systems.
    pub linear_iterations: usize,
    /// All iterations.
    pub history: History,
    /// Wall-clock time of the solve \[s\].
    pub seconds: f64,
}

impl BalanceSolution {
    /// Number of Newton iterations.
    pub fn iterations(&self) -> usize {
        self.history.steps()
    }

    pub(crate) fn new(
        system: &System<'_>,
        (found, load_steps): (Equilibrium, usize),
        theta: &[f64],
        history: History,
        start: Instant,
    ) -> Self {
        Self {
            displacement: found.unknowns.displacement,
            pressure: found.unknowns.pressure,
            theta: theta.to_vec(),
            load_factor: found.load_factor,
            residual: found.residual.force,
            volume_residual: found.residual.volume,
            force_scale: found.force_scale,
            least_volume_ratio: found.least_volume_ratio,
            negative_pivots: found.negative_pivots,
            locking: system.locking(theta),
            load_steps,
            linear_iterations: found.linear_iterations,
            history,
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

impl<'p> BalanceSolver<'p> {
    /// Prepares the solver.
    ///
    /// # Errors
    /// A potential that is malformed or whose supports leave a part of the body free to move.
    pub fn new(balance: &'p ForceBalance) -> Result<Self, SolveError> {
        System::balance(balance).map(|system| Self { system })
    }

    /// Another solver of the same balance, for another thread; it shares what is prepared.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn fresh(&self) -> Result<Self, SolveError> {
        self.system.fresh().map(|system| Self { system })
    }

    /// Number of unknowns: free degrees of freedom, then pressures.
    pub fn unknowns(&self) -> [usize; 2] {
        [self.system.sparsity.unknowns(), self.system.pressures()]
    }

    /// The equilibrium for θ, reached from the reference configuration: at once if that works, else under
    /// loads and prescribed motions that rise step by step.
    ///
    /// # Errors
    /// θ that makes no sense, or [`SolveError::NotConverged`].
    pub fn solve(
        &mut self,
        theta: &[f64],
        options: &Options,
    ) -> Result<BalanceSolution, SolveError> {
        let rest = self.system.rest();
        self.solve_logged(rest, theta, options, Log::default())
    }

    /// The equilibrium for θ, starting from one that should be near it; step by step from rest where that fails.
    ///
    /// # Errors
    /// As for [`BalanceSolver::solve`], and a solution of another body.
    pub fn solve_from(
        &mut self,
        near: &BalanceSolution,
        theta: &[f64],
        options: &Options,
    ) -> Result<BalanceSolution, SolveError> {
        let from = self.checked(near, theta)?;
        self.solve_logged(from, theta, options, Log::default())
    }

    /// The unknowns of a solution, if it is one of this body.
    pub(crate) fn checked(
        &self,
        solution: &BalanceSolution,
        theta: &[f64],
    ) -> Result<Unknowns, SolveError> {
        self.system.check_theta(theta)?;
        let BalanceSolution { displacement, pressure, .. } = solution.clone();
        check_length(self.system.body.prescribed.len(), &displacement)?;
        check_length(self.system.pressures(), &pressure)?;
        Ok(Unknowns { displacement, pressure })
    }

    /// Solves as [`BalanceSolver::solve`] does; `watch` is called with each state that the iteration comes to.
    ///
    /// # Errors
    /// As for [`BalanceSolver::solve`].
    pub fn solve_watched(
        &mut self,
        theta: &[f64],
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<BalanceSolution, SolveError> {
        let rest = self.system.rest();
        self.solve_logged(rest, theta, options, Log::watched(watch))
    }

    fn solve_logged(
        &mut self,
        from: Unknowns,
        theta: &[f64],
        options: &Options,
        mut history: Log<'_>,
    ) -> Result<BalanceSolution, SolveError> {
        let start = Instant::now();
        self.system.check_theta(theta)?;
        let found = Path::to_load(&mut self.system, theta, options).run(from, &mut history)?;
        Ok(BalanceSolution::new(&self.system, found, theta, history.take(), start))
    }
}
