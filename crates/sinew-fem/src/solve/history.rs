//! History of a solve, iteration by iteration.

use std::fmt;

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
    /// Fraction of the Newton step that was taken from here; 0 when none was.
    pub step: f64,
    /// Multiple of the mean diagonal that made the stiffness positive definite, 1e-6 where cells without negative eigenvalues did; 0 when it was.
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
