//! Map from the outputs of a network to displacements.

use std::sync::Arc;

use burn::tensor::{DType, Tensor};
use rayon::prelude::*;
use sinew_emulate::coordinates::{Coordinates, OutputScale};

use crate::arrays::numbers;
use crate::fused::{Cotangents, HostTensor, Pullback, apply};
use crate::{Geometry, Output};

/// Map from network outputs to displacements of one geometry, prescribed ones written over them, in double precision.
///
/// Outputs of a sample are a row: those of clusters, then those of nodes. The Taylor polynomial of the coordinates is added to them.
#[derive(Debug)]
pub(crate) struct OutputMap {
    coordinates: Coordinates,
    /// Displacement of a unit output of each degree of freedom, where outputs are components of the displacement.
    scale: Vec<f64>,
    /// Displacement of zero outputs.
    origin: Vec<f64>,
    /// Displacement of supports, and the rows of the projectors on what they leave free.
    held: Vec<f64>,
    projectors: Vec<f64>,
    dimensions: usize,
}

impl OutputMap {
    pub(crate) fn new(geometry: &Geometry, scales: &OutputScale, dimensions: usize) -> Self {
        let (coordinates, dirichlet) = (geometry.coordinates.clone(), &geometry.dirichlet);
        let degrees_of_freedom = dirichlet.prescribed.len();
        // Per component or per degree of freedom.
        let field =
            |values: &[f64]| values.iter().copied().cycle().take(degrees_of_freedom).collect();
        Self {
            scale: field(&scales.scale),
            origin: field(coordinates.origin().unwrap_or(&scales.mean)),
            held: dirichlet.held(dimensions),
            projectors: dirichlet.projectors(dimensions),
            coordinates,
            dimensions,
        }
    }

    /// Nodes and components of a displacement.
    pub(crate) fn dims(&self) -> [usize; 2] {
        [self.origin.len() / self.dimensions, self.dimensions]
    }

    /// Displacements `[batch, real nodes, D]` of a network's outputs at standardised parameters, one row per sample, as one operation in double
    /// precision. Samples are spread over threads.
    pub(crate) fn displacement(
        self: &Arc<Self>,
        output: Output,
        parameters: &Tensor<2>,
    ) -> Tensor<3> {
        let samples = parameters.dims()[0];
        let parameters = numbers(parameters.clone());
        let parameters = (0..samples).map(|sample| row(&[&parameters[..]], sample, samples));
        let parameters: Arc<[Vec<f64>]> = parameters.collect();
        let (map, dtype) = (self.clone(), output.nodes.dtype());
        let inputs = output.clusters.into_iter().chain([output.nodes]);
        let inputs = inputs.map(|x| x.cast(DType::F32).into_dispatch()).collect();
        let operation = move |inputs: &[HostTensor], _: bool| {
            let values: Vec<_> = inputs.iter().map(HostTensor::values).collect();
            let fields = parameters.par_iter().enumerate().map(|(sample, parameters)| {
                let outputs = row(&values, sample, samples);
                map.field(&outputs, parameters).map(|u| u as f32).collect::<Vec<_>>()
            });
            let fields: Vec<Vec<f32>> = fields.collect();
            let output = HostTensor::new(fields.concat(), inputs[inputs.len() - 1].shape());
            let (map, parameters, inputs) = (map.clone(), parameters.clone(), inputs.to_vec());
            let pullback =
                Pullback::new(move |cotangent, _| map.cotangents(&parameters, &inputs, cotangent));
            (output, pullback)
        };
        apply::<3>(inputs, operation).cast(dtype)
    }

    /// Displacements where a network adds nothing.
    pub(crate) fn without_network(self: &Arc<Self>, parameters: &Tensor<2>) -> Tensor<3> {
        let ([nodes, dimensions], [samples, _]) = (self.dims(), parameters.dims());
        let nodes = Tensor::zeros([samples, nodes, dimensions], &parameters.device());
        self.displacement(Output { nodes, clusters: None }, parameters)
    }

    /// Derivative of the displacement in each standardised parameter, from a network's outputs at one parameter set and their derivatives.
    pub(crate) fn tangents(
        &self,
        output: &Output,
        change: &Output,
        parameters: &Tensor<2>,
    ) -> Vec<Vec<f64>> {
        let at = &numbers(parameters.clone())[..];
        let outputs = self.completed(&rows(output, 1)[0], at, None);
        let tangent = |(parameter, change): (usize, Vec<f64>)| {
            let mut direction = vec![0.0; at.len()];
            direction[parameter] = 1.0;
            let along = Some(&direction[..]);
            let change = self.completed(&change, at, along);
            let mut tangent = match &self.coordinates {
                Coordinates::Motions(motions) => motions.tree().tangent(&outputs, &change),
                _ => self.moved(&change),
            };
            self.add_anchors(&mut tangent, at, along);
            self.project(&tangent)
        };
        rows(change, at.len()).into_iter().enumerate().map(tangent).collect()
    }

