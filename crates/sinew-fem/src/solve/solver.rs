//! The solver: what is prepared once per body.

use crate::elements::{
    PredictedStress, State, System, Unknowns, check_potential, check_pressure, check_state,
    is_nearly_incompressible,
};
use crate::linear::{difference, norm};
use crate::solve::{Path, Progress, Watch};
use crate::{Line, LoadSteps, Options, Result, Solution, SolveError};
use sinew_energy::Body;
use std::sync::Mutex;
use std::time::Instant;

/// Largest difference of two displacements of the same equilibrium [relative to their norm]: rounding errors, amplified
/// by an ill-conditioned stiffness.
const SAME: f64 = 1e-4;
/// Residuals that tell branches apart, on the way and at the end; to rounding errors a path takes twice the time.
const ON_THE_WAY: f64 = 1e-3;
const AT_THE_END: f64 = 1e-8;

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

    /// The equilibrium for θ, starting from the reference configuration.
    ///
    /// # Errors
    /// θ that makes no sense, or [`SolveError::NotConverged`].
    #[doc(alias("Newton-Raphson", "line search"))]
    pub fn solve(&mut self, theta: &[f64], options: &Options) -> Result<Solution> {
        let rest = self.system.rest();
        self.solve_told(rest, theta, options, &mut |_| ())
    }

    /// The equilibrium for θ, starting from a displacement \[length\] that should be near it.
    ///
    /// When the search from there fails, loads and prescribed motions are raised step by step from rest. A field of pressure begins at zero; see
    /// [`Solver::solve_near`].
    ///
    /// # Errors
    /// As for [`Solver::solve`], and an initial displacement of the wrong length or that is not finite.
    pub fn solve_from(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution> {
        let from = self.at(initial, theta)?;
        self.solve_told(from, theta, options, &mut |_| ())
    }

    /// The equilibrium for θ, starting from another one with its field of pressure; step by step from rest where that fails.
    ///
    /// # Errors
    /// As for [`Solver::solve`], and a solution of another body.
    pub fn solve_near(
        &mut self,
        near: &Solution,
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution> {
        let from = self.checked(near, theta)?;
        self.solve_told(from, theta, options, &mut |_| ())
    }

    /// The equilibrium under loads and prescribed motions that rise slowly from rest, if it differs from `solution`. Of
    /// several stable equilibria, the whole load at once may find one that a rising load does not. Costs a solve by
    /// load steps, to smaller accuracy; `watch` is called with each state that the iteration comes to.
    ///
    /// # Errors
    /// As for [`Solver::solve`], and a solution of another body.
    pub fn under_rising_load(
        &mut self,
        solution: &Solution,
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<Option<Solution>> {
        self.checked(solution, &solution.theta)?;
        let mut options = Options { load_steps: LoadSteps::Always, ..*options };
        if self.body().has_potential() {
            options.accuracy = ON_THE_WAY;
            options.minimum_accuracy = options.minimum_accuracy.max(AT_THE_END);
        }
        let risen = self.solve_watched(&solution.theta, &options, watch)?;
        let apart = norm(&difference(&risen.displacement, &solution.displacement));
        let size = norm(&risen.displacement).max(norm(&solution.displacement));
        Ok((apart > SAME * size).then_some(risen))
    }

    /// Solves as [`Solver::solve`] does; `watch` is called with each state that the iteration comes to.
    ///
    /// ```no_run
    /// # fn f(solver: &mut sinew_fem::Solver) -> Result<(), sinew_fem::SolveError> {
    /// use sinew_fem::{Options, Progress};
    /// let mut watch = |state: &Progress| eprintln!("{}", state.in_words());
    /// solver.solve_watched(&[75.0, 75.0], &Options::default(), &mut watch)?;
    /// # Ok(()) }
    /// ```
    ///
    /// # Errors
    /// As for [`Solver::solve`].
    pub fn solve_watched(
        &mut self,
        theta: &[f64],
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<Solution> {
        let rest = self.system.rest();
        self.solve_told(rest, theta, options, watch)
    }

    fn solve_told(
        &mut self,
        from: Unknowns,
        theta: &[f64],
        options: &Options,
        tell: &mut dyn FnMut(&Progress<'_>),
    ) -> Result<Solution> {
        let (start, watch) = (Instant::now(), self.watch);
        let mut tell = |state: &Progress<'_>| {
            watch.iter().for_each(|watch| watch(state));
            tell(state);
        };
        self.system.body.check_theta(theta)?;
        let mut path = Path::from_rest(&mut self.system, Line::of_loads(theta), options);
        path.log.watch = Some(&mut tell);
        let found = path.run(from)?;
        let (at, history) = (path.line.at(found.0.place), path.log.take());
        Ok(Solution::new(&self.system, found, at, history, start))
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
