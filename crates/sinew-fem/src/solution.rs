//! What a solve returns.

use crate::History;

/// An equilibrium of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Parameters of law and loads.
    pub theta: Vec<f64>,
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Norm of the loads and reactions \[stress·length²\], to compare the residual with.
    pub force_scale: f64,
    /// Least volume ratio J of all cells.
    pub least_volume_ratio: f64,
    /// Number of negative eigenvalues of the last stiffness: 0 for a stable equilibrium.
    pub negative_pivots: usize,
    /// Number of load steps, 1 when the whole load was taken at once.
    pub load_steps: usize,
    /// All iterations.
    pub history: History,
    /// Wall-clock time of the solve \[s\].
    pub seconds: f64,
}

impl Solution {
    /// Whether the equilibrium is a minimum of the potential: small disturbances die out.
    pub fn is_stable(&self) -> bool {
        self.negative_pivots == 0
    }

    /// Number of Newton iterations.
    pub fn iterations(&self) -> usize {
        self.history.iterations.iter().filter(|i| i.step > 0.0).count()
    }
}

/// Limits on a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most Newton iterations, all load steps together.
    pub iterations: usize,
    /// Smallest load step, as a fraction of the load, before the solve gives up.
    pub least_load_step: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { iterations: 600, least_load_step: 1e-4 }
    }
}
