//! Linear and quadratic triangles of unit thickness in plane strain.

use super::{FacetRule, FiniteElement, Nodes, QuadraturePoint, point};
use sinew_mesh::{AnyMesh, Mesh};

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

impl FiniteElement<3> for Nodes<3> {
    const QUADRATURE: &'static [QuadraturePoint] = ONE_POINT;
    const FINE_QUADRATURE: &'static [QuadraturePoint] = THREE_POINTS;

    fn shape(at: [f64; 3]) -> [f64; 3] {
        barycentric(at)
    }

    fn shape_derivatives(_at: [f64; 3]) -> [[f64; 3]; 3] {
        SLOPES
    }

    fn facet_rule() -> FacetRule {
        FacetRule::linear_edge()
    }

    fn corner_shape(at: [f64; 3]) -> Vec<f64> {
        barycentric(at).to_vec()
    }

    fn any(mesh: Mesh<3>) -> AnyMesh {
        mesh.into()
    }
}

impl FiniteElement<6> for Nodes<6> {
    const QUADRATURE: &'static [QuadraturePoint] = THREE_POINTS;
    const FINE_QUADRATURE: &'static [QuadraturePoint] = SIX_POINTS;

    fn shape(at: [f64; 3]) -> [f64; 6] {
        let l = barycentric(at);
        std::array::from_fn(|a| match a.checked_sub(3) {
            None => l[a] * (2.0 * l[a] - 1.0),
            Some(edge) => 4.0 * l[EDGES[edge][0]] * l[EDGES[edge][1]],
        })
    }

    fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; 6] {
        let l = barycentric(at);
        std::array::from_fn(|a| {
            std::array::from_fn(|i| match a.checked_sub(3) {
                None => (4.0 * l[a] - 1.0) * SLOPES[a][i],
                Some(edge) => {
                    let [b, c] = EDGES[edge];
                    4.0 * (l[b] * SLOPES[c][i] + l[c] * SLOPES[b][i])
                }
            })
        })
    }

    fn facet_rule() -> FacetRule {
        FacetRule::quadratic_edge()
    }

    fn corner_shape(at: [f64; 3]) -> Vec<f64> {
        barycentric(at).to_vec()
    }

    fn any(mesh: Mesh<6>) -> AnyMesh {
        mesh.into()
    }
}
