//! Predictions on one geometry, whose message passing is done once.

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

    /// Displacement at each of some parameter sets, node by node \[length\], by the decoder alone.
    ///
    /// # Errors
    /// Parameters of a wrong number, not finite, or not positive on a log scale; a prediction that is not finite.
    pub fn predict(&self, thetas: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let [nodes, dimensions] = self.output.dims();
        let mut fields: Vec<Vec<f64>> = Vec::with_capacity(thetas.len());
        for chunk in thetas.chunks((ROWS_PER_CHUNK / nodes).max(1)) {
            let inputs = self.inputs(chunk)?;
            let parts = self.node_parts.iter().cloned();
            let parts = parts.map(|(decoder, values)| (decoder, Input { values, first_row: None }));
            let outputs = self.emulator.decode_from(parts, self.global.clone(), inputs.clone());
            let displacements = numbers(self.output.displacement(outputs, &inputs));
            fields.extend(displacements.chunks(nodes * dimensions).map(<[f64]>::to_vec));
        }
        match fields.iter().position(|field| field.iter().any(|u| !u.is_finite())) {
            Some(sample) => Err(Error::PredictionNotFinite { sample }),
            None => Ok(fields),
        }
    }

    /// `∂û/∂θ` at one parameter set, a field for each parameter [length per unit of the parameter], in forward mode through the decoder.
    ///
    /// # Errors
    /// As [`FixedGeometry::predict`].
    pub fn sensitivity(&self, theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        let inputs = self.inputs(&[theta.to_vec()])?;
        let (global, parts) = (self.global.clone(), &self.node_parts);
        let (outputs, changes) = self.emulator.decode_with_tangents(parts, global, inputs.clone());
        let mut tangents = self.output.tangents(outputs, &changes, inputs);
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
