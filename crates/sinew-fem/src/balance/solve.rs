//! Equilibria under rising load.

use super::BalanceSolver;
use super::newton::Equilibrium;
use super::state::Unknowns;
use crate::watch::{Log, Progress};
use crate::{History, Options, SolveError};
use std::time::Instant;

/// First load step when the whole load at once fails; later ones adapt.
const FIRST_STEP: f64 = 0.25;
/// Most and least that a load step changes by from one to the next.
const GROWTH: f64 = 1.5;
const CUT: f64 = 0.5;
/// Iterations of a load step after which the next one is as long.
const USUAL_ITERATIONS: f64 = 8.0;
/// Equilibria that the next one is extrapolated from.
const PATH: usize = 4;

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
    /// Number of load steps, 1 when the whole load was taken at once.
    pub load_steps: usize,
    /// Iterations of all linear systems.
    pub linear_iterations: usize,
    /// All iterations.
    pub history: History,
    /// Wall-clock time of the solve \[s\].
    pub seconds: f64,
}

impl BalanceSolver<'_> {
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
        self.solve_logged(theta, options, Log::default())
    }

    /// As [`BalanceSolver::solve`]; `watch` is called with each state that the iteration comes to.
    ///
    /// # Errors
    /// As for [`BalanceSolver::solve`].
    pub fn solve_watched(
        &mut self,
        theta: &[f64],
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<BalanceSolution, SolveError> {
        self.solve_logged(theta, options, Log::watched(watch))
    }

    fn solve_logged(
        &mut self,
        theta: &[f64],
        options: &Options,
        mut history: Log<'_>,
    ) -> Result<BalanceSolution, SolveError> {
        let start = Instant::now();
        self.system.body.check_theta(theta)?;
        let rest = self.rest();
        let (found, load_steps) = match self.equilibrium(&rest, theta, 1.0, options, &mut history) {
            Some(found) => (found, 1),
            None => match self.follow_load(theta, options, &mut history) {
                Ok(found) => found,
                Err((load_factor, Unknowns { displacement, .. })) => {
                    let worst_cells = self.system.worst_cells();
                    return Err(history.failure(load_factor, displacement, worst_cells));
                }
            },
        };
        let mut solution = self.solution(found, theta, 1.0);
        (solution.load_steps, solution.history) = (load_steps, history.take());
        solution.seconds = start.elapsed().as_secs_f64();
        Ok(solution)
    }

    pub(super) fn rest(&self) -> Unknowns {
        let [_, pressures] = self.unknowns();
        let displacement = vec![0.0; self.system.body.body.prescribed.len()];
        Unknowns { displacement, pressure: vec![0.0; pressures] }
    }

    pub(super) fn solution(
        &self,
        found: Equilibrium,
        theta: &[f64],
        load_factor: f64,
    ) -> BalanceSolution {
        BalanceSolution {
            displacement: found.unknowns.displacement,
            pressure: found.unknowns.pressure,
            theta: theta.to_vec(),
            load_factor,
            residual: found.residual.force,
            volume_residual: found.residual.volume,
            force_scale: self.system.assembly.force_scale,
            least_volume_ratio: self.system.assembly.least_volume_ratio,
            negative_pivots: found.negative_pivots,
            load_steps: 1,
            linear_iterations: found.linear_iterations,
            history: History::default(),
            seconds: 0.0,
        }
    }

    /// Follows the equilibrium from rest to the whole load, extrapolating from step to step.
    fn follow_load(
        &mut self,
        theta: &[f64],
        options: &Options,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), (f64, Unknowns)> {
        let mut path = vec![(0.0, self.rest())];
        let (mut step, mut steps, mut linear_iterations) = (FIRST_STEP, 0, 0);
        while step >= options.least_load_step && history.iterations.len() < options.iterations {
            let target = f64::min(path[path.len() - 1].0 + step, 1.0);
            let guess = extrapolate(&path, target);
            let before = history.iterations.len();
            let found = self.equilibrium(&guess, theta, target, options, history);
            let Some(mut found) = found else {
                step *= CUT;
                continue;
            };
            steps += 1;
            linear_iterations += found.linear_iterations;
            if target >= 1.0 {
                found.linear_iterations = linear_iterations;
                return Ok((found, steps));
            }
            path.push((target, found.unknowns));
            path.drain(..path.len().saturating_sub(PATH));
            let iterations = (history.iterations.len() - before) as f64;
            step *= (USUAL_ITERATIONS / iterations).clamp(CUT, GROWTH);
        }
        Err(path.swap_remove(path.len() - 1))
    }
}

/// The unknowns on the polynomial through the last equilibria, which are at different loads.
fn extrapolate(path: &[(f64, Unknowns)], target: f64) -> Unknowns {
    let [displacement, pressure] = [&path[0].1.displacement, &path[0].1.pressure].map(Vec::len);
    let mut guess =
        Unknowns { displacement: vec![0.0; displacement], pressure: vec![0.0; pressure] };
    for (load, at) in path {
        let others = path.iter().map(|(other, _)| other).filter(|other| *other != load);
        let weight: f64 = others.map(|other| (target - other) / (load - other)).product();
        let add = |sum: &mut [f64], values: &[f64]| {
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
        };
        add(&mut guess.displacement, &at.displacement);
        add(&mut guess.pressure, &at.pressure);
    }
    guess
}