    /// A network's outputs and the polynomial's, or their derivatives along a direction of the parameters.
    fn completed(&self, outputs: &[f64], parameters: &[f64], along: Option<&[f64]>) -> Vec<f64> {
        let mut completed = self.coordinates.expansion(parameters, along);
        let of_clusters = match &self.coordinates {
            Coordinates::Motions(motions) => motions.tree().of_clusters(),
            Coordinates::Components | Coordinates::Principal(_) => 0,
        };
        completed.resize(of_clusters + self.origin.len(), 0.0);
        // Without outputs of clusters, these follow the polynomial.
        let first = completed.len() - outputs.len();
        completed[first..].iter_mut().zip(outputs).for_each(|(sum, y)| *sum += y);
        completed
    }

    /// Displacement of completed outputs beyond that of zero outputs.
    fn moved(&self, outputs: &[f64]) -> Vec<f64> {
        match &self.coordinates {
            Coordinates::Components => scaled(outputs, &self.scale),
            Coordinates::Principal(directions) => directions.moved(outputs),
            Coordinates::Motions(motions) => motions.tree().moved(outputs),
        }
    }

    /// Adds the displacement of further solved states, or its change along a direction. It is a constant of a training: nothing is
    /// learned through it.
    fn add_anchors(&self, displacement: &mut [f64], parameters: &[f64], along: Option<&[f64]>) {
        if let Some(anchors) = self.coordinates.anchors() {
            // A surrogate is assembled with as many parameters as its anchors have.
            let added = anchors.at_parameters(parameters, along);
            let added = added.unwrap_or_else(|_| vec![f64::NAN; displacement.len()]);
            displacement.iter_mut().zip(added).for_each(|(u, added)| *u += added);
        }
    }

    /// Part of a displacement that supports leave free. Projectors are symmetric: they pull cotangents back as well.
    fn project(&self, displacement: &[f64]) -> Vec<f64> {
        let rows = self.projectors.chunks_exact(self.dimensions).enumerate();
        let entry = |(dof, row): (usize, &[f64])| {
            let node = dof / self.dimensions * self.dimensions;
            row.iter().zip(&displacement[node..]).map(|(q, u)| q * u).sum()
        };
        rows.map(entry).collect()
    }

    /// Displacement of a sample's outputs, node by node.
    fn field(&self, outputs: &[f64], parameters: &[f64]) -> impl Iterator<Item = f64> {
        let mut displacement = self.moved(&self.completed(outputs, parameters, None));
        self.add_anchors(&mut displacement, parameters, None);
        displacement.iter_mut().zip(&self.origin).for_each(|(u, origin)| *u += origin);
        self.project(&displacement).into_iter().zip(&self.held).map(|(free, held)| free + held)
    }

    /// Cotangent of a sample's outputs from that of its displacement. That of outputs which the row lacks comes first.
    fn pull_back(&self, outputs: &[f64], parameters: &[f64], cotangent: &[f64]) -> Vec<f64> {
        let free = self.project(cotangent);
        match &self.coordinates {
            Coordinates::Components => scaled(&free, &self.scale),
            Coordinates::Principal(directions) => directions.pull_back(&free),
            Coordinates::Motions(motions) => {
                let outputs = self.completed(outputs, parameters, None);
                motions.tree().pull_back(&outputs, &free)
            }
        }
    }

    /// Cotangents of all samples' outputs.
    fn cotangents(
        &self,
        parameters: &[Vec<f64>],
        inputs: &[HostTensor],
        cotangent: &[f32],
    ) -> Cotangents {
        let samples = parameters.len();
        let values: Vec<_> = inputs.iter().map(HostTensor::values).collect();
        let rows = parameters.par_iter().enumerate().map(|(sample, parameters)| {
            let cotangent = row(&[cotangent], sample, samples);
            self.pull_back(&row(&values, sample, samples), parameters, &cotangent)
        });
        let rows: Vec<Vec<f64>> = rows.collect();
        let mut after = 0;
        let gradient = |values: &&[f32]| {
            let length = values.len() / samples.max(1);
            after += length;
            let part = |row: &Vec<f64>| {
                let from = row.len() - after;
                row[from..from + length].iter().map(|value| *value as f32).collect::<Vec<_>>()
            };
            Some(rows.iter().flat_map(part).collect())
        };
        // The last outputs end the rows.
        let mut gradients: Cotangents = values.iter().rev().map(gradient).collect();
        gradients.reverse();
        gradients
    }
}

fn scaled(values: &[f64], scale: &[f64]) -> Vec<f64> {
    values.iter().zip(scale).map(|(value, scale)| value * scale).collect()
}

/// Outputs of clusters and then of nodes, a row for each sample.
fn rows(output: &Output, samples: usize) -> Vec<Vec<f64>> {
    let parts = output.clusters.iter().chain([&output.nodes]);
    let parts: Vec<_> = parts.cloned().map(numbers).collect();
    let parts: Vec<_> = parts.iter().map(Vec::as_slice).collect();
    (0..samples).map(|sample| row(&parts, sample, samples)).collect()
}

/// Numbers of one of `samples` in each of the parts, in a row.
fn row<T: Copy + Into<f64>>(parts: &[&[T]], sample: usize, samples: usize) -> Vec<f64> {
    let of_sample = |part: &&[T]| {
        let length = part.len() / samples;
        let values = part[sample * length..(sample + 1) * length].iter();
        values.map(|&value| value.into()).collect::<Vec<f64>>()
    };
    parts.iter().flat_map(of_sample).collect()
}
