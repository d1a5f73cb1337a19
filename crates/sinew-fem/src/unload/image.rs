//! The image: a body that was lowered on its loaded state.

use crate::elements::system::System;
use sinew_energy::{Body, Fibres};

/// The image with what is prepared once.
pub(super) struct Image<'p> {
    pub system: System<'p>,
    pub fibres: Fibres,
}

impl Image<'_> {
    /// The body at rest; `None` where a cell is inverted.
    pub(super) fn moved(&self, motion: &[f64]) -> Option<Body> {
        self.system.body.moved(motion, self.fibres)
    }

    /// Whether the law has directions that move with the tissue.
    pub(super) fn carries(&self) -> bool {
        let directed = !self.system.body.material.directions(0).is_empty();
        self.fibres == Fibres::Carried && directed
    }
}
