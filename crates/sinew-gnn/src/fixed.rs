//! NetworkPrediction on one geometry, whose message passing is done once.

use burn::tensor::Tensor;
use std::sync::Arc;

use crate::arrays::{numbers, parameter_tensor};
use crate::fused::Input;
use crate::map::OutputMap;
use crate::tensors::GeometryTensors;
use crate::{Error, GraphNetwork, Result, Surrogate};
use sinew_emulate::coordinates::ParameterScaling;

/// Rows (parameter sets × nodes) decoded at once: their activations of 128 columns fill a few
/// megabytes, beyond that a batch only costs memory.
const ROWS_PER_CHUNK: usize = 8192;

/// A surrogate bound to one geometry (thesis §2.4.3): the embeddings `z_local`, and their part of
/// the decoders' first layers, are computed once; a prediction is the decoder only.
#[derive(Debug, Clone)]
pub struct FixedGeometry {
    emulator: GraphNetwork,
    parameters: ParameterScaling,
    node_parts: Vec<(usize, Tensor<2>)>,
    global: Option<Tensor<2>>,
    output: Arc<OutputMap>,
}

/// Displacements for a batch of parameter sets.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkPrediction {
    /// Displacements, parameter set by set, node by node \[length\].
    pub displacement: Vec<f64>,
    /// Whether each parameter set lies outside the trained ranges, so that the prediction extrapolates.
    pub extrapolated: Vec<bool>,
    degrees_of_freedom: usize,
}

impl NetworkPrediction {
    /// Displacement of one parameter set, node by node \[length\].
    ///
    /// # Panics
    /// If there is no such set.
    pub fn field(&self, set: usize) -> &[f64] {
        &self.displacement[set * self.degrees_of_freedom..(set + 1) * self.degrees_of_freedom]
    }
}

impl FixedGeometry {
    /// Binds a surrogate to a geometry of its training, at index `known`, or to another one.
    pub(crate) fn new(
        surrogate: &Surrogate,
        known: Option<usize>,
        geometry: &GeometryTensors,
    ) -> Self {
        let emulator = surrogate.emulator.clone();
        let local = known.and_then(|index| emulator.embedding(index));
        let local = local.unwrap_or_else(|| geometry.embedding(&emulator));
        Self {
            node_parts: emulator.decoder_node_part(local),
            emulator,
            parameters: surrogate.scales.parameters.clone(),
            global: geometry.global.clone(),
            output: geometry.output.clone(),
        }
    }

    /// Displacements of a batch of parameter sets, by the decoder alone.
    ///
    /// # Errors
    /// Parameters of a wrong number, not finite, or not positive on a log scale; a prediction that is not finite.
    pub fn predict(&self, thetas: &[Vec<f64>]) -> Result<NetworkPrediction> {
        let degrees_of_freedom = self.output.dims().iter().product();
        let mut displacement: Vec<f64> = Vec::with_capacity(thetas.len() * degrees_of_freedom);
        for chunk in thetas.chunks((ROWS_PER_CHUNK / self.output.dims()[0]).max(1)) {
            let inputs = self.inputs(chunk)?;
            let nodes = self.node_parts.iter().cloned();
            let nodes = nodes.map(|(decoder, values)| (decoder, Input { values, first_row: None }));
            let output = self.emulator.decode_from(nodes, self.global.clone(), inputs.clone());
            displacement.extend(numbers(self.output.displacement(output, &inputs)));
        }
        if let Some(index) = displacement.iter().position(|value| !value.is_finite()) {
            return Err(Error::PredictionNotFinite { sample: index / degrees_of_freedom });
        }
        let extrapolated = thetas.iter().map(|theta| !self.parameters.contains(theta)).collect();
        Ok(NetworkPrediction { displacement, extrapolated, degrees_of_freedom })
    }

    /// `∂û/∂θ` at one parameter set, a field for each parameter [length per unit of the parameter], in forward mode through the decoder.
    ///
    /// # Errors
    /// As [`FixedGeometry::predict`].
    pub fn sensitivity(&self, theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        let inputs = self.inputs(&[theta.to_vec()])?;
        let (global, parts) = (self.global.clone(), &self.node_parts);
        let (output, change) = self.emulator.decode_with_tangents(parts, global, inputs.clone());
        let mut tangents = self.output.tangents(&output, &change, &inputs);
        if tangents.iter().flatten().any(|u| !u.is_finite()) {
            return Err(Error::PredictionNotFinite { sample: 0 });
        }
        for (tangent, slope) in tangents.iter_mut().zip(self.parameters.slopes(theta)) {
            tangent.iter_mut().for_each(|u| *u *= slope);
        }
        Ok(tangents)
    }

    fn inputs(&self, thetas: &[Vec<f64>]) -> Result<Tensor<2>> {
        let thetas = thetas.iter().map(Vec::as_slice);
        parameter_tensor(&self.parameters, thetas, &self.emulator.device())
    }
}
