//! History of a solve, iteration by iteration, and watching it while it runs.

use crate::error::CellValue;
use crate::{Advice, NotConverged};
use std::fmt;
use std::time::Instant;

/// One Newton iteration: the state it started from and the step it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// Fraction of loads and prescribed motion.
    pub load_factor: f64,
    /// Norm of the unbalanced nodal forces at the free degrees of freedom \[stress·length²\].
    pub residual: f64,
    /// Residual at which the iteration ends: what rounding errors in the nodal forces amount to.
    pub tolerance: f64,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Least volume ratio J of all cells.
    pub least_volume_ratio: f64,
    /// The cell that has it.
    pub worst_cell: usize,
    /// Multiple of the Newton step that was taken from here, above 1 where it was doubled; 0 when none was.
    pub step: f64,
    /// Multiple of the mean diagonal that made the stiffness positive definite, 1e-6 where tangents without negative eigenvalues did; 0 when it was.
    pub shift: f64,
}

/// All iterations of a solve in order, rejected load steps included.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// The iterations.
    pub iterations: Vec<Iteration>,
}

impl History {
    /// Number of Newton steps that were taken, those of rejected load steps included.
    pub fn steps(&self) -> usize {
        self.iterations.iter().filter(|i| i.step > 0.0).count()
    }
}

/// Number of last iterations that [`History`] prints.
const MOST_LINES: usize = 12;

impl fmt::Display for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let skipped = self.iterations.len().saturating_sub(MOST_LINES);
        writeln!(f, " it  load      residual   energy          min J     cell   step      shift")?;
        if skipped > 0 {
            writeln!(f, "  … {skipped} earlier iterations")?;
        }
        for (number, i) in self.iterations.iter().enumerate().skip(skipped) {
            writeln!(
                f,
                "{number:3}  {:<8}  {:9.2e}  {:14.7e}  {:<8}  {:<5}  {:<8.2e}  {:.1e}",
                short(i.load_factor),
                i.residual,
                i.energy,
                short(i.least_volume_ratio),
                i.worst_cell,
                i.step,
                i.shift
            )?;
        }
        Ok(())
    }
}

/// A number about one in eight characters, larger ones by their exponent.
fn short(value: f64) -> String {
    if value.abs() < 1e3 { format!("{value:.6}") } else { format!("{value:.2e}") }
}

/// A state that a solve has come to: what [`crate::Solver::solve_watched`] hands out once per iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Number of the iteration, from 0, over all load steps.
    pub number: usize,
    /// Load, residual and step of the iteration. Its step is the fraction of a Newton step that led here; 0 where a load step begins and where the search went back. Its shift is not yet known, and 0.
    pub iteration: Iteration,
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: &'a [f64],
    /// Nodal forces \[stress·length²\]: unbalanced at free degrees of freedom, reactions at prescribed ones.
    pub forces: &'a [f64],
    /// Wall-clock time left at this load \[s\], if the residual falls on at its mean rate: too long where Newton's method converges quadratically. `None`
    /// before the residual is a tenth of that where the load began.
    pub seconds_left: Option<f64>,
}

impl Progress<'_> {
    /// Load, iteration and residual for a progress bar.
    pub fn in_words(&self) -> String {
        let Iteration { load_factor, residual, tolerance, .. } = self.iteration;
        let (load, number) = (100.0 * load_factor, self.number);
        let left = self.seconds_left.filter(|left| *left >= 1.0);
        let left = left.map_or(String::new(), |left| format!(", about {left:.0} s left"));
        format!(
            "load {load:.0} %, iteration {number}, residual {residual:.1e} of {tolerance:.1e}{left}"
        )
    }
}

/// Receives each state of all solves of a solver.
pub(crate) type Watch<'w> = &'w (dyn Fn(&Progress<'_>) + Sync + 'w);

/// Log of the iterations of a solve.
#[derive(Default)]
pub(crate) struct Log<'w> {
    pub iterations: Vec<Iteration>,
    pub watch: Option<&'w mut dyn FnMut(&Progress<'_>)>,
    /// Time, load and residual where the present load began.
    began: Option<(Instant, f64, f64)>,
}

impl Log<'_> {
    /// See [`Progress::seconds_left`].
    fn seconds_left(&mut self, now: &Iteration) -> Option<f64> {
        let same = self.began.filter(|(_, load, _)| *load == now.load_factor);
        let (start, _, first) =
            *self.began.insert(same.unwrap_or((Instant::now(), now.load_factor, now.residual)));
        let fallen = (first / now.residual).ln();
        let rate = fallen / start.elapsed().as_secs_f64();
        (fallen >= 10.0_f64.ln()).then(|| (now.residual / now.tolerance).ln().max(0.0) / rate)
    }

    /// Adds the state that an iteration starts from.
    pub(crate) fn record(&mut self, iteration: Iteration, displacement: &[f64], forces: &[f64]) {
        let seconds_left = self.seconds_left(&iteration);
        if let Some(watch) = &mut self.watch {
            let (number, last) = (self.iterations.len(), self.iterations.last());
            let iteration = Iteration { step: last.map_or(0.0, |last| last.step), ..iteration };
            watch(&Progress { number, iteration, displacement, forces, seconds_left });
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
