//! How a body at rest is searched.

use crate::Options;

/// How a body at rest is searched and checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnloadOptions {
    /// Most Newton iterations, all load steps together.
    pub iterations: usize,
    /// Most of them at one load.
    pub iterations_per_load: usize,
    /// Smallest load step before the search gives up [part of the load].
    pub least_load_step: f64,
    /// Unbalanced forces that are enough \[relative to loads and reactions\]; 0, the default, is what rounding errors amount to.
    pub accuracy: f64,
    /// Whether the body at rest is loaded from rest to see that it comes to the image, beside the check that the image is one of its
    /// stable equilibria. `None` saves that solve, where the body at rest is a neighbour of one that was loaded.
    pub load: Option<Options>,
}

impl Default for UnloadOptions {
    fn default() -> Self {
        Self {
            iterations: 300,
            iterations_per_load: 25,
            least_load_step: 1e-3,
            accuracy: 0.0,
            load: Some(Options::default()),
        }
    }
}
