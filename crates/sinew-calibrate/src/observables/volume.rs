//! Volume of a cavity.

use super::{Quantity, States};
use sinew_energy::Cavity;

/// Volume of a cavity in a state.
pub(crate) struct CavityVolume {
    pub cavity: Cavity,
    pub state: usize,
    /// Places of the nodes in the image.
    pub image: Vec<[f64; 3]>,
}

impl Quantity for CavityVolume {
    fn value(&self, states: &States) -> f64 {
        self.cavity.volume(&self.image, &states[self.state])
    }

    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)> {
        vec![(self.state, self.cavity.volume_gradient(&self.image, &states[self.state]))]
    }
}
