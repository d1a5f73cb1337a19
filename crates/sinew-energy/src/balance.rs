//! Equilibrium where there is no potential to minimise.

use crate::body::{check_theta, theta_len};
use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use crate::{Body, BodyArrays, PressureSurface, SceneError, ThetaError};
use sinew_mesh::Mesh;
use std::sync::Arc;

/// A balance of forces that is not the minimum of a potential: pressures on surfaces with a loose rim,
/// and incompressible bodies, whose pressure is an unknown field (a saddle point).
///
/// It reads as its [`BalanceParts`] do (`balance.followers`), which nobody else can change, as a [`Body`] does.
#[derive(Clone, Debug)]
pub struct ForceBalance(pub(crate) BalanceParts);

impl std::ops::Deref for ForceBalance {
    type Target = BalanceParts;

    fn deref(&self) -> &BalanceParts {
        &self.0
    }
}

/// Parts of a [`ForceBalance`].
#[derive(Clone, Debug)]
pub struct BalanceParts {
    /// Part with a potential.
    pub body: Body,
    /// True follower pressures without one.
    pub followers: Vec<PressureSurface>,
    /// The field of pressure that makes the body incompressible, if it is.
    pub pressure_field: Option<PressureField>,
}

/// The balance that is all potential.
impl From<Body> for ForceBalance {
    fn from(body: Body) -> Self {
        Self(BalanceParts { body, followers: Vec::new(), pressure_field: None })
    }
}

impl ForceBalance {
    /// The part with a potential alone.
    pub fn into_body(self) -> Body {
        self.0.body
    }

    /// The balance with a changed body: `balance.map(|body| body.stiffened_cells(&factors))`.
    ///
    /// # Errors
    /// Those of `change`, and [`SceneError::OtherBody`] if it gives a body of another mesh, or of other parameters than the
    /// followers read.
    pub fn map(
        self,
        change: impl FnOnce(Body) -> Result<Body, SceneError>,
    ) -> Result<Self, SceneError> {
        let parts = self.0;
        let BodyArrays { mesh, points_per_cell, parameters, .. } = &*parts.body;
        let (mesh, points, parameters) = (mesh.clone(), *points_per_cell, parameters.clone());
        let body = change(parts.body)?;
        let same_points = body.points_per_cell == points;
        let same_theta = parts.followers.is_empty() || body.parameters == parameters;
        if !(Arc::ptr_eq(&body.mesh, &mesh) && same_points && same_theta) {
            return Err(SceneError::OtherBody);
        }
        Ok(Self(BalanceParts { body, ..parts }))
    }

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

    /// Checks that θ has the right length, is finite and gives every parameter a value that makes sense.
    ///
    /// # Errors
    /// The first entry that does not.
    pub fn check_theta(&self, theta: &[f64]) -> Result<(), ThetaError> {
        let followers = self.followers.iter().map(|surface| surface.magnitude);
        let material = &*self.body.material;
        check_theta(material, theta, theta_len(material, followers).max(self.body.theta_len()))
    }

    /// Pressures \[stress\] at all nodes of the mesh from those at the nodes of the field, which is linear in each cell; `None` without a
    /// field, or with pressures of another.
    pub fn nodal_pressure(&self, pressure: &[f64]) -> Option<Vec<f64>> {
        let field =
            self.pressure_field.as_ref().filter(|field| field.unknowns == pressure.len())?;
        let edges = self.body.element().edges;
        let mut of_nodes = vec![0.0; self.body.nodes];
        field.nodes.iter().zip(pressure).for_each(|(&node, &p)| of_nodes[node] = p);
        for cell in self.body.cell_nodes() {
            for edge in edges {
                if let [a, b, middle] = **edge {
                    of_nodes[cell[middle]] = 0.5 * (of_nodes[cell[a]] + of_nodes[cell[b]]);
                }
            }
        }
        Some(of_nodes)
    }
}

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
