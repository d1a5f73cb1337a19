//! Numbers as tensors, a geometry as tensors, and a network's outputs as displacements.

use crate::error::Result;
use crate::fused::{HostTensor, Index, Pullback, apply, selected};
use crate::{Embedding, Geometry, Graph, GraphNetwork};
use burn::tensor::{DType, Device, Tensor, TensorData};
use rayon::prelude::*;
use sinew_emulate::coordinates::{Coordinates, OutputScale, ParameterScaling};
use std::sync::Arc;

/// Map from network outputs to displacements of one geometry, prescribed ones written over them, in double precision.
///
/// Outputs of a sample are a row: those of clusters, then those of nodes that supports leave free. The Taylor polynomial of the coordinates is
/// added to them.
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
    /// Nodes that are decoded: those that are free in some direction.
    free: Arc<Index>,
    /// Places of a network's outputs among those of all clusters and nodes.
    places: Vec<usize>,
}

impl OutputMap {
    pub(crate) fn new(geometry: &Geometry, scales: &OutputScale, dimensions: usize) -> Self {
        let (coordinates, dirichlet) = (geometry.coordinates.clone(), &geometry.dirichlet);
        let degrees_of_freedom = dirichlet.prescribed.len();
        // Per component or per degree of freedom.
        let field =
            |values: &[f64]| values.iter().copied().cycle().take(degrees_of_freedom).collect();
        let nodes = dirichlet.prescribed.chunks(dimensions).enumerate();
        let free = nodes.clone().filter(|(_, node)| node.iter().any(Option::is_none));
        let free: Vec<usize> = free.map(|(node, _)| node).collect();
        let of_clusters = match &coordinates {
            Coordinates::Motions(motions) => motions.tree().of_clusters(),
            Coordinates::Components | Coordinates::Principal(_) => 0,
        };
        let of_node = |node| (0..dimensions).map(move |i| of_clusters + node * dimensions + i);
        Self {
            places: (0..of_clusters).chain(free.iter().flat_map(of_node)).collect(),
            free: Index::new(&free, nodes.len()).into(),
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

    /// Embeddings of the nodes that are decoded.
    pub(crate) fn decoded(&self, mut local: Embedding) -> Embedding {
        local[0] = selected(local[0].clone(), &self.free);
        local
    }

    /// Displacements `[batch, real nodes, D]` of a network's outputs at standardised parameters, one row per sample, as one operation in double
    /// precision. Samples are spread over threads.
    pub(crate) fn displacement(
        self: &Arc<Self>,
        outputs: Tensor<2>,
        parameters: &Tensor<2>,
    ) -> Tensor<3> {
        let ([samples, width], dtype) = (outputs.dims(), outputs.dtype());
        let [nodes, dimensions] = self.dims();
        let (map, parameters) = (self.clone(), Arc::new(rows(parameters)));
        let operation = move |inputs: &[HostTensor], _: bool| {
            let outputs = inputs[0].clone();
            let of_samples = parameters.par_iter().zip(outputs.values().par_chunks_exact(width));
            let field = |(parameters, outputs): (&Vec<f64>, &[f32])| {
                map.field(&doubled(outputs), parameters).map(|u| u as f32).collect::<Vec<_>>()
            };
            let fields: Vec<_> = of_samples.map(field).collect();
            let fields = HostTensor::new(fields.concat(), [samples, nodes, dimensions]);
            let (map, parameters) = (map.clone(), parameters.clone());
            let pullback = Pullback::new(move |cotangent, _| {
                let outputs = outputs.values().par_chunks_exact(width);
                let cotangents = cotangent.par_chunks_exact(nodes * dimensions);
                let pulled = |((parameters, outputs), cotangent): ((&Vec<f64>, _), _)| {
                    let pulled = map.pull_back(&doubled(outputs), parameters, &doubled(cotangent));
                    pulled.into_iter().map(|c| c as f32).collect::<Vec<_>>()
                };
                let all: Vec<_> =
                    parameters.par_iter().zip(outputs).zip(cotangents).map(pulled).collect();
                vec![Some(all.concat())]
            });
            (fields, pullback)
        };
        apply::<3>(vec![outputs.cast(DType::F32).into_dispatch()], operation).cast(dtype)
    }

    /// Displacements where a network adds nothing.
    pub(crate) fn without_network(self: &Arc<Self>, parameters: &Tensor<2>) -> Tensor<3> {
        let outputs = [parameters.dims()[0], self.places.len()];
        self.displacement(Tensor::zeros(outputs, &parameters.device()), parameters)
    }

    /// Derivative of the displacement in each standardised parameter, from a network's outputs at one parameter set and their derivatives.
    pub(crate) fn tangents(
        &self,
        outputs: Tensor<2>,
        changes: &Tensor<2>,
        parameters: Tensor<2>,
    ) -> Vec<Vec<f64>> {
        let at = &numbers(parameters)[..];
        let outputs = self.completed(&numbers(outputs), at, None);
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
        rows(changes).into_iter().enumerate().map(tangent).collect()
    }

    /// A network's outputs and the polynomial's of all clusters and nodes, or their derivatives along a direction of the parameters.
    fn completed(&self, outputs: &[f64], parameters: &[f64], along: Option<&[f64]>) -> Vec<f64> {
        let mut completed = self.coordinates.expansion(parameters, along);
        let held = self.origin.len() - self.dimensions * self.free.targets.len();
        completed.resize(self.places.len() + held, 0.0);
        self.places.iter().zip(outputs).for_each(|(place, y)| completed[*place] += y);
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

    /// Cotangent of a sample's outputs from that of its displacement.
    fn pull_back(&self, outputs: &[f64], parameters: &[f64], cotangent: &[f64]) -> Vec<f64> {
        let free = self.project(cotangent);
        let pulled = match &self.coordinates {
            Coordinates::Components => scaled(&free, &self.scale),
            Coordinates::Principal(directions) => directions.pull_back(&free),
            Coordinates::Motions(motions) => {
                let outputs = self.completed(outputs, parameters, None);
                motions.tree().pull_back(&outputs, &free)
            }
        };
        self.places.iter().map(|place| pulled[*place]).collect()
    }
}

fn scaled(values: &[f64], scale: &[f64]) -> Vec<f64> {
    values.iter().zip(scale).map(|(value, scale)| value * scale).collect()
}

/// Rows of a tensor.
pub(crate) fn rows(table: &Tensor<2>) -> Vec<Vec<f64>> {
    let columns = table.dims()[1];
    numbers(table.clone()).chunks(columns).map(<[f64]>::to_vec).collect()
}

fn doubled(values: &[f32]) -> Vec<f64> {
    values.iter().map(|&value| value.into()).collect()
}

/// A geometry's tensors, without automatic differentiation.
#[derive(Debug, Clone)]
pub(crate) struct GeometryTensors {
    /// Edges and layers of the graph.
    pub graph: Graph,
    /// `[kinds of nodes, features]`, standardised.
    pub nodes: Tensor<2>,
    /// `[kinds of edges, features]`, standardised.
    pub edges: Tensor<2>,
    /// `[1, global features]`, standardised.
    pub global: Option<Tensor<2>>,
    /// Map from network outputs to nodal displacements \[length\].
    pub output: Arc<OutputMap>,
}

impl GeometryTensors {
    /// Embeddings of its nodes by message passing.
    pub(crate) fn embedding(&self, emulator: &GraphNetwork) -> Embedding {
        let [nodes, edges] = [&self.nodes, &self.edges].map(|table| emulator.lifted(table));
        emulator.local_embedding(&self.graph, nodes, edges)
    }

    /// Displacements at standardised parameters \[length\], from the embeddings of its nodes.
    pub(crate) fn displacement(
        &self,
        emulator: &GraphNetwork,
        local: Embedding,
        parameters: &Tensor<2>,
    ) -> Tensor<3> {
        let global = self.global.as_ref().map(|table| emulator.lifted(table));
        let local = self.output.decoded(local);
        let outputs = emulator.decode(local, global, emulator.lifted(parameters));
        self.output.displacement(outputs, parameters)
    }
}

/// Standardised parameters `[batch, parameters]`.
pub(crate) fn parameter_tensor<'a>(
    scaling: &ParameterScaling,
    thetas: impl ExactSizeIterator<Item = &'a [f64]>,
    device: &Device,
) -> Result<Tensor<2>> {
    let rows = thetas.len();
    Ok(matrix(&standardised(scaling, thetas)?.concat(), rows, device))
}

/// Standardised parameter sets.
pub(crate) fn standardised<'a>(
    scaling: &ParameterScaling,
    thetas: impl Iterator<Item = &'a [f64]>,
) -> Result<Vec<Vec<f64>>> {
    thetas.map(|theta| Ok(scaling.standardise(theta)?)).collect()
}

/// `[rows, columns]` in single precision.
pub(crate) fn matrix(values: &[f64], rows: usize, device: &Device) -> Tensor<2> {
    let columns = values.len() / rows.max(1);
    let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
    Tensor::from_data(TensorData::new(values, [rows, columns]), device)
}

/// Numbers of a tensor on the host.
pub(crate) fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    let data = tensor.into_data();
    match data.as_slice::<f32>() {
        Ok(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Err(_) => data.iter::<f64>().collect(),
    }
}
