//! Prescribed displacements written over predicted ones.

use burn::tensor::{Device, Tensor};

use crate::arrays::matrix;
use sinew_emulate::coordinates::Dirichlet;

/// Imposes Dirichlet conditions and leaves free directions: `u ↦ Q u + v` with the projector Q of each node.
#[derive(Debug, Clone)]
pub(crate) struct Supports {
    /// Columns of the projectors, or their diagonal alone where all are along the coordinate axes: `[1, nodes, D]` each.
    projectors: Vec<Tensor<3>>,
    /// v, `[1, nodes, D]`.
    held: Tensor<3>,
}

impl Supports {
    pub(crate) fn new(dirichlet: &Dirichlet, dimensions: usize, device: &Device) -> Self {
        let nodes = dirichlet.prescribed.len() / dimensions;
        let field = |values: Vec<f64>| matrix(&values, nodes, device).unsqueeze_dim::<3>(0);
        let table = dirichlet.projectors(dimensions);
        let entry =
            |node: usize, i: usize, j: usize| table[(node * dimensions + i) * dimensions + j];
        let rows = || (0..nodes * dimensions).map(|at| (at / dimensions, at % dimensions));
        let projectors = if dirichlet.axes.is_empty() {
            vec![field(rows().map(|(node, i)| entry(node, i, i)).collect())]
        } else {
            let column = |j| field(rows().map(|(node, i)| entry(node, i, j)).collect());
            (0..dimensions).map(column).collect()
        };
        Self { projectors, held: field(dirichlet.held(dimensions)) }
    }

    pub(crate) fn write_over(&self, displacement: Tensor<3>) -> Tensor<3> {
        self.project(displacement) + self.held.clone()
    }

    /// The part of a change that supports leave.
    pub(crate) fn project(&self, change: Tensor<3>) -> Tensor<3> {
        if let [diagonal] = &self.projectors[..] {
            return change * diagonal.clone();
        }
        let columns = self.projectors.iter().enumerate();
        let terms =
            columns.map(|(j, column)| change.clone().slice_dim(2, j..j + 1) * column.clone());
        terms.reduce(|sum, term| sum + term).unwrap_or(change)
    }

    pub(crate) fn lifted(&self) -> Self {
        Self {
            projectors: self.projectors.iter().cloned().map(Tensor::from_inner).collect(),
            held: Tensor::from_inner(self.held.clone()),
        }
    }

    /// Nodes and components.
    pub(crate) fn dims(&self) -> [usize; 2] {
        let [_, nodes, dimensions] = self.held.dims();
        [nodes, dimensions]
    }
}
