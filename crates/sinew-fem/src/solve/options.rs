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
    /// Largest first load step, as a fraction of the load. Slender bodies start with less, by the linear model at rest.
    pub first_load_step: f64,
    /// Largest growth of a load step over the one before. The step stays the same if the last one began with a residual
    /// of 0.2, or its second iteration with 1e-2.
    pub load_step_growth: f64,
    /// Smallest load step \[relative to the load reached\] before the solve gives up; a value above `first_load_step`
    /// allows no load steps.
    pub least_load_step: f64,
    /// Residual of an equilibrium without a potential: forces \[relative to loads and reactions\] and volume changes
    /// \[relative to the body's volume\]. Minima of a potential meet it at intermediate loads, and are solved to
    /// rounding errors at the final load.
    pub accuracy: f64,
    /// Residual that is enough for a minimum of a potential; 0, the default, solves to rounding errors.
    pub minimum_accuracy: f64,
    /// Accuracy without a potential at intermediate loads.
    pub accuracy_on_the_way: f64,
    /// Method for the linear systems of a body with a potential.
    pub method: Method,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            iterations: 600,
            iterations_per_load: 40,
            load_steps: LoadSteps::WhenNeeded,
            first_load_step: 0.25,
            load_step_growth: 2.0,
            least_load_step: 1e-4,
            accuracy: 1e-10,
            minimum_accuracy: 0.0,
            accuracy_on_the_way: 1e-2,
            method: Method::Automatic,
        }
    }
}
