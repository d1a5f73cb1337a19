//! Observables as functions of the places of the nodes.

mod displacement;
mod strain;
mod volume;

pub(crate) use displacement::PointDisplacement;
pub(crate) use strain::SegmentStrain;
pub(crate) use volume::CavityVolume;

/// Displacements from the image of all states, each `3 × nodes` \[length\].
pub(crate) type States = [Vec<f64>];

/// An observable whose nodes, cells and states are known.
pub(crate) trait Quantity: Send + Sync {
    /// The value; NaN where a state is degenerate.
    fn value(&self, states: &States) -> f64;

    /// Derivatives in the places of the nodes, for each state that the value depends on.
    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)>;
}
