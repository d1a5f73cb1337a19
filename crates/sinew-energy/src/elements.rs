//! Reference elements: shape functions and quadrature of each kind of cell and of its facets.

mod facet;
mod hexahedron;
mod simplices;
mod tetrahedra;
mod triangles;

pub use facet::{FacetPoint, FacetRule};

/// The element with `N` nodes: 4 and 10 are tetrahedra, 8 are hexahedra, 3 and 6 are triangles.
///
/// ```
/// use sinew_energy::{FiniteElement, Nodes};
///
/// let centre = [0.25; 3];
/// assert_eq!(Nodes::<4>::shape(centre), [0.25; 4]);
/// let sum: f64 = Nodes::<10>::shape([0.1, 0.2, 0.3]).iter().sum();
/// assert!((sum - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nodes<const N: usize>;

/// A quadrature point of a reference element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates.
    pub at: [f64; 3],
    /// Weight; all weights of a rule add up to the measure of the reference element.
    pub weight: f64,
}

/// Shape functions and quadrature of the element with `N` nodes, in the order of [`sinew_mesh::Element`].
///
/// Triangles are a slice of unit thickness in plane strain: nothing depends on the third coordinate.
pub trait FiniteElement<const N: usize> {
    /// The rule that energies are integrated with.
    const QUADRATURE: &'static [QuadraturePoint];
    /// A rule of higher degree, for terms with one more factor, such as those of a pressure field.
    const FINE_QUADRATURE: &'static [QuadraturePoint];
    /// Values of the shape functions.
    fn shape(at: [f64; 3]) -> [f64; N];
    /// Derivatives of the shape functions in the reference coordinates.
    fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; N];
    /// Shape functions and quadrature on a facet.
    fn facet_rule() -> FacetRule;
    /// Values of the shape functions that are 1 at one corner and fall to 0 at the others.
    fn corner_shape(at: [f64; 3]) -> Vec<f64> {
        Self::shape(at).to_vec()
    }
}

const fn point(at: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { at, weight }
}
