//! Linear and quadratic tetrahedra.

use super::simplices::simplices;
use super::{FacetRule, FiniteElement, Nodes, QuadraturePoint, point};

/// Edges in the order of VTK's quadratic tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Derivatives of the barycentric coordinates.
const SLOPES: [[f64; 3]; 4] = [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

const ONE_POINT: &[QuadraturePoint] = &[point([0.25; 3], 1.0 / 6.0)];

const A: f64 = 0.138_196_601_125_010_5;
const B: f64 = 0.585_410_196_624_968_5;
/// Degree 2.
const FOUR_POINTS: &[QuadraturePoint] = &[
    point([A, A, A], 1.0 / 24.0),
    point([B, A, A], 1.0 / 24.0),
    point([A, B, A], 1.0 / 24.0),
    point([A, A, B], 1.0 / 24.0),
];

const C: f64 = 0.310_885_919_263_300_6;
const D: f64 = 0.092_735_250_310_891_22;
const E: f64 = 0.045_503_704_125_649_65;
const F: f64 = 0.5 - E;
const WEIGHT_C: f64 = 0.112_687_925_718_015_85 / 6.0;
const WEIGHT_D: f64 = 0.073_493_043_116_361_95 / 6.0;
const WEIGHT_E: f64 = 0.042_546_020_777_081_47 / 6.0;
/// Degree 5, all weights positive (N. J. Walkington, "Quadrature on simplices of arbitrary dimension", 2000).
const FOURTEEN_POINTS: &[QuadraturePoint] = &[
    point([C, C, C], WEIGHT_C),
    point([1.0 - 3.0 * C, C, C], WEIGHT_C),
    point([C, 1.0 - 3.0 * C, C], WEIGHT_C),
    point([C, C, 1.0 - 3.0 * C], WEIGHT_C),
    point([D, D, D], WEIGHT_D),
    point([1.0 - 3.0 * D, D, D], WEIGHT_D),
    point([D, 1.0 - 3.0 * D, D], WEIGHT_D),
    point([D, D, 1.0 - 3.0 * D], WEIGHT_D),
    point([E, E, F], WEIGHT_E),
    point([E, F, E], WEIGHT_E),
    point([F, E, E], WEIGHT_E),
    point([E, F, F], WEIGHT_E),
    point([F, E, F], WEIGHT_E),
    point([F, F, E], WEIGHT_E),
];

fn barycentric([x, y, z]: [f64; 3]) -> [f64; 4] {
    [1.0 - x - y - z, x, y, z]
}

simplices! {
    4: ONE_POINT, FOUR_POINTS, linear_triangle;
    10: FOUR_POINTS, FOURTEEN_POINTS, quadratic_triangle
}
