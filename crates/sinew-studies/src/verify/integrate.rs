//! Quadrature over solid meshes, independent of that of the solver's potential.

use sinew_mesh::{Mesh, QuadraturePoint};
use sinew_num::Mat3;

/// A quadrature point of a mesh.
pub(crate) struct Point<const N: usize> {
    /// Nodes of its cell.
    pub nodes: [usize; N],
    /// Reference position \[length\].
    pub at: [f64; 3],
    /// Volume that it stands for \[length³\].
    pub volume: f64,
    /// Values of the shape functions.
    pub shape: [f64; N],
    /// Their gradients \[1/length\].
    pub gradient: [[f64; 3]; N],
}

impl<const N: usize> Point<N> {
    /// A nodal vector field at the point.
    pub(crate) fn value(&self, field: &[f64]) -> [f64; 3] {
        std::array::from_fn(|i| (0..N).map(|a| self.shape[a] * field[3 * self.nodes[a] + i]).sum())
    }

    /// Gradient of a nodal vector field, `∂u_i/∂X_j` in row i.
    pub(crate) fn slope(&self, field: &[f64]) -> [[f64; 3]; 3] {
        let entry = |i: usize, j: usize| -> f64 {
            (0..N).map(|a| self.gradient[a][j] * field[3 * self.nodes[a] + i]).sum()
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}

/// All points of a mesh under a rule on the reference element.
pub(crate) fn points<const N: usize>(
    mesh: &Mesh<N>,
    rule: &[QuadraturePoint],
) -> impl Iterator<Item = Point<N>> {
    let shapes: Vec<_> = rule
        .iter()
        .map(|p| (p.weight, Mesh::<N>::shape(p.at), Mesh::<N>::shape_derivatives(p.at)))
        .collect();
    mesh.cells.iter().flat_map(move |&nodes| {
        let corners = nodes.map(|node| mesh.points[node]);
        let at_point = |&(weight, shape, slopes): &(f64, [f64; N], [[f64; 3]; N])| {
            let at = std::array::from_fn(|i| (0..N).map(|a| shape[a] * corners[a][i]).sum());
            let jacobian =
                Mat3::from_fn(|i, k| (0..N).map(|a| slopes[a][k] * corners[a][i]).sum::<f64>());
            let determinant = jacobian.determinant();
            let inverse = Mat3::from_fn(|k, j| jacobian.cofactor(j, k) / determinant);
            let gradient = slopes.map(|slope| {
                std::array::from_fn(|j| (0..3).map(|k| slope[k] * inverse[k][j]).sum())
            });
            Point { nodes, at, volume: weight * determinant, shape, gradient }
        };
        shapes.iter().map(at_point).collect::<Vec<_>>()
    })
}
