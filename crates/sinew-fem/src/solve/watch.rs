//! Watching a solve while it runs.

use crate::diagnose::named::CellValue;
use crate::{Advice, History, Iteration, NotConverged};

/// A state that a solve has come to: what [`crate::Solver::solve_watched`] hands out once per iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Number of the iteration, from 0, over all load steps.
    pub number: usize,
    /// Fraction of loads and prescribed motion.
    pub load_factor: f64,
    /// Norm of the unbalanced nodal forces at the free degrees of freedom \[stress·length²\].
    pub residual: f64,
    /// Residual at which the iteration ends.
    pub tolerance: f64,
    /// Total potential energy \[stress·length³\]; +∞ where a cell is inverted.
    pub energy: f64,
    /// Least volume ratio J of all cells.
    pub least_volume_ratio: f64,
    /// The cell that has it.
    pub worst_cell: usize,
    /// Fraction of a Newton step that led here; 0 where a load step begins and where the search went back.
    pub step: f64,
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: &'a [f64],
    /// Nodal forces \[stress·length²\]: unbalanced at free degrees of freedom, reactions at prescribed ones.
    pub forces: &'a [f64],
}

impl Progress<'_> {
    /// Load, iteration and residual for a progress bar.
    pub fn in_words(&self) -> String {
        let Self { number, load_factor, residual, tolerance, .. } = self;
        let load = 100.0 * load_factor;
        format!("load {load:.0} %, iteration {number}, residual {residual:.1e} of {tolerance:.1e}")
    }
}

/// Receives each state of all solves of a solver.
pub(crate) type Watch<'w> = &'w (dyn Fn(&Progress<'_>) + Sync + 'w);

/// Log of the iterations of a solve.
#[derive(Default)]
pub(crate) struct Log<'w> {
    pub iterations: Vec<Iteration>,
    watch: Option<&'w mut dyn FnMut(&Progress<'_>)>,
}

impl<'w> Log<'w> {
    pub(crate) fn watched(watch: &'w mut dyn FnMut(&Progress<'_>)) -> Self {
        Self { iterations: Vec::new(), watch: Some(watch) }
    }

    /// Adds the state that an iteration starts from.
    pub(crate) fn record(&mut self, iteration: Iteration, displacement: &[f64], forces: &[f64]) {
        if let Some(watch) = &mut self.watch {
            watch(&Progress {
                number: self.iterations.len(),
                load_factor: iteration.load_factor,
                residual: iteration.residual,
                tolerance: iteration.tolerance,
                energy: iteration.energy,
                least_volume_ratio: iteration.least_volume_ratio,
                worst_cell: iteration.worst_cell,
                step: self.iterations.last().map_or(0.0, |last| last.step),
                displacement,
                forces,
            });
        }
        self.iterations.push(iteration);
    }

    /// Number of the last iterations in a row whose stiffness was indefinite.
    pub(crate) fn indefinite(&self) -> usize {
        self.iterations.iter().rev().take_while(|iteration| iteration.shift > 0.0).count()
    }

    /// All iterations; the log is empty afterwards.
    pub(crate) fn take(&mut self) -> History {
        History { iterations: std::mem::take(&mut self.iterations) }
    }

    /// Failure of a solve that came no farther than `load_factor`, with the advice that is known or that of the last iterations.
    pub(crate) fn failure(
        &mut self,
        load_factor: f64,
        displacement: Vec<f64>,
        worst_cells: Vec<CellValue>,
        advice: Option<Advice>,
    ) -> Box<NotConverged> {
        let history = self.take();
        let advice = advice.unwrap_or_else(|| Advice::from_history(&history));
        Box::new(NotConverged { load_factor, displacement, history, worst_cells, advice })
    }
}
