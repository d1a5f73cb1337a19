//! The field of pressure of mixed elements.

use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use crate::{Body, SceneError};
use sinew_mesh::Mesh;

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

    pub(crate) fn new<const N: usize>(rule: &[QuadraturePoint], mesh: &Mesh<N>) -> Self
    where
        Nodes<N>: FiniteElement<N>,
    {
        let shape: Vec<_> = rule.iter().map(|p| Nodes::<N>::corner_shape(p.at)).collect();
        let corners = shape[0].len();
        let of_cells = || mesh.cells.iter().flat_map(|nodes| &nodes[..corners]);
        let mut nodes: Vec<_> = of_cells().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut unknown = vec![usize::MAX; mesh.points.len()];
        nodes.iter().enumerate().for_each(|(at, &node)| unknown[node] = at);
        let cells = of_cells().map(|&node| unknown[node]).collect();
        Self { unknowns: nodes.len(), nodes, corners, cells, compliance: 0.0, shape }
    }
}

impl Body {
    /// Mixed elements with the further bulk modulus 1/`compliance` \[stress\]; 0 is incompressible.
    ///
    /// # Errors
    /// [`SceneError::Compliance`] where it is negative or not finite.
    pub fn with_compliance(mut self, compliance: f64) -> Result<Self, SceneError> {
        if !(compliance >= 0.0 && compliance.is_finite()) {
            return Err(SceneError::Compliance { value: compliance });
        }
        self.0.pressure_field.iter_mut().for_each(|field| field.compliance = compliance);
        Ok(self)
    }

    /// Pressures \[stress\] at all nodes of the mesh from those at the nodes of the field, which is linear in each cell; `None` without a
    /// field, or with pressures of another.
    pub fn nodal_pressure(&self, pressure: &[f64]) -> Option<Vec<f64>> {
        let field =
            self.pressure_field.as_ref().filter(|field| field.unknowns == pressure.len())?;
        let edges = self.element().edges;
        let mut of_nodes = vec![0.0; self.nodes];
        field.nodes.iter().zip(pressure).for_each(|(&node, &p)| of_nodes[node] = p);
        for cell in self.cell_nodes() {
            for edge in edges {
                if let [a, b, middle] = **edge {
                    of_nodes[cell[middle]] = 0.5 * (of_nodes[cell[a]] + of_nodes[cell[b]]);
                }
            }
        }
        Some(of_nodes)
    }
}
