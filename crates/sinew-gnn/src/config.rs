//! Sizes of an emulator.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Nonlinearity of every hidden layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Continuously differentiable exponential linear unit, `max(0, x) + min(0, eˣ − 1)` (thesis, chapter 3).
    #[default]
    Celu,
    /// Hyperbolic tangent (thesis, chapter 2).
    Tanh,
}

/// What an emulator reads from the embeddings of nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Decoding {
    /// The components of each real node's displacement, each by a perceptron of its own (thesis).
    #[default]
    Components,
    /// Three numbers of each real node by one perceptron and six of each virtual node by another, one per layer: for
    /// [`crate::Coordinates::Motions`].
    Motions {
        /// Layers of virtual nodes with a perceptron of their own, counted from the whole body down; a graph may have
        /// fewer, or further ones that the last reads too.
        layers: usize,
        /// Width of the hidden layers of these perceptrons, which have one motion of a whole cluster to tell.
        width: usize,
    },
}

/// Sizes of an [`Emulator`](crate::Emulator) (thesis, Algorithm 2, §2.2.4).
///
/// The first six describe the network, the others its data. [`EmulatorConfig::new`] takes the
/// latter and sets the former to the thesis' values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct EmulatorConfig {
    /// Width M of node, edge and parameter embeddings.
    pub latent: usize,
    /// Number K of message-passing steps.
    pub steps: usize,
    /// Width of the hidden layers.
    pub width: usize,
    /// Number of hidden layers of every perceptron.
    pub hidden_layers: usize,
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
    /// What is read from the embeddings.
    pub decoding: Decoding,
}

impl EmulatorConfig {
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
            hidden_layers: 2,
            activation: Activation::Celu,
            dimensions,
            node_features,
            edge_features,
            parameters,
            global_features: 0,
            decoding: Decoding::Components,
        }
    }

    /// Requires every size a network cannot do without.
    ///
    /// # Errors
    /// [`Error::Configuration`] naming the size.
    pub(crate) fn check(&self) -> Result<()> {
        let positive = [
            ("latent", self.latent),
            ("width", self.width),
            ("hidden_layers", self.hidden_layers),
            ("dimensions", self.dimensions),
            ("node_features", self.node_features),
            ("edge_features", self.edge_features),
            ("parameters", self.parameters),
        ];
        let layers = match self.decoding {
            Decoding::Components => vec![],
            Decoding::Motions { layers, width } => {
                vec![("layers of virtual nodes", layers), ("width of their decoders", width)]
            }
        };
        match positive.into_iter().chain(layers).find(|(_, value)| *value == 0) {
            None => Ok(()),
            Some((what, value)) => Err(Error::Configuration { what, value, minimum: 1 }),
        }
    }

    /// Layer widths of a perceptron from `inputs` to `outputs`, with hidden layers of `width`.
    pub(crate) fn layer_sizes(&self, [inputs, width, outputs]: [usize; 3]) -> Vec<usize> {
        let mut sizes = vec![inputs];
        sizes.extend(std::iter::repeat_n(width, self.hidden_layers));
        sizes.push(outputs);
        sizes
    }
}
