//! The network of thesis Algorithm 2.

use crate::fused::{
    GatherPlan, Input, concatenated, normalised, received_edge_sum, selected, signed_edge_sum, sum,
};
use crate::perceptron::{Initialiser, Normalisation, Perceptron};
use crate::{Decoding, Graph, GraphNetworkConfig, Result};
use burn::module::{Module, Param, ParamId};
use burn::tensor::{Device, Tensor};

/// Embeddings of the nodes of a geometry that are decoded, `[nodes, 2 M]`, layer by layer.
pub type Embedding = Vec<Tensor<2>>;

/// DeepGraphEmulator, thesis Algorithm 2: encode nodes and edges, pass messages, decode each
/// displacement component from the embeddings of parameters, global shape and node.
///
/// Node embeddings sum the stored edges a node *receives*, not those of all its neighbours.
/// Inputs are standardised and outputs are standardised displacements; [`crate::Surrogate`]
/// adds units, supports and parameter scales.
#[doc(alias("MeshGraphNet", "GNN", "message passing"))]
#[derive(Module, Debug)]
pub struct GraphNetwork {
    node_encoder: Perceptron,
    edge_encoder: Perceptron,
    edge_updates: Vec<Perceptron>,
    node_updates: Vec<Perceptron>,
    local_normalisation: Normalisation,
    parameter_encoder: Perceptron,
    decoders: Vec<Perceptron>,
    /// Embeddings of the geometries trained on, layer by layer, where they are weights of their own.
    embeddings: Vec<Vec<Param<Tensor<2>>>>,
    /// Sizes of this network.
    #[module(skip)]
    pub(crate) config: GraphNetworkConfig,
}

/// Numbers of a rigid motion in space.
const MOTION: usize = 6;

impl GraphNetwork {
    /// Untrained weights drawn from `seed`; the same seed gives the same weights on every
    /// device. Its first predictions are zero.
    ///
    /// # Errors
    /// [`crate::Error::Configuration`] if a size is zero.
    pub fn new(config: &GraphNetworkConfig, seed: u64, device: &Device) -> Result<Self> {
        config.check()?;
        let source = &mut Initialiser::new(seed, device);
        let latent = config.latent;
        let mut normalised = |inputs| Perceptron::normalised(source, config, inputs);
        let node_encoder = normalised(config.node_features);
        let edge_encoder = normalised(config.edge_features);
        let edge_updates = (0..config.steps).map(|_| normalised(3 * latent)).collect();
        let node_updates = (0..config.steps).map(|_| normalised(2 * latent)).collect();
        let parameter_encoder = normalised(config.parameters);
        let local_normalisation = Normalisation::new(source, 2 * latent);
        let inputs = 3 * latent + config.global_features;
        let mut decoder = |width, outputs| {
            Perceptron::decoder(source, config.activation, [inputs, width, outputs])
        };
        let decoders = match config.decoding {
            Decoding::Components => {
                (0..config.dimensions).map(|_| decoder(config.width, 1)).collect()
            }
            Decoding::Motions { layers, width } => {
                let of_nodes = decoder(config.width, config.dimensions);
                let of_clusters = (0..layers).map(|_| decoder(width, MOTION));
                std::iter::once(of_nodes).chain(of_clusters).collect()
            }
        };
        Ok(Self {
            node_encoder,
            edge_encoder,
            edge_updates,
            node_updates,
            local_normalisation,
            parameter_encoder,
            decoders,
            embeddings: Vec::new(),
            config: config.clone(),
        })
    }

    /// Network whose embeddings of each geometry no longer come from message passing, but are weights to
    /// be trained themselves.
    pub(crate) fn with_embeddings(mut self, embeddings: Vec<Embedding>) -> Self {
        /// Beyond the identities of all other parameters.
        const FIRST_ID: u64 = 1 << 32;
        let mut ids = FIRST_ID..;
        let mut weight = |layer: Tensor<2>| {
            let id = ids.next().expect("more identities than memory");
            Param::initialized(ParamId::from(id), layer).set_require_grad(true)
        };
        let weights = |layers: Embedding| layers.into_iter().map(&mut weight).collect();
        self.embeddings = embeddings.into_iter().map(weights).collect();
        self
    }

    /// The embeddings of a geometry that are weights; `None` where they come from message passing.
    pub(crate) fn embedding(&self, geometry: usize) -> Option<Embedding> {
        Some(self.embeddings.get(geometry)?.iter().map(Param::val).collect())
    }

