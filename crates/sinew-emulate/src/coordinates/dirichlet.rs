//! Displacements that supports prescribe.

use crate::coordinates::{CoordinateError, Result, ensure};
use serde::{Deserialize, Serialize};
use sinew_energy::Body;
use std::collections::BTreeMap;

/// Prescribed displacements, written over a predicted one (hard enforcement, thesis §3.2.3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Dirichlet {
    /// Value of every degree of freedom, node by node, `None` where it is free \[length\].
    pub prescribed: Vec<Option<f64>>,
    /// Orthonormal axes, one per row, of the nodes in space whose degrees of freedom are along directions of their own.
    pub axes: BTreeMap<usize, [[f64; 3]; 3]>,
}

impl Dirichlet {
    /// Holds all components of `nodes` at zero.
    ///
    /// # Errors
    /// [`CoordinateError::Count`] if a node does not exist.
    pub fn clamped(real_nodes: usize, dimensions: usize, nodes: &[usize]) -> Result<Self> {
        let mut prescribed = vec![None; real_nodes * dimensions];
        for &node in nodes {
            let (what, found, expected) = ("clamped node index", node, real_nodes);
            ensure(found < expected, CoordinateError::Count { what, found, expected })?;
            prescribed[node * dimensions..(node + 1) * dimensions].fill(Some(0.0));
        }
        Ok(Self { prescribed, axes: BTreeMap::new() })
    }

    /// Dirichlet conditions of a body's supports.
    pub fn of_body(body: &Body) -> Self {
        let frame = |node| body.frames.get(node).map(|axes| (node, axes.0));
        let axes = body.frames.nodes().filter_map(frame).collect();
        Self { prescribed: body.prescribed.clone(), axes }
    }

    /// Component `i` of the direction of a node's degree of freedom `k`.
    fn axis(&self, node: usize, k: usize, i: usize) -> f64 {
        self.axes.get(&node).map_or(f64::from(u8::from(i == k)), |axes| axes[k][i])
    }

    /// Projectors onto the free directions of every node: matrices over its components, row by row.
    pub fn projectors(&self, dimensions: usize) -> Vec<f64> {
        let mut table = Vec::with_capacity(self.prescribed.len() * dimensions);
        for (node, prescribed) in self.prescribed.chunks(dimensions).enumerate() {
            for (i, j) in (0..dimensions).flat_map(|i| (0..dimensions).map(move |j| (i, j))) {
                let free = prescribed.iter().enumerate().filter(|(_, value)| value.is_none());
                table.push(free.map(|(k, _)| self.axis(node, k, i) * self.axis(node, k, j)).sum());
            }
        }
        table
    }

    /// Prescribed displacement of every node, zero where it is free.
    pub fn held(&self, dimensions: usize) -> Vec<f64> {
        let nodes = self.prescribed.chunks(dimensions).enumerate();
        let of_node = |(node, prescribed): (usize, &[Option<f64>])| -> Vec<f64> {
            let component = |i| {
                let held = prescribed.iter().enumerate();
                held.filter_map(|(k, value)| Some((*value)? * self.axis(node, k, i))).sum()
            };
            (0..dimensions).map(component).collect()
        };
        nodes.flat_map(of_node).collect()
    }

    /// A displacement in space with what supports prescribe in place of its own.
    pub fn write_over(&self, displacement: &[f64]) -> Vec<f64> {
        let projectors = self.projectors(3);
        let rows = projectors.chunks_exact(3).zip(self.held(3)).enumerate();
        let entry = |(at, (row, held)): (usize, (&[f64], f64))| {
            let node = &displacement[at / 3 * 3..at / 3 * 3 + 3];
            held + row.iter().zip(node).map(|(q, u)| q * u).sum::<f64>()
        };
        rows.map(entry).collect()
    }
}
