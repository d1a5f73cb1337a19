//! Trilinear hexahedra on \[−1, 1\]³.

use super::{FacetRule, FiniteElement, Nodes, QuadraturePoint, point};

/// Corners in the order of VTK.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

const G: f64 = 0.577_350_269_189_625_8;
/// Gauss' rule of degree 3 along each axis.
const EIGHT_POINTS: &[QuadraturePoint] = &[
    point([-G, -G, -G], 1.0),
    point([G, -G, -G], 1.0),
    point([G, G, -G], 1.0),
    point([-G, G, -G], 1.0),
    point([-G, -G, G], 1.0),
    point([G, -G, G], 1.0),
    point([G, G, G], 1.0),
    point([-G, G, G], 1.0),
];

impl FiniteElement<8> for Nodes<8> {
    const QUADRATURE: &'static [QuadraturePoint] = EIGHT_POINTS;
    const FINE_QUADRATURE: &'static [QuadraturePoint] = EIGHT_POINTS;

    fn shape(at: [f64; 3]) -> [f64; 8] {
        CORNERS.map(|corner| (0..3).map(|i| 0.5 * (1.0 + corner[i] * at[i])).product())
    }

    fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; 8] {
        CORNERS.map(|corner| {
            let factor = |i: usize| 0.5 * (1.0 + corner[i] * at[i]);
            std::array::from_fn(|i| 0.5 * corner[i] * factor((i + 1) % 3) * factor((i + 2) % 3))
        })
    }

    fn facet_rule() -> FacetRule {
        FacetRule::quadrilateral()
    }
}
