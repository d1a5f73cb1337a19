//! Options of the search for a body at rest.

use crate::Options;

/// Options of the search for a body at rest and of its check.
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
    /// Options of the check that loading from rest leads to the image, see [`crate::Loading`]. `None` skips it, where the body at rest is a
    /// neighbour of one that was checked; whether the image is a stable equilibrium is checked in either case.
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
