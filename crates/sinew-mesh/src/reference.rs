//! The reference element of each kind of cell: shape functions and quadrature.

use crate::{Element, Mesh};

/// A quadrature point of a reference element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates, see [`Element::nodes`].
    pub at: [f64; 3],
    /// Weight; all weights of a rule add up to the measure of the reference element.
    pub weight: f64,
}

impl<const N: usize> Mesh<N> {
    /// The rule that energies are integrated with.
    ///
    /// ```
    /// use sinew_mesh::Mesh;
    /// let volume: f64 = Mesh::<10>::QUADRATURE.iter().map(|point| point.weight).sum();
    /// assert!((volume - 1.0 / 6.0).abs() < 1e-15);
    /// ```
    pub const QUADRATURE: &'static [QuadraturePoint] = Self::ELEMENT.quadrature[0];

    /// A rule of higher degree, for terms with one more factor, such as those of a pressure field.
    pub const FINE_QUADRATURE: &'static [QuadraturePoint] = Self::ELEMENT.quadrature[1];

    /// Values of the shape functions of a cell at a point of the reference element, see [`Element::nodes`].
    ///
    /// ```
    /// use sinew_mesh::Mesh;
    /// assert_eq!(Mesh::<4>::shape([0.25; 3]), [0.25; 4]);
    /// let sum: f64 = Mesh::<10>::shape([0.1, 0.2, 0.3]).iter().sum();
    /// assert!((sum - 1.0).abs() < 1e-15);
    /// ```
    pub fn shape(at: [f64; 3]) -> [f64; N] {
        let element = Self::ELEMENT;
        let l = barycentric(element, at);
        std::array::from_fn(|a| match a.checked_sub(element.corners) {
            None if N == 8 => (0..3).map(|i| factor(element, a, i, at)).product(),
            None if element.is_quadratic() => l[a] * (2.0 * l[a] - 1.0),
            None => l[a],
            Some(edge) => 4.0 * l[element.edges[edge][0]] * l[element.edges[edge][1]],
        })
    }

    /// Derivatives of the shape functions along the reference axes; those of triangles along the third are zero.
    pub fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; N] {
        let element = Self::ELEMENT;
        let l = barycentric(element, at);
        let slope = |corner: usize, axis: usize| match corner {
            _ if axis >= element.dimension => 0.0,
            0 => -1.0,
            _ => f64::from(u8::from(corner == axis + 1)),
        };
        let derivative = |a: usize, i: usize| match a.checked_sub(element.corners) {
            None if N == 8 => {
                let across =
                    factor(element, a, (i + 1) % 3, at) * factor(element, a, (i + 2) % 3, at);
                (2.0 * element.nodes[a][i] - 1.0) * across
            }
            None if element.is_quadratic() => (4.0 * l[a] - 1.0) * slope(a, i),
            None => slope(a, i),
            Some(edge) => {
                let [b, c] = [0, 1].map(|end| element.edges[edge][end]);
                4.0 * (l[b] * slope(c, i) + l[c] * slope(b, i))
            }
        };
        std::array::from_fn(|a| std::array::from_fn(|i| derivative(a, i)))
    }
}

/// Barycentric coordinates of a point of a simplex.
fn barycentric(element: &Element, at: [f64; 3]) -> [f64; 4] {
    let first = at[..element.dimension].iter().fold(1.0, |rest, x| rest - x);
    [first, at[0], at[1], at[2]]
}

/// The factor along one axis of a shape function of the hexahedron.
fn factor(element: &Element, node: usize, axis: usize, at: [f64; 3]) -> f64 {
    if element.nodes[node][axis] == 1.0 { at[axis] } else { 1.0 - at[axis] }
}

const fn point(at: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { at, weight }
}

/// Degree 1.
pub(crate) const TRIANGLE_1: &[QuadraturePoint] = &[point([1.0 / 3.0, 1.0 / 3.0, 0.0], 0.5)];

