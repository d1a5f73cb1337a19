//! Shape functions and quadrature on the facets of elements.

use super::QuadraturePoint;
use sinew_mesh::Mesh;

/// Shape functions of a facet at its quadrature points.
///
/// The facet of a triangle is an edge of unit thickness: its second parameter is the third coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetRule {
    /// Nodes of a facet, counterclockwise seen from outside the solid, corners first.
    pub nodes: usize,
    /// Number of its corners.
    pub corners: usize,
    /// Dimension of the solid.
    pub dimension: usize,
    /// The quadrature points.
    pub points: Vec<FacetPoint>,
}

/// A quadrature point of a facet.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetPoint {
    /// Weight of the point.
    pub weight: f64,
    /// Values of the shape functions.
    pub shape: Vec<f64>,
    /// Derivatives of the shape functions along the two parameters of the facet; zero along the second
    /// for an edge.
    pub slope: [Vec<f64>; 2],
}

/// Gauss' two points.
const G: f64 = 0.577_350_269_189_625_8;

impl FacetRule {
    pub(super) fn triangle<const N: usize>(rule: &[QuadraturePoint]) -> Self {
        let points = rule.iter().map(|point| {
            let slopes = Mesh::<N>::shape_derivatives(point.at);
            let slope = [0, 1].map(|i| slopes.iter().map(|s| s[i]).collect());
            let shape = Mesh::<N>::shape(point.at).to_vec();
            FacetPoint { weight: point.weight, shape, slope }
        });
        Self { nodes: N, corners: 3, dimension: 3, points: points.collect() }
    }

    pub(super) fn quadrilateral() -> Self {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let points = corners.map(|[s, t]| {
            let at = [G * s, G * t];
            let factor = |corner: [f64; 2], i: usize| 0.5 * (1.0 + corner[i] * at[i]);
            let shape = corners.iter().map(|&c| factor(c, 0) * factor(c, 1)).collect();
            let slope =
                [0, 1].map(|i| corners.iter().map(|&c| 0.5 * c[i] * factor(c, 1 - i)).collect());
            FacetPoint { weight: 1.0, shape, slope }
        });
        Self { nodes: 4, corners: 4, dimension: 3, points: points.into() }
    }

    pub(super) fn linear_edge() -> Self {
        let shape = vec![0.5, 0.5];
        let slope = [vec![-0.5, 0.5], vec![0.0; 2]];
        let points = vec![FacetPoint { weight: 2.0, shape, slope }];
        Self { nodes: 2, corners: 2, dimension: 2, points }
    }

    pub(super) fn quadratic_edge() -> Self {
        let points = [-G, G].map(|s| FacetPoint {
            weight: 1.0,
            shape: vec![0.5 * s * (s - 1.0), 0.5 * s * (s + 1.0), 1.0 - s * s],
            slope: [vec![s - 0.5, s + 0.5, -2.0 * s], vec![0.0; 3]],
        });
        Self { nodes: 3, corners: 2, dimension: 2, points: points.into() }
    }
}
