//! Rules of quadrature on the reference elements.

use super::QuadraturePoint;

const fn point(at: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { at, weight }
}

/// Degree 1.
pub(super) const TRIANGLE_1: &[QuadraturePoint] = &[point([1.0 / 3.0, 1.0 / 3.0, 0.0], 0.5)];

const A: f64 = 1.0 / 6.0;
const B: f64 = 2.0 / 3.0;
/// Degree 2.
pub(super) const TRIANGLE_3: &[QuadraturePoint] =
    &[point([A, A, 0.0], A), point([B, A, 0.0], A), point([A, B, 0.0], A)];

const C: f64 = 0.445_948_490_915_965;
const D: f64 = 0.091_576_213_509_771;
const WEIGHT_C: f64 = 0.5 * 0.223_381_589_678_011;
const WEIGHT_D: f64 = 0.5 * 0.109_951_743_655_322;
/// Degree 4 (D. A. Dunavant, Int. J. Numer. Meth. Engng 21, 1985).
pub(super) const TRIANGLE_6: &[QuadraturePoint] = &[
    point([C, C, 0.0], WEIGHT_C),
    point([1.0 - 2.0 * C, C, 0.0], WEIGHT_C),
    point([C, 1.0 - 2.0 * C, 0.0], WEIGHT_C),
    point([D, D, 0.0], WEIGHT_D),
    point([1.0 - 2.0 * D, D, 0.0], WEIGHT_D),
    point([D, 1.0 - 2.0 * D, 0.0], WEIGHT_D),
];

/// Degree 1.
pub(super) const TETRAHEDRON_1: &[QuadraturePoint] = &[point([0.25; 3], 1.0 / 6.0)];

const E: f64 = 0.138_196_601_125_010_5;
const F: f64 = 0.585_410_196_624_968_5;
/// Degree 2.
pub(super) const TETRAHEDRON_4: &[QuadraturePoint] = &[
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
pub(super) const TETRAHEDRON_14: &[QuadraturePoint] = &[
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
pub(super) const HEXAHEDRON_8: &[QuadraturePoint] = &[
    point([LOW, LOW, LOW], 0.125),
    point([HIGH, LOW, LOW], 0.125),
    point([HIGH, HIGH, LOW], 0.125),
    point([LOW, HIGH, LOW], 0.125),
    point([LOW, LOW, HIGH], 0.125),
    point([HIGH, LOW, HIGH], 0.125),
    point([HIGH, HIGH, HIGH], 0.125),
    point([LOW, HIGH, HIGH], 0.125),
];
