//! Equilibrium where there is no potential to minimise.

use crate::elements::{Element, Nodes, QuadraturePoint};
use crate::{Exact, PressureSurface, TotalPotential};
use sinew_mesh::SimplexMesh;

/// A balance of forces that is not the minimum of a potential: pressures on surfaces with a loose rim,
/// and incompressible bodies, whose pressure is an unknown field (a saddle point).
#[derive(Clone, Debug)]
pub struct ForceBalance<L, const D: usize, const N: usize> {
    /// What has a potential.
    pub potential: TotalPotential<L, D, Exact, N>,
    /// True follower pressures without one.
    pub followers: Vec<PressureSurface>,
    /// The field of pressure that makes the body incompressible, if it is.
    pub pressure_field: Option<PressureField>,
}

/// A continuous linear pressure `p`: adds `∫ p (J − 1) dV` to the potential, stationary in p.
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
    /// Values of their shape functions at each quadrature point of the reference element.
    pub shape: Vec<Vec<f64>>,
}

impl PressureField {
    pub(crate) fn new<const N: usize>(rule: &[QuadraturePoint], mesh: &SimplexMesh<N>) -> Self
    where
        Nodes<N>: Element<N>,
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
        Self { unknowns: nodes.len(), nodes, corners, cells, shape }
    }
}
