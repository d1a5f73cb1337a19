//! Linear and quadratic triangles of unit thickness in plane strain.

use super::simplices::simplices;
use super::{FacetRule, FiniteElement, Nodes, QuadraturePoint, point};

const EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];
const SLOPES: [[f64; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

const THIRD: f64 = 1.0 / 3.0;
const ONE_POINT: &[QuadraturePoint] = &[point([THIRD, THIRD, 0.0], 0.5)];

const A: f64 = 1.0 / 6.0;
const B: f64 = 2.0 / 3.0;
/// Degree 2.
const THREE_POINTS: &[QuadraturePoint] =
    &[point([A, A, 0.0], A), point([B, A, 0.0], A), point([A, B, 0.0], A)];

const C: f64 = 0.445_948_490_915_965;
const D: f64 = 0.091_576_213_509_771;
const WEIGHT_C: f64 = 0.5 * 0.223_381_589_678_011;
const WEIGHT_D: f64 = 0.5 * 0.109_951_743_655_322;
/// Degree 4 (D. A. Dunavant, Int. J. Numer. Meth. Engng 21, 1985).
pub(super) const SIX_POINTS: &[QuadraturePoint] = &[
    point([C, C, 0.0], WEIGHT_C),
    point([1.0 - 2.0 * C, C, 0.0], WEIGHT_C),
    point([C, 1.0 - 2.0 * C, 0.0], WEIGHT_C),
    point([D, D, 0.0], WEIGHT_D),
    point([1.0 - 2.0 * D, D, 0.0], WEIGHT_D),
    point([D, 1.0 - 2.0 * D, 0.0], WEIGHT_D),
];

fn barycentric([x, y, _]: [f64; 3]) -> [f64; 3] {
    [1.0 - x - y, x, y]
}

simplices! {
    3: ONE_POINT, THREE_POINTS, linear_edge;
    6: THREE_POINTS, SIX_POINTS, quadratic_edge
}