    /// Device of the weights.
    pub(crate) fn device(&self) -> Device {
        self.decoders[0].layers[0].bias.device()
    }

    /// Data among the weights: on a device that records gradients, if these are.
    pub(crate) fn lifted(&self, data: &Tensor<2>) -> Tensor<2> {
        match self.device().is_autodiff() {
            true => Tensor::from_inner(data.clone()),
            false => data.clone(),
        }
    }

    /// Rows of the embeddings that are weights, layer by layer of every geometry.
    pub(crate) fn embedded_nodes(&self) -> Vec<Vec<usize>> {
        let geometries = self.embeddings.iter();
        geometries.map(|layers| layers.iter().map(|layer| layer.dims()[0]).collect()).collect()
    }

    /// Steps 1 to 3 of the algorithm: embeddings `z_local` of the nodes that are decoded, `[nodes, 2 M]`, layer by
    /// layer: the real nodes, and where virtual ones are decoded these.
    ///
    /// `nodes` and `edges` hold standardised features, one row per node (virtual ones included)
    /// and per stored edge.
    pub fn local_embedding(&self, graph: &Graph, nodes: Tensor<2>, edges: Tensor<2>) -> Embedding {
        let aligned = GatherPlan::identity(graph.edges.size()[0], 2);
        let latent = self.config.latent;
        let ([of_nodes, of_edges], [mut plan, later]) = (&graph.kinds, graph.plans.each_ref());
        // What messages read: first a row of each kind.
        let mut read = [self.node_encoder.forward(nodes), self.edge_encoder.forward(edges)];
        let [mut nodes, mut edges] = read.clone();
        (nodes, edges) = (selected(nodes, of_nodes), selected(edges, of_edges));
        for (edge_update, node_update) in self.edge_updates.iter().zip(&self.node_updates) {
            // Messages of the stored edges (2.28), functions of `[e, v_receiver, v_sender]`.
            let end = |start: usize| features(read[0].clone(), start);
            let inputs = vec![features(read[1].clone(), 0), end(latent), end(2 * latent)];
            let messages = selected(edge_update.evaluate(inputs, &plan.0), &plan.1);
            // Received minus sent ones (2.27).
            let sums = signed_edge_sum(messages.clone(), &graph.edges);
            let inputs = vec![features(nodes.clone(), 0), features(sums, latent)];
            let update = node_update.evaluate(inputs, &aligned);
            nodes = sum(nodes, update);
            edges = sum(edges, messages);
            (read, plan) = ([nodes.clone(), edges.clone()], later);
        }
        let local = concatenated(vec![nodes, received_edge_sum(edges, &graph.edges)], 1);
        let layers = match self.config.decoding {
            Decoding::Components => &graph.layers[..1],
            Decoding::Motions { .. } => &graph.layers[..],
        };
        let decoded = local.slice_dim(0, 0..layers[layers.len() - 1].end);
        let decoded = normalised(decoded, self.local_normalisation.fused());
        layers.iter().map(|rows| decoded.clone().slice_dim(0, rows.clone())).collect()
    }

    /// Parts that are decoded: the index of a decoder, and the embeddings that it reads.
    ///
    /// Layers of virtual nodes are counted from the whole body down: the same decoder reads the largest clusters of every
    /// graph. Layers beyond the network's decoders are read by the last of them.
    fn decoded(&self, local: Embedding) -> Vec<(usize, Tensor<2>)> {
        match self.config.decoding {
            Decoding::Components => {
                (0..self.decoders.len()).map(|d| (d, local[0].clone())).collect()
            }
            Decoding::Motions { layers, .. } => {
                let finest = local.len() - 1;
                let decoder = |layer: usize| match layer {
                    0 => 0,
                    layer => (layer + layers).saturating_sub(finest).max(1),
                };
                (0..local.len()).map(decoder).zip(local).collect()
            }
        }
    }

    /// Part of the decoders' first layers that depends on the nodes only: the index of a decoder and `[nodes it reads,
    /// width]` each.
    pub(crate) fn decoder_node_part(&self, local: Embedding) -> Vec<(usize, Tensor<2>)> {
        let start = self.config.latent + self.config.global_features;
        let parts = self.decoded(local).into_iter();
        parts.map(|(d, local)| (d, self.decoders[d].layers[0].partial(local, start))).collect()
    }

