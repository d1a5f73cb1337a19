//! Newton's method on the balance of forces at one load.

use super::state::{Residual, Unknowns};
use super::{BalanceSolver, System};
use crate::assembly::PredictedStress;
use crate::state::State;
use crate::supports::place;
use crate::watch::Log;
use crate::{Iteration, Options};

/// Iterations of one load step; beyond, smaller load steps are cheaper.
const MOST_ITERATIONS: usize = 20;
/// Unbalanced forces \[relative to loads and reactions\] and volumes \[relative to the body's\] of an equilibrium.
const TOLERANCE: f64 = 1e-10;
/// A residual that stops falling below this is at its floor.
const STALLED: f64 = 1e-7;
/// Least volume ratio that a step may leave, as a part of the one before it.
const LEAST_VOLUME: f64 = 0.3;
/// Growth of the residual in one step that ends the search.
const MOST_GROWTH: f64 = 1e4;
/// Steps shorter than this end the search.
const SHORTEST_STEP: f64 = 1e-2;

/// An equilibrium at one load.
#[derive(Clone, Debug)]
pub(super) struct Equilibrium {
    pub unknowns: Unknowns,
    pub residual: Residual,
    pub negative_pivots: usize,
    pub linear_iterations: usize,
}

impl BalanceSolver<'_> {
    /// Searches the equilibrium under a fraction of all loads and prescribed motion.
    pub(super) fn equilibrium(
        &mut self,
        initial: &Unknowns,
        theta: &[f64],
        load_factor: f64,
        options: &Options,
        history: &mut Log<'_>,
    ) -> Option<Equilibrium> {
        let mut at = initial.clone();
        place(&self.system.body.body, load_factor, &mut at.displacement);
        let mut predicted = None;
        let (mut before, mut linear_iterations, mut negative_pivots) = (f64::INFINITY, 0, 0);
        for iteration in 0..MOST_ITERATIONS {
            if history.iterations.len() >= options.iterations {
                return None;
            }
            let residual = self.system.assemble(&at, theta, load_factor, predicted.as_ref());
            self.record(&at, load_factor, &residual, history);
            let size = self.system.size(&residual)?;
            let at_floor = residual.force <= self.system.assembly.tolerance()
                && residual.volume <= TOLERANCE * self.system.volume();
            let stalled = size <= STALLED && size > 0.5 * before;
            if iteration > 0 && (size <= TOLERANCE || at_floor || stalled) {
                return Some(Equilibrium {
                    unknowns: at,
                    residual,
                    negative_pivots,
                    linear_iterations,
                });
            }
            if size > MOST_GROWTH * before.max(1e-3) {
                return None;
            }
            before = size;
            let preconditioner = self.precondition().ok()?;
            negative_pivots = preconditioner.negative_pivots;
            let right: Vec<_> = residual.values.iter().map(|r| -r).collect();
            let (change, outcome) = self.solve_linear(&preconditioner, &right);
            linear_iterations += outcome.iterations;
            let last = history.iterations.last_mut()?;
            last.shift = preconditioner.shift;
            last.step = self.take(&mut at, &change, theta)?;
            predicted = self.predict_stress(&change, last.step);
        }
        None
    }

    /// The stress that the linear model foresees after a step; with a field of pressure the change of that would be missing.
    fn predict_stress(&self, change: &[f64], length: f64) -> Option<PredictedStress> {
        let System { body, sparsity, assembly, .. } = &self.system;
        let mut step = vec![0.0; body.body.prescribed.len()];
        sparsity.scatter(change.iter().map(|c| length * c), &mut step);
        body.pressure_field.is_none().then(|| assembly.predict_stress(&body.body, &step))
    }

    /// Takes the longest of the steps 1, ½, ¼, … that squeezes no cell too much.
    pub(super) fn take(&self, at: &mut Unknowns, change: &[f64], theta: &[f64]) -> Option<f64> {
        let sparsity = &self.system.sparsity;
        let least = LEAST_VOLUME * self.system.assembly.least_volume_ratio.min(1.0);
        let mut length = 1.0;
        while length >= SHORTEST_STEP {
            let mut displacement = at.displacement.clone();
            sparsity.scatter(change.iter().map(|step| length * step), &mut displacement);
            let potential = &self.system.body.body;
            let ratios = (0..potential.volumes.len())
                .map(|p| 1.0 + potential.displacement_gradient(p, &displacement).volume_change());
            let safe = ratios.fold(f64::INFINITY, f64::min) > least;
            let state =
                State { displacement: &displacement, theta, load_factor: 0.0, pressure: &[] };
            if safe && state.energy(potential).is_finite() {
                at.displacement = displacement;
                let pressures = at.pressure.iter_mut().zip(&change[sparsity.unknowns()..]);
                pressures.for_each(|(p, step)| *p += length * step);
                return Some(length);
            }
            length *= 0.5;
        }
        None
    }

    pub(super) fn record(
        &self,
        at: &Unknowns,
        load_factor: f64,
        residual: &Residual,
        history: &mut Log<'_>,
    ) {
        let iteration = Iteration {
            load_factor,
            residual: residual.force,
            tolerance: self
                .system
                .assembly
                .tolerance()
                .max(TOLERANCE * self.system.assembly.force_scale),
            energy: self.system.assembly.energy,
            least_volume_ratio: self.system.assembly.least_volume_ratio,
            worst_cell: self.system.assembly.worst_cell,
            step: 0.0,
            shift: 0.0,
        };
        history.record(iteration, &at.displacement, &self.system.assembly.gradient);
    }
}
