//! The solver of bodies with a potential: what is prepared once per body.

use crate::elements::assembly::PredictedStress;
use crate::elements::check::check_state;
use crate::elements::state::State;
use crate::elements::system::{System, Unknowns};
use crate::linear::vector::norm;
use crate::solve::path::Path;
use crate::solve::watch::{Log, Progress};
use crate::{LoadSteps, Options, Solution, SolveError};
use sinew_energy::Body;
use std::time::Instant;

/// Displacements of one equilibrium that two searches end at differ by less than this [relative to their norm]: both are accurate to rounding
/// errors, which a stiffness of bad condition multiplies.
const SAME: f64 = 1e-4;

/// Finds equilibria of one body for any θ.
///
/// Sparsity, ordering and symbolic factorisation are prepared once; the memory of the numbers is reused.
#[doc(alias("Newton-Raphson", "Newton"))]
pub struct Solver<'p> {
    pub(crate) system: System<'p>,
}

impl<'p> Solver<'p> {
    /// Prepares the solver.
    ///
    /// # Errors
    /// A potential that is malformed or whose supports leave a part of the body free to move.
    pub fn new(potential: &'p Body) -> Result<Self, SolveError> {
        System::new(potential).map(|system| Self { system })
    }

    /// Another solver of the same body, for another thread; it shares what is prepared.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn fresh(&self) -> Result<Self, SolveError> {
        self.system.fresh().map(|system| Self { system })
    }

    /// The body that is solved.
    pub fn body(&self) -> &'p Body {
        self.system.body
    }

    /// Number of unknowns: degrees of freedom that no support prescribes.
    pub fn unknowns(&self) -> usize {
        self.system.sparsity.unknowns()
    }

    /// Stored entries of the lower half of the stiffness and of its factor.
    pub fn stored_entries(&self) -> [usize; 2] {
        [self.system.sparsity.entries(), self.system.factor.entries()]
    }

    pub(crate) fn check(&self, displacement: &[f64], theta: &[f64]) -> Result<(), SolveError> {
        check_state(self.system.body, displacement, theta)
    }

    /// Assembles at a displacement that may come from anywhere; `predicted` as in [`crate::elements::assembly::Assembly::assemble`].
    pub(crate) fn visit(
        &mut self,
        displacement: &[f64],
        (theta, load_factor): (&[f64], f64),
        predicted: Option<&PredictedStress>,
    ) -> Result<(), SolveError> {
        self.check(displacement, theta)?;
        let state = State { displacement, theta, load_factor, pressure: &[] };
        let System { body, sparsity, assembly, .. } = &mut self.system;
        assembly.assemble(body, sparsity, state, predicted);
        let cell = assembly.worst_cell;
        if assembly.is_finite() { Ok(()) } else { Err(SolveError::Inadmissible { cell }) }
    }

    /// The equilibrium for θ, starting from the reference configuration.
    ///
    /// # Errors
    /// θ that makes no sense, or [`SolveError::NotConverged`].
    #[doc(alias("Newton-Raphson", "line search"))]
    pub fn solve(&mut self, theta: &[f64], options: &Options) -> Result<Solution, SolveError> {
        let rest = self.system.rest().displacement;
        self.solve_from(&rest, theta, options)
    }

    /// The equilibrium for θ, starting from a displacement \[length\] that should be near it.
    ///
    /// When the search from there fails, loads and prescribed motions are raised step by step from rest.
    ///
    /// # Errors
    /// As for [`Solver::solve`], and an initial displacement of the wrong length or that is not finite.
    pub fn solve_from(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution, SolveError> {
        self.solve_logged(initial, theta, options, Log::default())
    }

    /// The equilibrium that the body comes to under loads and prescribed motions that rise slowly from rest, if it is another one than a
    /// solution: of several stable equilibria the whole load at once may find one that a rising load does not lead to. Costs as much as a
    /// solve by load steps.
    ///
    /// # Errors
    /// As for [`Solver::solve`], and a solution of another body.
    pub fn under_rising_load(
        &mut self,
        solution: &Solution,
        options: &Options,
    ) -> Result<Option<Solution>, SolveError> {
        self.check(&solution.displacement, &solution.theta)?;
        let options = Options { load_steps: LoadSteps::Always, ..*options };
        let risen = self.solve(&solution.theta, &options)?;
        let apart = risen.displacement.iter().zip(&solution.displacement).map(|(a, b)| a - b);
        let apart = norm(&apart.collect::<Vec<_>>());
        let size = norm(&risen.displacement).max(norm(&solution.displacement));
        Ok((apart > SAME * size).then_some(risen))
    }

    /// Solves as [`Solver::solve`] does; `watch` is called with each state that the iteration comes to.
    ///
    /// ```no_run
    /// # fn f(solver: &mut sinew_fem::Solver) -> Result<(), sinew_fem::SolveError> {
    /// use sinew_fem::{Options, print_progress};
    /// solver.solve_watched(&[75.0, 75.0], &Options::default(), &mut print_progress)?;
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
    ) -> Result<Solution, SolveError> {
        let rest = self.system.rest().displacement;
        self.solve_logged(&rest, theta, options, Log::watched(watch))
    }

    fn solve_logged(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        options: &Options,
        mut history: Log<'_>,
    ) -> Result<Solution, SolveError> {
        let start = Instant::now();
        self.check(initial, theta)?;
        let path = Path::to_load(&mut self.system, theta, options);
        let found = path.run(Unknowns::of(initial), &mut history)?;
        Ok(Solution::new(&self.system, found, theta, history.take(), start))
    }
}
