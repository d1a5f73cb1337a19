//! The solver: what is prepared once per body.

use crate::elements::{
    PredictedStress, State, System, Unknowns, check_potential, check_pressure, check_state,
    is_nearly_incompressible,
};
use crate::solve::Watch;
use crate::{Result, Solution, SolveError};
use sinew_energy::Body;
use std::sync::Mutex;

/// Finds equilibria of one body for any θ.
///
/// Sparsity, ordering and symbolic factorisation are prepared once; the memory of the numbers is reused.
///
/// The stiffness of a body with a potential is factorised; large compact bodies take conjugate gradients, see [`crate::Method`]. Without one ([`Body::has_potential`]) Newton's method solves the
/// balance of forces, its linear systems by GMRES. The Cholesky factor of the symmetric part of the stiffness preconditions the displacements,
/// the mass matrix of the pressures over the local moduli their Schur complement, so that 5–30 iterations do. Methods that need a potential
/// return [`SolveError::NoPotential`] there.
///
/// ```
/// use sinew_energy::{Law, Load, Magnitude, Parameter, Scene, Support, laws::Guccione};
/// use sinew_fem::{Options, Solver};
/// use sinew_mesh::box_tetrahedra;
///
/// // Problem 1 of Land et al. (2015) on a coarse mesh: a beam under pressure from below.
/// let mesh = box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]).quadratic();
/// let law = Guccione.nearly_incompressible(3.0); // the field of pressure brings the rest
/// let scene = Scene::new(mesh, law.along(vec![Guccione::frame([1.0, 0.0, 0.0]); 60]))
///     .parameter(Parameter::log("C", "kPa", 2.0..=2.0))
///     .parameter(Parameter::log("b_f", "1", 8.0..=8.0))
///     .parameter(Parameter::log("b_t", "1", 2.0..=2.0))
///     .parameter(Parameter::log("b_fs", "1", 4.0..=4.0))
///     .load(Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.004) })
///     .support(Support::clamped("x_min"));
/// let scene = scene.mixed();
/// let body = scene.lower()?;
/// let solution = Solver::new(&body)?.solve(&[2.0, 8.0, 2.0, 4.0], &Options::default())?;
/// let corner = scene.mesh.points().iter().position(|&x| x == [10.0, 0.0, 1.0]).unwrap();
/// let z = 1.0 + solution.displacement[3 * corner + 2];
/// assert!((z - 4.05).abs() < 0.1, "{z}"); // mm; 4.16 on fine meshes
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("Newton-Raphson", "Newton"))]
pub struct Solver<'p> {
    pub(crate) system: System<'p>,
    pub(crate) watch: Option<Watch<'p>>,
}

impl<'p> Solver<'p> {
    /// Prepares the solver.
    ///
    /// # Errors
    /// A body whose supports leave a part of it free to move.
    pub fn new(body: &'p Body) -> Result<Self> {
        System::new(body).map(Self::of)
    }

    pub(crate) fn of(system: System<'p>) -> Self {
        Self { system, watch: None }
    }

    /// Another solver of the same body, for another thread; it shares what is prepared.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn fresh(&self) -> Result<Self> {
        self.system.like(self.body()).map(|system| Self { system, watch: self.watch })
    }

    /// The body that is solved.
    pub fn body(&self) -> &'p Body {
        self.system.body
    }

    /// Number of unknowns: degrees of freedom that no support prescribes.
    pub fn unknowns(&self) -> usize {
        self.system.sparsity.unknowns()
    }

    /// Number of unknown pressures: 0 without such a field.
    pub fn pressures(&self) -> usize {
        self.system.pressures()
    }

    /// Stored entries of the lower half of the stiffness and of its factor.
    pub fn stored_entries(&self) -> [usize; 2] {
        [self.system.sparsity.entries(), self.system.factor.entries()]
    }

    /// The unknowns at a displacement, without pressures, if it is one of this body.
    pub(crate) fn at(&self, displacement: &[f64], theta: &[f64]) -> Result<Unknowns> {
        check_state(self.body(), displacement, theta)?;
        Ok(Unknowns { displacement: displacement.to_vec(), ..self.system.rest() })
    }

    /// The unknowns of a solution, if it is one of this body.
    pub(crate) fn checked(&self, solution: &Solution, theta: &[f64]) -> Result<Unknowns> {
        let Solution { displacement, pressure, .. } = solution;
        check_pressure(self.body(), pressure)?;
        Ok(Unknowns { pressure: pressure.clone(), ..self.at(displacement, theta)? })
    }

    /// Assembles at a displacement that may come from anywhere; `predicted` as in [`crate::elements::assembly::Assembly::assemble`].
    pub(crate) fn visit(
        &mut self,
        displacement: &[f64],
        (theta, load_factor): (&[f64], f64),
        predicted: Option<&PredictedStress>,
    ) -> Result<()> {
        check_potential(self.body(), displacement, theta)?;
        let state = State { displacement, theta, load_factor, pressure: &[] };
        let System { body, sparsity, assembly, .. } = &mut self.system;
        assembly.nearly_incompressible = is_nearly_incompressible(body, theta);
        assembly.assemble(body, sparsity, state, predicted);
        assembly.check()
    }
}

/// Idle solvers of a body. Every call borrows one of them, or a new one where all are at work.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{Options, SolverPool};
/// # let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [3, 1, 1]), NeoHookean)
/// #     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
/// #     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
/// #     .load(Load::BodyForce([0.0, 0.0, -1e-2]))
/// #     .support(Support::clamped("x_min"))
/// #     .lower()?;
/// let solvers = SolverPool::new(&beam);
/// let solve = |theta: &[f64]| solvers.with(|solver| solver.solve(theta, &Options::default()));
/// let found = std::thread::scope(|scope| {
///     let other = scope.spawn(|| solve(&[50.0, 90.0]));
///     [solve(&[60.0, 80.0]), other.join().unwrap()]
/// });
/// assert!(found.iter().all(Result::is_ok));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SolverPool<'b> {
    body: &'b Body,
    idle: Mutex<Vec<Solver<'b>>>,
}

impl<'b> SolverPool<'b> {
    /// A pool without solvers; the first call prepares one.
    pub fn new(body: &'b Body) -> Self {
        Self { body, idle: Mutex::default() }
    }

    /// Adds a solver of the body.
    pub fn add(&self, solver: Solver<'b>) {
        self.idle.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(solver);
    }

    /// Calls `call` with a solver that no other thread has.
    ///
    /// # Errors
    /// Those of `call`, and a body whose supports leave a part of it free to move.
    pub fn with<T, E: From<SolveError>>(
        &self,
        call: impl FnOnce(&mut Solver<'b>) -> Result<T, E>,
    ) -> Result<T, E> {
        // The lock is not held during the call.
        let taken = self.idle.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).pop();
        let mut solver = match taken {
            Some(solver) => solver,
            None => Solver::new(self.body)?,
        };
        let called = call(&mut solver);
        self.add(solver);
        called
    }
}
