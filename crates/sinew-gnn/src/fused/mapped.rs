//! Displacements as a function of a network's outputs, sample by sample.

use crate::fused::host::{HostOperation, HostTensor, apply};
use burn::tensor::{DType, Tensor};
use rayon::prelude::*;
use std::fmt::Debug;
use std::sync::Arc;

/// A displacement as a function of the outputs of clusters and nodes of a sample, which are one row.
pub(crate) trait FieldMap: Debug + Send + Sync {
    /// Displacement of a sample's outputs, node by node.
    fn displacement(&self, sample: usize, outputs: &[f64]) -> Vec<f64>;

    /// Cotangent of a sample's outputs from that of its displacement. That of outputs which the row lacks comes first.
    fn pull_back(&self, sample: usize, outputs: &[f64], cotangent: &[f64]) -> Vec<f64>;
}

/// Displacements `[samples, nodes, D]` of outputs `[samples, clusters, 6]` and `[samples, nodes, D]`.
///
/// The map computes in double precision. Samples are spread over threads.
pub(crate) fn mapped(
    clusters: Option<Tensor<3>>,
    nodes: Tensor<3>,
    map: Arc<dyn FieldMap>,
) -> Tensor<3> {
    let dtype = nodes.dtype();
    let inputs = clusters.into_iter().chain([nodes]).map(|x| x.cast(DType::F32).into_dispatch());
    let displacement: Tensor<3> = apply(Mapped(map), inputs.collect());
    displacement.cast(dtype)
}

#[derive(Clone, Debug)]
struct Mapped(Arc<dyn FieldMap>);

/// Numbers of one of `samples` in each of the inputs, in a row.
fn row(inputs: &[HostTensor], sample: usize, samples: usize) -> Vec<f64> {
    let part = |input: &'_ HostTensor| {
        let length = input.values().len() / samples;
        let part = &input.values()[sample * length..(sample + 1) * length];
        part.iter().map(|value| f64::from(*value)).collect::<Vec<_>>()
    };
    inputs.iter().flat_map(part).collect()
}

impl HostOperation for Mapped {
    type Saved = Vec<HostTensor>;

    fn forward(&self, inputs: &[HostTensor], tracked: bool) -> (HostTensor, Option<Self::Saved>) {
        let shape = inputs[inputs.len() - 1].shape();
        let samples = shape[0];
        let fields = (0..samples).into_par_iter().map(|sample| {
            let displacement = self.0.displacement(sample, &row(inputs, sample, samples));
            displacement.into_iter().map(|u| u as f32).collect::<Vec<_>>()
        });
        let fields: Vec<Vec<f32>> = fields.collect();
        (HostTensor::new(fields.concat(), shape), tracked.then(|| inputs.to_vec()))
    }

    fn backward(
        &self,
        inputs: Self::Saved,
        cotangent: &[f32],
        _needed: &[bool],
    ) -> Vec<Option<Vec<f32>>> {
        let samples = inputs[0].shape()[0];
        let length = cotangent.len() / samples.max(1);
        let rows = (0..samples).into_par_iter().map(|sample| {
            let cotangent = &cotangent[sample * length..(sample + 1) * length];
            let cotangent: Vec<f64> = cotangent.iter().map(|value| f64::from(*value)).collect();
            self.0.pull_back(sample, &row(&inputs, sample, samples), &cotangent)
        });
        let rows: Vec<Vec<f64>> = rows.collect();
        let length = |input: &HostTensor| input.values().len() / samples.max(1);
        let gradient = |(number, input): (usize, &HostTensor)| {
            let after: usize = inputs[number + 1..].iter().map(length).sum();
            let part = |row: &'_ Vec<f64>| {
                let end = row.len() - after;
                row[end - length(input)..end].iter().map(|value| *value as f32).collect::<Vec<_>>()
            };
            Some(rows.iter().flat_map(part).collect())
        };
        inputs.iter().enumerate().map(gradient).collect()
    }
}
