//! Limits and accuracy of a solve.

use crate::Method;

/// When loads are raised step by step.
#[doc(alias("load increment", "load stepping"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoadSteps {
    /// Only if the whole load at once fails; this takes the fewest iterations. A body with several stable equilibria
    /// ends at one of them.
    #[default]
    WhenNeeded,
    /// Always, from rest: the equilibrium of a slowly rising load, until the body snaps. Initial states are ignored.
    Always,
}

/// Limits and accuracy of a solve, and its load increments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most iterations of all load steps together, without those of a failed detour by a softer bulk modulus. Hard bodies take a few hundred.
    pub iterations: usize,
    /// Most iterations at one load: successful searches take fewer, and a smaller load step is cheaper than more. A search for a minimum may take
    /// twice as many while it converges by full steps.
    pub iterations_per_load: usize,
    /// When loads are raised step by step: for bodies with several stable equilibria.
    pub load_steps: LoadSteps,
    /// Smallest load step \[relative to the load reached\] before the solve gives up; a value above 0.25, the largest first load step,
    /// allows no load steps.
    pub least_load_step: f64,
    /// Residual of an equilibrium without a potential: forces \[relative to loads and reactions\] and volume changes
    /// \[relative to the body's volume\]; 1e-2 at intermediate loads. Minima of a potential meet it at intermediate loads, and are solved to
    /// rounding errors at the final load.
    pub accuracy: f64,
    /// Residual that is enough for a minimum of a potential; 0, the default, solves to rounding errors.
    pub minimum_accuracy: f64,
    /// Method for the linear systems of a body with a potential.
    pub method: Method,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            iterations: 600,
            iterations_per_load: 40,
            load_steps: LoadSteps::WhenNeeded,
            least_load_step: 1e-4,
            accuracy: 1e-10,
            minimum_accuracy: 0.0,
            method: Method::Automatic,
        }
    }
}