const A: f64 = 1.0 / 6.0;
const B: f64 = 2.0 / 3.0;
/// Degree 2.
pub(crate) const TRIANGLE_3: &[QuadraturePoint] =
    &[point([A, A, 0.0], A), point([B, A, 0.0], A), point([A, B, 0.0], A)];

const C: f64 = 0.445_948_490_915_965;
const D: f64 = 0.091_576_213_509_771;
const WEIGHT_C: f64 = 0.5 * 0.223_381_589_678_011;
const WEIGHT_D: f64 = 0.5 * 0.109_951_743_655_322;
/// Degree 4 (D. A. Dunavant, Int. J. Numer. Meth. Engng 21, 1985).
pub(crate) const TRIANGLE_6: &[QuadraturePoint] = &[
    point([C, C, 0.0], WEIGHT_C),
    point([1.0 - 2.0 * C, C, 0.0], WEIGHT_C),
    point([C, 1.0 - 2.0 * C, 0.0], WEIGHT_C),
    point([D, D, 0.0], WEIGHT_D),
    point([1.0 - 2.0 * D, D, 0.0], WEIGHT_D),
    point([D, 1.0 - 2.0 * D, 0.0], WEIGHT_D),
];

/// Degree 1.
pub(crate) const TETRAHEDRON_1: &[QuadraturePoint] = &[point([0.25; 3], 1.0 / 6.0)];

const E: f64 = 0.138_196_601_125_010_5;
const F: f64 = 0.585_410_196_624_968_5;
/// Degree 2.
pub(crate) const TETRAHEDRON_4: &[QuadraturePoint] = &[
    point([E, E, E], 1.0 / 24.0),
    point([F, E, E], 1.0 / 24.0),
    point([E, F, E], 1.0 / 24.0),
    point([E, E, F], 1.0 / 24.0),
];

const G: f64 = 0.310_885_919_263_300_6;
const H: f64 = 0.092_735_250_310_891_22;
const I: f64 = 0.045_503_704_125_649_65;
const J: f64 = 0.5 - I;
const WEIGHT_G: f64 = 0.112_687_925_718_015_85 / 6.0;
const WEIGHT_H: f64 = 0.073_493_043_116_361_95 / 6.0;
const WEIGHT_I: f64 = 0.042_546_020_777_081_47 / 6.0;
/// Degree 5, all weights positive (N. J. Walkington, "Quadrature on simplices of arbitrary dimension", 2000).
pub(crate) const TETRAHEDRON_14: &[QuadraturePoint] = &[
    point([G, G, G], WEIGHT_G),
    point([1.0 - 3.0 * G, G, G], WEIGHT_G),
    point([G, 1.0 - 3.0 * G, G], WEIGHT_G),
    point([G, G, 1.0 - 3.0 * G], WEIGHT_G),
    point([H, H, H], WEIGHT_H),
    point([1.0 - 3.0 * H, H, H], WEIGHT_H),
    point([H, 1.0 - 3.0 * H, H], WEIGHT_H),
    point([H, H, 1.0 - 3.0 * H], WEIGHT_H),
    point([I, I, J], WEIGHT_I),
    point([I, J, I], WEIGHT_I),
    point([J, I, I], WEIGHT_I),
    point([I, J, J], WEIGHT_I),
    point([J, I, J], WEIGHT_I),
    point([J, J, I], WEIGHT_I),
];

const LOW: f64 = 0.211_324_865_405_187_1;
const HIGH: f64 = 1.0 - LOW;
/// Gauss' rule of degree 3 along each axis.
pub(crate) const HEXAHEDRON_8: &[QuadraturePoint] = &[
    point([LOW, LOW, LOW], 0.125),
    point([HIGH, LOW, LOW], 0.125),
    point([HIGH, HIGH, LOW], 0.125),
    point([LOW, HIGH, LOW], 0.125),
    point([LOW, LOW, HIGH], 0.125),
    point([HIGH, LOW, HIGH], 0.125),
    point([HIGH, HIGH, HIGH], 0.125),
    point([LOW, HIGH, HIGH], 0.125),
];