    /// Step 4 for a batch of parameter sets on one geometry: a row of outputs for each, those of clusters, where they are decoded, and
    /// then those of nodes.
    ///
    /// * `local`: from [`GraphNetwork::local_embedding`].
    /// * `global`: `[1, global features]`, standardised; `None` exactly where there are none.
    /// * `parameters`: `[batch, parameters]`, standardised.
    pub(crate) fn decode(
        &self,
        local: Embedding,
        global: Option<Tensor<2>>,
        parameters: Tensor<2>,
    ) -> Tensor<2> {
        let start = self.config.latent + self.config.global_features;
        let decoded = self.decoded(local).into_iter();
        self.decode_from(decoded.map(|(d, local)| (d, features(local, start))), global, parameters)
    }

    /// [`GraphNetwork::decode`] from inputs of nodes, each with the index of its decoder.
    pub(crate) fn decode_from(
        &self,
        nodes: impl Iterator<Item = (usize, Input)>,
        global: Option<Tensor<2>>,
        parameters: Tensor<2>,
    ) -> Tensor<2> {
        let (latent, batch) = (self.config.latent, parameters.dims()[0]);
        let embedding = self.parameter_encoder.forward(parameters);
        let parts = nodes.map(|(decoder, nodes)| {
            let (decoder, count) = (&self.decoders[decoder], nodes.values.dims()[0]);
            // All pairs of nodes and parameter sets, each with the one row of the global shape.
            let (mut plan, mut inputs) =
                (GatherPlan::outer(batch, count), vec![nodes, features(embedding.clone(), 0)]);
            if let Some(global) = global.clone() {
                plan = plan.and_shared();
                inputs.push(features(global, latent));
            }
            let rows = decoder.evaluate(inputs, &plan);
            let outputs = rows.dims()[1];
            rows.reshape([batch, count, outputs])
        });
        self.in_rows(parts.collect())
    }

    /// Outputs of all decoders, `[batch, nodes it reads, numbers]` in their order, as a row for each parameter set.
    fn in_rows(&self, mut parts: Vec<Tensor<3>>) -> Tensor<2> {
        if self.config.decoding == Decoding::Components {
            return concatenated(parts, 2).flatten(1, 2);
        }
        let nodes = parts.remove(0).flatten(1, 2);
        match parts.is_empty() {
            true => nodes,
            false => concatenated(vec![concatenated(parts, 1).flatten(1, 2), nodes], 1),
        }
    }

    /// Outputs at one parameter set `[1, parameters]`, and their derivatives with respect to the standardised parameters in forward mode, a row
    /// for each.
    pub(crate) fn decode_with_tangents(
        &self,
        node_parts: &[(usize, Tensor<2>)],
        global: Option<Tensor<2>>,
        parameters: Tensor<2>,
    ) -> (Tensor<2>, Tensor<2>) {
        let (latent, count) = (self.config.latent, parameters.dims()[1]);
        let encoder = &self.parameter_encoder;
        let (first, tangent) =
            (encoder.layers[0].forward(parameters), encoder.layers[0].weight.val());
        let (embedding, tangent) = encoder.continue_with_tangent(first, tangent);
        let parts = node_parts.iter().map(|(decoder, node_part)| {
            let (decoder, [nodes, width]) = (&self.decoders[*decoder], node_part.dims());
            let layer = &decoder.layers[0];
            // The part that all nodes share, `[1, width]`.
            let mut shared = layer.partial(embedding.clone(), 0);
            if let Some(global) = &global {
                shared = shared + layer.partial(global.clone(), latent);
            }
            let first = node_part.clone() + shared + layer.bias.val().unsqueeze();
            let tangent = layer.partial(tangent.clone(), 0).reshape([count, 1, width]);
            let tangent = tangent.expand([count, nodes, width]).reshape([count * nodes, width]);
            let (value, tangent) = decoder.continue_with_tangent(first, tangent);
            let outputs = value.dims()[1];
            (value.reshape([1, nodes, outputs]), tangent.reshape([count, nodes, outputs]))
        });
        let (values, tangents) = parts.unzip();
        (self.in_rows(values), self.in_rows(tangents))
    }
}

/// A part of a perceptron's input that meets the rows of its first weight from `first_row` on.
fn features(values: Tensor<2>, first_row: usize) -> Input {
    Input { values, first_row: Some(first_row) }
}
