//! The field of pressure of mixed elements.

use sinew_mesh::{Mesh, QuadraturePoint};
use sinew_num::ascending;

/// A continuous linear pressure `p`: adds `∫ p (J − 1) − ½ p²/κ dV` to the potential, stationary in p.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureField {
    /// Number of pressure unknowns.
    pub unknowns: usize,
    /// Nodes of the mesh that they sit at, ascending.
    pub nodes: Vec<usize>,
    /// Corners of a cell.
    pub corners: usize,
    /// Pressure unknowns of each cell, cell by cell, `corners` each.
    pub cells: Vec<usize>,
    /// `1/κ` \[1/stress\]: 0 for an incompressible body. The bulk modulus κ adds to the law's own.
    pub compliance: f64,
    /// Values of their shape functions at each quadrature point of the reference element.
    pub shape: Vec<Vec<f64>>,
}

impl PressureField {
    /// Cell of a quadrature point, unknowns of its corners, and their shape functions at the point.
    pub fn of_point(&self, point: usize) -> (usize, &[usize], &[f64]) {
        let (cell, local) = (point / self.shape.len(), point % self.shape.len());
        (cell, &self.cells[cell * self.corners..][..self.corners], &self.shape[local])
    }

    /// Pressure at a quadrature point \[stress\] from the unknowns.
    pub fn at(&self, point: usize, unknowns: &[f64]) -> f64 {
        let (_, corners, shape) = self.of_point(point);
        shape.iter().zip(corners).map(|(n, &corner)| n * unknowns[corner]).sum()
    }

    pub(crate) fn new<const N: usize>(rule: &[QuadraturePoint], mesh: &Mesh<N>) -> Self {
        // Linear, whatever the cells are.
        let shape = |point: &QuadraturePoint| match N {
            6 => Mesh::<3>::shape(point.at).to_vec(),
            10 => Mesh::<4>::shape(point.at).to_vec(),
            _ => Mesh::<N>::shape(point.at).to_vec(),
        };
        let shape: Vec<_> = rule.iter().map(shape).collect();
        let corners = shape[0].len();
        let of_cells = || mesh.cells.iter().flat_map(|nodes| &nodes[..corners]);
        let nodes = ascending(of_cells().copied());
        let mut unknown = vec![usize::MAX; mesh.points.len()];
        nodes.iter().enumerate().for_each(|(at, &node)| unknown[node] = at);
        let cells = of_cells().map(|&node| unknown[node]).collect();
        Self { unknowns: nodes.len(), nodes, corners, cells, compliance: 0.0, shape }
    }
}
