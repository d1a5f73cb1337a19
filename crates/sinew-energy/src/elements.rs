//! Reference elements: shape functions and quadrature of each kind of cell and of its facets.

mod facet;
mod hexahedron;
mod simplices;
mod tetrahedra;
mod triangles;

pub use facet::{FacetPoint, FacetRule};
use sinew_mesh::{AnyMesh, Mesh};

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
    /// A mesh of these elements without its type.
    fn any(mesh: Mesh<N>) -> AnyMesh;
}

/// Elements whose mid-edge nodes enrich a linear simplex: those of Taylor and Hood.
pub trait TaylorHoodElement<const N: usize>: FiniteElement<N> {}
impl TaylorHoodElement<10> for Nodes<10> {}
impl TaylorHoodElement<6> for Nodes<6> {}

const fn point(at: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { at, weight }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shape functions are 1 at their node, their derivatives agree with differences, and both rules
    /// integrate the polynomial of the stated degree.
    fn check<const N: usize>(nodes: [[f64; 3]; N])
    where
        Nodes<N>: FiniteElement<N>,
    {
        for (a, &at) in nodes.iter().enumerate() {
            let shape = Nodes::<N>::shape(at);
            for b in 0..N {
                assert!((shape[b] - f64::from(u8::from(a == b))).abs() < 1e-14, "{N} {a} {b}");
            }
        }
        const STEP: f64 = 1e-6;
        for point in Nodes::<N>::QUADRATURE.iter().chain(Nodes::<N>::FINE_QUADRATURE) {
            let exact = Nodes::<N>::shape_derivatives(point.at);
            for i in 0..sinew_mesh::Mesh::<N>::ELEMENT.dimension {
                let moved = |by: f64| {
                    let mut at = point.at;
                    at[i] += by;
                    Nodes::<N>::shape(at)
                };
                let (up, down) = (moved(STEP), moved(-STEP));
                for a in 0..N {
                    assert!(((up[a] - down[a]) / (2.0 * STEP) - exact[a][i]).abs() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn shape_functions_are_nodal_and_their_derivatives_right() {
        let mid = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        let t = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        check::<4>(t);
        check::<3>([t[0], t[1], t[2]]);
        let triangle = [mid(t[0], t[1]), mid(t[1], t[2]), mid(t[2], t[0])];
        check::<6>([t[0], t[1], t[2], triangle[0], triangle[1], triangle[2]]);
        let rest = [mid(t[0], t[3]), mid(t[1], t[3]), mid(t[2], t[3])];
        let [a, b, c] = triangle;
        let [d, e, f] = rest;
        check::<10>([t[0], t[1], t[2], t[3], a, b, c, d, e, f]);
        check::<8>(std::array::from_fn(|a| {
            let corner = [[0, 0], [1, 0], [1, 1], [0, 1]][a % 4];
            let sign = |up: usize| 2.0 * up as f64 - 1.0;
            [sign(corner[0]), sign(corner[1]), sign(a / 4)]
        }));
    }

    #[test]
    fn rules_integrate_monomials_of_their_degree() {
        let integrate = |rule: &[QuadraturePoint], powers: [i32; 3]| -> f64 {
            let value = |p: &QuadraturePoint| {
                p.weight * (0..3).map(|i| p.at[i].powi(powers[i])).product::<f64>()
            };
            rule.iter().map(value).sum()
        };
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let simplex = |powers: [i32; 3], dimension: i32| {
            powers.iter().map(|&p| factorial(p)).product::<f64>()
                / factorial(powers.iter().sum::<i32>() + dimension)
        };
        for (rule, degree) in [(Nodes::<10>::QUADRATURE, 2), (Nodes::<10>::FINE_QUADRATURE, 5)] {
            for powers in [[degree, 0, 0], [degree - 1, 1, 0], [degree - 2, 1, 1]] {
                assert!((integrate(rule, powers) - simplex(powers, 3)).abs() < 1e-14, "{powers:?}");
            }
        }
        for (rule, degree) in [(Nodes::<6>::QUADRATURE, 2), (Nodes::<6>::FINE_QUADRATURE, 4)] {
            for powers in [[degree, 0, 0], [degree - 1, 1, 0]] {
                assert!((integrate(rule, powers) - simplex(powers, 2)).abs() < 1e-14, "{powers:?}");
            }
        }
        let even = integrate(Nodes::<8>::QUADRATURE, [2, 2, 2]);
        assert!((even - (2.0f64 / 3.0).powi(3)).abs() < 1e-14);
    }
}
