//! Sizes of an emulator.

use crate::{Activation, Error, Result};
use serde::{Deserialize, Serialize};

/// Decoding of the embeddings of nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Decoding {
    /// The components of each real node's displacement, each by a perceptron of its own (thesis).
    #[default]
    Components,
    /// Three numbers of each real node by one perceptron and six of each virtual node by another, one per layer: for
    /// [`sinew_emulate::coordinates::Coordinates::Motions`].
    Motions {
        /// Layers of virtual nodes with a perceptron of their own, counted from the whole body down; a graph may have
        /// fewer, or further ones that the last reads too.
        layers: usize,
        /// Width of the hidden layers of these perceptrons, each of which predicts the motion of one cluster.
        width: usize,
    },
}

/// Sizes of an [`GraphNetwork`](crate::GraphNetwork), whose perceptrons have two hidden layers (thesis, Algorithm 2, §2.2.4).
///
/// The first four describe the network, the others its data. [`GraphNetworkConfig::new`] takes the
/// latter and sets the former to the thesis' values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraphNetworkConfig {
    /// Width M of node, edge and parameter embeddings.
    pub latent: usize,
    /// Number K of message-passing steps.
    pub steps: usize,
    /// Width of the hidden layers.
    pub width: usize,
    /// Nonlinearity of the hidden layers.
    pub activation: Activation,
    /// Dimension D of the body: one decoder per displacement component.
    pub dimensions: usize,
    /// Features per node.
    pub node_features: usize,
    /// Features per edge.
    pub edge_features: usize,
    /// Number of material, load or other parameters θ.
    pub parameters: usize,
    /// Length of the embedding of the global shape, `z_global`; zero where there is one geometry.
    pub global_features: usize,
    /// Decoding of the embeddings.
    pub decoding: Decoding,
}

impl GraphNetworkConfig {
    /// The thesis' network (M = 40, K = 5, two hidden layers of 128, CELU) for `dimensions`
    /// displacement components and `parameters` parameters, without an embedding of the global shape.
    pub fn new(
        dimensions: usize,
        node_features: usize,
        edge_features: usize,
        parameters: usize,
    ) -> Self {
        Self {
            latent: 40,
            steps: 5,
            width: 128,
            activation: Activation::Celu,
            dimensions,
            node_features,
            edge_features,
            parameters,
            global_features: 0,
            decoding: Decoding::Components,
        }
    }

    /// Requires that all sizes are at least one.
    ///
    /// # Errors
    /// [`Error::Configuration`] naming the size.
    pub(crate) fn check(&self) -> Result<()> {
        let mut sizes = vec![
            ("latent", self.latent),
            ("width", self.width),
            ("dimensions", self.dimensions),
            ("node_features", self.node_features),
            ("edge_features", self.edge_features),
            ("parameters", self.parameters),
        ];
        if let Decoding::Motions { layers, width } = self.decoding {
            sizes.extend([("layers of virtual nodes", layers), ("width of their decoders", width)]);
        }
        match sizes.into_iter().find(|(_, value)| *value == 0) {
            None => Ok(()),
            Some((what, value)) => Err(Error::Configuration { what, value }),
        }
    }
}
