//! Linear and quadratic tetrahedra.

use super::{FacetRule, FiniteElement, Nodes, QuadraturePoint, point};
use sinew_mesh::{AnyMesh, Mesh};

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

impl FiniteElement<4> for Nodes<4> {
    const QUADRATURE: &'static [QuadraturePoint] = ONE_POINT;
    const FINE_QUADRATURE: &'static [QuadraturePoint] = FOUR_POINTS;

    fn shape(at: [f64; 3]) -> [f64; 4] {
        barycentric(at)
    }

    fn shape_derivatives(_at: [f64; 3]) -> [[f64; 3]; 4] {
        SLOPES
    }

    fn facet_rule() -> FacetRule {
        FacetRule::linear_triangle()
    }

    fn corner_shape(at: [f64; 3]) -> Vec<f64> {
        barycentric(at).to_vec()
    }

    fn any(mesh: Mesh<4>) -> AnyMesh {
        mesh.into()
    }
}

impl FiniteElement<10> for Nodes<10> {
    const QUADRATURE: &'static [QuadraturePoint] = FOUR_POINTS;
    const FINE_QUADRATURE: &'static [QuadraturePoint] = FOURTEEN_POINTS;

    fn shape(at: [f64; 3]) -> [f64; 10] {
        let l = barycentric(at);
        std::array::from_fn(|a| match a.checked_sub(4) {
            None => l[a] * (2.0 * l[a] - 1.0),
            Some(edge) => 4.0 * l[EDGES[edge][0]] * l[EDGES[edge][1]],
        })
    }

    fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; 10] {
        let l = barycentric(at);
        std::array::from_fn(|a| {
            std::array::from_fn(|i| match a.checked_sub(4) {
                None => (4.0 * l[a] - 1.0) * SLOPES[a][i],
                Some(edge) => {
                    let [b, c] = EDGES[edge];
                    4.0 * (l[b] * SLOPES[c][i] + l[c] * SLOPES[b][i])
                }
            })
        })
    }

    fn facet_rule() -> FacetRule {
        FacetRule::quadratic_triangle()
    }

    fn corner_shape(at: [f64; 3]) -> Vec<f64> {
        barycentric(at).to_vec()
    }

    fn any(mesh: Mesh<10>) -> AnyMesh {
        mesh.into()
    }
}
