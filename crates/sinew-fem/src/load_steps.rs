//! The whole load at once, or in steps where that fails.

use crate::newton::Equilibrium;
use crate::watch::{Log, Progress};
use crate::{Options, Solution, SolveError, Solver};

use std::time::Instant;

/// First load step when the whole load at once fails; later ones adapt.
const FIRST_STEP: f64 = 0.25;
/// Factors of the load step after a success and after a failure.
const GROWTH: f64 = 1.5;
const CUT: f64 = 0.5;

impl Solver<'_> {
    /// The equilibrium for θ, starting from the reference configuration.
    ///
    /// # Errors
    /// θ that makes no sense, or [`SolveError::NotConverged`].
    pub fn solve(&mut self, theta: &[f64], options: &Options) -> Result<Solution, SolveError> {
        let rest = vec![0.0; self.potential.prescribed.len()];
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

    /// As [`Solver::solve`]; `watch` is called with each state that the iteration comes to.
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
        let rest = vec![0.0; self.potential.prescribed.len()];
        self.solve_from_watched(&rest, theta, options, watch)
    }

    /// As [`Solver::solve_from`]; `watch` is called with each state that the iteration comes to.
    ///
    /// # Errors
    /// As for [`Solver::solve_from`].
    pub fn solve_from_watched(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<Solution, SolveError> {
        self.solve_logged(initial, theta, options, Log::watched(watch))
    }

    fn solve_logged(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        options: &Options,
        mut history: Log<'_>,
    ) -> Result<Solution, SolveError> {
        let start = Instant::now();
        self.potential.check_theta(theta)?;
        self.check_displacement(initial)?;
        let (equilibrium, load_steps) =
            match self.equilibrium(initial, theta, 1.0, options, &mut history) {
                Some(equilibrium) => (equilibrium, 1),
                None => match self.follow_load(theta, options, &mut history) {
                    Ok(found) => found,
                    Err((load_factor, displacement)) => {
                        let worst_cells = self.assembly.worst_cells(self.potential.points_per_cell);
                        return Err(history.failure(load_factor, displacement, worst_cells));
                    }
                },
            };
        let residual = history.iterations.last().map_or(0.0, |i| i.residual);
        Ok(Solution {
            displacement: equilibrium.displacement,
            // The sum over all cells in one order, the same as every reader of the potential gets.
            energy: self.assembly.energy,
            theta: theta.to_vec(),
            residual,
            force_scale: self.assembly.force_scale,
            least_volume_ratio: self.assembly.least_volume_ratio,
            negative_pivots: equilibrium.negative_pivots,
            load_steps,
            history: history.take(),
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Follows the equilibrium from rest to the whole load: the last one and the number of steps, or the
    /// largest load factor with its displacement.
    fn follow_load(
        &mut self,
        theta: &[f64],
        options: &Options,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), (f64, Vec<f64>)> {
        let mut reached = (0.0, vec![0.0; self.potential.prescribed.len()]);
        let mut before: Option<(f64, Vec<f64>)> = None;
        let (mut step, mut steps) = (FIRST_STEP, 0);
        while step >= options.least_load_step && history.iterations.len() < options.iterations {
            let target = f64::min(reached.0 + step, 1.0);
            let guess = extrapolate(before.as_ref(), &reached, target);
            let Some(found) = self.equilibrium(&guess, theta, target, options, history) else {
                step *= CUT;
                continue;
            };
            steps += 1;
            if target >= 1.0 {
                return Ok((found, steps));
            }
            before = Some(std::mem::replace(&mut reached, (target, found.displacement)));
            step *= GROWTH;
        }
        Err(reached)
    }
}

/// The displacement on the line through the last two equilibria.
fn extrapolate(
    before: Option<&(f64, Vec<f64>)>,
    (load, last): &(f64, Vec<f64>),
    target: f64,
) -> Vec<f64> {
    let Some((earlier, previous)) = before else { return last.clone() };
    let ratio = (target - load) / (load - earlier);
    last.iter().zip(previous).map(|(u, v)| u + ratio * (u - v)).collect()
}
