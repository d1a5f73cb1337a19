//! The image: a body that was lowered on its loaded state.

use super::entries::Places;
use super::error::UnloadError;
use crate::SolveError;
use crate::elements::supports::is_moved_rim;
use crate::elements::system::System;
use crate::linear::sparsity::patch_nodes_of;
use sinew_energy::{Body, Fibres};
use std::sync::Arc;

/// The image with what is prepared once.
pub(super) struct Image<'p> {
    pub system: System<'p>,
    pub places: Arc<Places>,
    /// Nodes of each patch, ascending.
    pub patch_nodes: Arc<Vec<Vec<usize>>>,
    pub fibres: Fibres,
}

impl<'p> Image<'p> {
    /// Prepares for a body.
    pub(super) fn new(system: System<'p>) -> Result<Self, UnloadError> {
        let body = system.body;
        if let Some(node) = is_moved_rim(body) {
            return Err(UnloadError::MovedRim { node });
        }
        let places = Arc::new(Places::new(&system.sparsity, body.prescribed.len()));
        let patch_nodes = body.patches.iter().map(|points| patch_nodes_of(body, points));
        let patch_nodes = Arc::new(patch_nodes.collect());
        Ok(Self { system, places, patch_nodes, fibres: Fibres::default() })
    }
}

impl<'p> Image<'p> {
    /// Another one, for another thread; it shares what is prepared.
    pub(super) fn fresh(&self) -> Result<Self, SolveError> {
        Ok(self.with(self.system.fresh()?))
    }

    /// A loaded state of the body at rest as an image of its own.
    pub(super) fn of_state<'q>(&self, seen: &'q Body) -> Result<Image<'q>, SolveError> {
        Ok(self.with(self.system_of(seen)?))
    }

    fn with<'q>(&self, system: System<'q>) -> Image<'q> {
        let (places, patch_nodes) = (self.places.clone(), self.patch_nodes.clone());
        Image { system, places, patch_nodes, fibres: self.fibres }
    }
}

impl Image<'_> {
    /// The system of a body at rest.
    pub(super) fn system_of<'q>(&self, rest: &'q Body) -> Result<System<'q>, SolveError> {
        self.system.like(rest)
    }

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
