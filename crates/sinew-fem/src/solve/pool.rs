//! Solvers of one body for several threads.

use crate::{SolveError, Solver};
use sinew_energy::Body;
use std::sync::Mutex;

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
