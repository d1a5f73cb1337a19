//! From the outputs of a network to displacements.

use std::sync::Arc;

use burn::tensor::{Device, Tensor, TensorData};
use sinew_burn::{MotionTree, rigid_motions, rigid_motions_tangent};

use super::Coordinates;
use super::supports::Supports;
use crate::data::Geometry;
use crate::emulator::Output;
use crate::scaling::OutputScale;
use crate::surrogate::matrix;

/// From network outputs to displacements, prescribed ones written over them.
#[derive(Debug, Clone)]
pub(crate) struct OutputMap {
    /// Displacement of a zero output, `[1, real nodes, D]`.
    origin: Tensor<3>,
    rule: Rule,
    supports: Supports,
}

/// From outputs to displacements beyond those of zero outputs.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "there is one of them per geometry")]
enum Rule {
    /// Times `[1, real nodes, D]`.
    Scale(Tensor<3>),
    /// Applied from the right, one after the other, to outputs flattened over nodes and components.
    Matrices(Vec<Tensor<2>>),
    Motions(Arc<MotionTree>),
}

impl OutputMap {
    pub fn new(
        geometry: &Geometry,
        scales: &OutputScale,
        [nodes, dimensions]: [usize; 2],
        device: &Device,
    ) -> Self {
        // Per component or per degree of freedom.
        let field = |values: &[f64]| {
            let values: Vec<f64> =
                values.iter().copied().cycle().take(nodes * dimensions).collect();
            matrix(&values, nodes, device).unsqueeze_dim::<3>(0)
        };
        let rule = match &geometry.coordinates {
            Coordinates::Components => Rule::Scale(field(&scales.scale)),
            Coordinates::Motions(motions) => Rule::Motions(motions.tree().clone()),
            Coordinates::Principal(directions) => Rule::Matrices(directions.matrices(device)),
        };
        Self {
            origin: field(geometry.coordinates.origin().unwrap_or(&scales.mean)),
            rule,
            supports: Supports::new(&geometry.dirichlet, dimensions, device),
        }
    }

    /// Displacements `[batch, real nodes, D]`.
    pub fn displacement(&self, output: Output) -> Tensor<3> {
        let increment = match (&self.rule, output.clusters) {
            (Rule::Motions(tree), Some(clusters)) => rigid_motions(clusters, output.nodes, tree),
            _ => self.linear(output.nodes),
        };
        self.supports.write_over(increment + self.origin.clone())
    }

    /// Change of the displacements `[directions · batch, real nodes, D]` along changes of the outputs, samples fastest.
    pub fn tangent(&self, output: &Output, change: Output) -> Tensor<3> {
        let change = match (&self.rule, &output.clusters, change.clusters) {
            (Rule::Motions(tree), Some(clusters), Some(cluster_change)) => {
                let shape = change.nodes.dims();
                let numbers =
                    |x: &Tensor<3>| -> Vec<f32> { x.clone().into_data().iter::<f32>().collect() };
                let at = (&numbers(clusters)[..], &numbers(&output.nodes)[..]);
                let along = (&numbers(&cluster_change)[..], &numbers(&change.nodes)[..]);
                let tangent = rigid_motions_tangent(at, along, tree);
                let tangent: Vec<f32> = tangent.into_iter().map(|t| t as f32).collect();
                Tensor::from_data(TensorData::new(tangent, shape), &change.nodes.device())
            }
            _ => self.linear(change.nodes),
        };
        self.supports.project(change)
    }

    fn linear(&self, output: Tensor<3>) -> Tensor<3> {
        match &self.rule {
            Rule::Scale(scale) => output * scale.clone(),
            Rule::Matrices(matrices) => {
                let [batch, nodes, dimensions] = output.dims();
                let flat = output.reshape([batch, nodes * dimensions]);
                let mapped = matrices.iter().fold(flat, |row, matrix| row.matmul(matrix.clone()));
                mapped.reshape([batch, nodes, dimensions])
            }
            // A network that has no outputs of clusters leaves them at rest.
            Rule::Motions(tree) => {
                let [batch, ..] = output.dims();
                let clusters = Tensor::zeros([batch, tree.centres.len(), 6], &output.device());
                rigid_motions(clusters, output, tree)
            }
        }
    }

    /// The same ready to meet tensors of an automatically differentiated network.
    pub fn lifted(&self) -> Self {
        Self {
            origin: Tensor::from_inner(self.origin.clone()),
            rule: match &self.rule {
                Rule::Scale(scale) => Rule::Scale(Tensor::from_inner(scale.clone())),
                Rule::Matrices(all) => {
                    Rule::Matrices(all.iter().cloned().map(Tensor::from_inner).collect())
                }
                Rule::Motions(tree) => Rule::Motions(tree.clone()),
            },
            supports: self.supports.lifted(),
        }
    }

    /// Nodes and components of a displacement.
    pub fn dims(&self) -> [usize; 2] {
        self.supports.dims()
    }
}
