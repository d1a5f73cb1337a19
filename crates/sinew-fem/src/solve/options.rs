//! Limits and accuracy of a solve.

/// When loads are raised step by step.
#[doc(alias("load increment", "load stepping"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoadSteps {
    /// Only where the whole load at once fails, which takes the fewest iterations. A body with several stable equilibria comes to one of them.
    #[default]
    WhenNeeded,
    /// Always, from rest: the equilibrium that the body comes to under a load that rises slowly, until it snaps. States to start from are not
    /// read.
    Always,
}

/// Limits and accuracy of a solve, and how loads are raised where the whole at once fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most states that are assembled, all load steps together. Hard bodies take a few hundred.
    pub iterations: usize,
    /// Most of them at one load: searches that succeed take fewer, and beyond them smaller load steps are cheaper.
    pub iterations_per_load: usize,
    /// When loads are raised step by step: for bodies with several stable equilibria.
    pub load_steps: LoadSteps,
    /// Largest first load step, as a fraction of the load. Slender bodies start with less, by the linear model at rest.
    pub first_load_step: f64,
    /// Most that a load step may be longer than the one before. It is as long where that began a fifth of the forces away
    /// from equilibrium, or its second iteration a thousandth.
    pub load_step_growth: f64,
    /// Smallest load step before the solve gives up, relative to the load that was reached; above the first load step
    /// none is tried.
    pub least_load_step: f64,
    /// Unbalanced forces \[relative to loads and reactions\] and changes of volume \[relative to the body's\] of an
    /// equilibrium without a potential, where the accuracy of linear systems bounds what can be had. Minima of a
    /// potential have it on the way to another load, and go down to what rounding errors amount to in the end.
    pub accuracy: f64,
    /// Unbalanced forces that are enough for a minimum of a potential; 0, the default, is what rounding errors amount to.
    pub minimum_accuracy: f64,
    /// Accuracy without a potential on the way to another load, where only the next step starts.
    pub accuracy_on_the_way: f64,
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
        }
    }
}
