//! Shape functions and quadrature on the facets of elements.

use sinew_mesh::{Mesh, QuadraturePoint};
use sinew_num::{cross, norm};

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
    /// The rule on the facets of cells with `N` nodes.
    ///
    /// ```
    /// use sinew_energy::FacetRule;
    /// let rule = FacetRule::of_cells::<10>();
    /// assert_eq!((rule.nodes, rule.corners, rule.points.len()), (6, 3, 6));
    /// ```
    pub fn of_cells<const N: usize>() -> Self {
        match N {
            3 => Self::linear_edge(),
            6 => Self::quadratic_edge(),
            4 => Self::face::<3>(3, Mesh::<3>::QUADRATURE.to_vec()),
            10 => Self::face::<6>(3, Mesh::<6>::FINE_QUADRATURE.to_vec()),
            _ => {
                // The lowest facet of the hexahedron, whose four nodes are the first.
                let lowest = Mesh::<8>::QUADRATURE[..4].iter();
                let point = |&QuadraturePoint { at: [x, y, _], weight }: &QuadraturePoint| {
                    QuadraturePoint { at: [x, y, 0.0], weight: 2.0 * weight }
                };
                Self::face::<8>(4, lowest.map(point).collect())
            }
        }
    }

    /// The rule on the same facets that is exact for products of two shape functions of solid cells, which springs have.
    pub(crate) fn of_products<const N: usize>() -> Self {
        match N {
            4 => Self::face::<3>(3, Mesh::<3>::FINE_QUADRATURE.to_vec()),
            _ => Self::of_cells::<N>(),
        }
    }

    /// Tangents of a facet at a quadrature point \[length\], of which the cross product times the weight is the area vector.
    pub fn tangents(
        &self,
        facet: &[usize],
        point: &FacetPoint,
        positions: &[[f64; 3]],
    ) -> [[f64; 3]; 2] {
        let origin = positions[facet[0]];
        let tangent = |slopes: &[f64]| {
            facet.iter().zip(slopes).fold([0.0; 3], |sum: [f64; 3], (&node, s)| {
                std::array::from_fn(|i| sum[i] + s * (positions[node][i] - origin[i]))
            })
        };
        let plane = self.dimension == 2;
        let across = if plane { [0.0, 0.0, 1.0] } else { tangent(&point.slope[1]) };
        [tangent(&point.slope[0]), across]
    }

    /// Area of a facet \[length²\].
    pub fn area(&self, facet: &[usize], positions: &[[f64; 3]]) -> f64 {
        let at = |point: &FacetPoint| {
            let [along, across] = self.tangents(facet, point, positions);
            point.weight * norm(&cross(&along, &across))
        };
        self.points.iter().map(at).sum()
    }

    /// The rule on the face of the reference element with `N` nodes where the third coordinate is 0.
    fn face<const N: usize>(corners: usize, rule: Vec<QuadraturePoint>) -> Self {
        let nodes = if N == 8 { 4 } else { N };
        let points = rule.into_iter().map(|QuadraturePoint { at, weight }| {
            let slopes = &Mesh::<N>::shape_derivatives(at)[..nodes];
            let slope = [0, 1].map(|i| slopes.iter().map(|s| s[i]).collect());
            FacetPoint { weight, shape: Mesh::<N>::shape(at)[..nodes].to_vec(), slope }
        });
        Self { nodes, corners, dimension: 3, points: points.collect() }
    }

    fn linear_edge() -> Self {
        let points = [-G, G].map(|s| FacetPoint {
            weight: 1.0,
            shape: vec![0.5 * (1.0 - s), 0.5 * (1.0 + s)],
            slope: [vec![-0.5, 0.5], vec![0.0; 2]],
        });
        Self { nodes: 2, corners: 2, dimension: 2, points: points.into() }
    }

    fn quadratic_edge() -> Self {
        let points = [-G, G].map(|s| FacetPoint {
            weight: 1.0,
            shape: vec![0.5 * s * (s - 1.0), 0.5 * s * (s + 1.0), 1.0 - s * s],
            slope: [vec![s - 0.5, s + 0.5, -2.0 * s], vec![0.0; 3]],
        });
        Self { nodes: 3, corners: 2, dimension: 2, points: points.into() }
    }
}
