//! The surface of a body: triangles over their own nodes, with fibres.

use sinew_energy::Body;
use sinew_mesh::AnyMesh;
use sinew_report::{LineSegments, Packed};

/// Most fibres that are drawn.
const MOST_STROKES: usize = 2500;
/// Length of a fibre's line relative to the root of its triangle's area.
const STROKE: f64 = 0.9;
/// Part of a fibre that must lie in the surface, or its direction there says little.
const LEAST_WITHIN: f64 = 0.3;

/// Triangles of a mesh's boundary.
pub(crate) struct Surface {
    /// Nodes of the mesh, in order.
    pub(super) nodes: Vec<usize>,
    /// Corners among these.
    triangles: Vec<[usize; 3]>,
    /// Cell behind each triangle.
    cells: Vec<usize>,
}

impl Surface {
    /// `None` for a mesh without a surface in three dimensions.
    pub(crate) fn of(mesh: &AnyMesh) -> Option<Self> {
        let (triangles, cells) = mesh.boundary_triangles();
        let mut nodes: Vec<usize> = triangles.as_flattened().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        let rank = |node: usize| nodes.partition_point(|&other| other < node);
        let triangles: Vec<_> = triangles.iter().map(|corners| corners.map(rank)).collect();
        (!triangles.is_empty()).then_some(Self { nodes, triangles, cells })
    }

    /// Place of a node of the mesh among those of the surface.
    pub(super) fn place(&self, node: usize) -> Option<u32> {
        self.nodes.binary_search(&node).ok().map(|place| place as u32)
    }

    /// Components of a displacement that belong to the surface.
    pub(super) fn rows(&self) -> Vec<usize> {
        self.nodes.iter().flat_map(|&node| [3 * node, 3 * node + 1, 3 * node + 2]).collect()
    }

    /// Displacement at the surface \[length\].
    pub(crate) fn of_field(&self, field: &[f64]) -> Vec<f64> {
        self.nodes.iter().flat_map(|&node| field[3 * node..3 * node + 3].to_vec()).collect()
    }

    pub(super) fn positions(&self, points: &[[f64; 3]]) -> Packed {
        Packed::f32(self.nodes.iter().flat_map(|&node| points[node].map(|x| x as f32)))
    }

    pub(super) fn packed(&self) -> Packed {
        Packed::u32(self.triangles.as_flattened().iter().map(|&corner| corner as u32))
    }

    /// Fibres of the cells behind the surface, in its triangles; `None` for an isotropic law.
    pub(super) fn strokes(&self, body: &Body) -> Option<LineSegments> {
        let every = self.triangles.len().div_ceil(MOST_STROKES);
        let (mut triangles, mut along) = (Vec::new(), Vec::new());
        for (index, (&corners, &cell)) in self.triangles.iter().zip(&self.cells).enumerate() {
            let fibre = *body.material.directions(cell * body.points_per_cell).first()?;
            let corners = corners.map(|corner| body.positions[self.nodes[corner]]);
            if index.is_multiple_of(every)
                && let Some(stroke) = within(corners, fibre)
            {
                triangles.push(index as u32);
                along.extend(stroke.map(|part| part as f32));
            }
        }
        Some(LineSegments { triangles: Packed::u32(triangles), along: Packed::f32(along) })
    }
}

/// Half of a line along a direction in a triangle, in parts of the sides from its first corner; `None` where the direction
/// leaves the triangle's plane.
fn within([a, b, c]: [[f64; 3]; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
    let dot = |x: &[f64; 3], y: &[f64; 3]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let side = |end: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| end[i] - a[i]) };
    let (p, q) = (side(b), side(c));
    let (pp, pq, qq) = (dot(&p, &p), dot(&p, &q), dot(&q, &q));
    // Four times the square of the area.
    let square = pp * qq - pq * pq;
    let (by_p, by_q) = (dot(&direction, &p), dot(&direction, &q));
    let parts = [(qq * by_p - pq * by_q) / square, (pp * by_q - pq * by_p) / square];
    let inside: [f64; 3] = std::array::from_fn(|i| parts[0] * p[i] + parts[1] * q[i]);
    let length = dot(&inside, &inside).sqrt();
    let half = 0.5 * STROKE * (0.5 * square.sqrt()).sqrt() / length;
    (length >= LEAST_WITHIN && half.is_finite()).then_some(parts.map(|part| half * part))
}
