//! Quadrature on the reference element of each kind of cell and on its facets.

mod facet;
mod rules;

pub use facet::{FacetPoint, FacetRule};
use sinew_mesh::Mesh;

/// A quadrature point of a reference element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates, see [`sinew_mesh::Element::nodes`].
    pub at: [f64; 3],
    /// Weight; all weights of a rule add up to the measure of the reference element.
    pub weight: f64,
}

/// Quadrature on the element with `N` nodes: 4 and 10 are tetrahedra, 8 are hexahedra, 3 and 6 are triangles. Its shape functions are
/// [`Mesh::shape`].
///
/// Triangles are a slice of unit thickness in plane strain: nothing depends on the third coordinate.
///
/// ```
/// use sinew_energy::Nodes;
///
/// let volume: f64 = Nodes::<10>::QUADRATURE.iter().map(|point| point.weight).sum();
/// assert!((volume - 1.0 / 6.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nodes<const N: usize>;

impl<const N: usize> Nodes<N> {
    /// The rule that energies are integrated with.
    pub const QUADRATURE: &'static [QuadraturePoint] = match N {
        3 => rules::TRIANGLE_1,
        6 => rules::TRIANGLE_3,
        4 => rules::TETRAHEDRON_1,
        10 => rules::TETRAHEDRON_4,
        _ => rules::HEXAHEDRON_8,
    };

    /// A rule of higher degree, for terms with one more factor, such as those of a pressure field.
    pub const FINE_QUADRATURE: &'static [QuadraturePoint] = match N {
        3 => rules::TRIANGLE_3,
        6 => rules::TRIANGLE_6,
        4 => rules::TETRAHEDRON_4,
        10 => rules::TETRAHEDRON_14,
        _ => rules::HEXAHEDRON_8,
    };

    /// Shape functions and quadrature on a facet.
    pub fn facet_rule() -> FacetRule {
        match N {
            3 => FacetRule::linear_edge(),
            6 => FacetRule::quadratic_edge(),
            4 => FacetRule::triangle::<3>(rules::TRIANGLE_1),
            10 => FacetRule::triangle::<6>(rules::TRIANGLE_6),
            _ => FacetRule::quadrilateral(),
        }
    }

    /// Values of the shape functions that are 1 at one corner and fall to 0 at the others.
    pub(crate) fn corner_shape(at: [f64; 3]) -> Vec<f64> {
        match N {
            6 => Mesh::<3>::shape(at).to_vec(),
            10 => Mesh::<4>::shape(at).to_vec(),
            _ => Mesh::<N>::shape(at).to_vec(),
        }
    }
}
