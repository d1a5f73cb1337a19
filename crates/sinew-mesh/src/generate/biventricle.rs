//! Two chambers in one wall, the idealised heart.

use super::implicit::implicit_tetrahedra;
use crate::{TetMesh, boundary_facets};

/// Two equal ventricles side by side along x with a septum between them, their apexes at the bottom, cut off by the plane
/// z = 0: the idealised, symmetric pair of thesis B.4.
///
/// The cavities are half ellipsoids of revolution; the outer surface is a smooth union of two larger ones.
///
/// ```
/// let heart = sinew_mesh::Biventricle::default().tetrahedra(5.0);
/// assert!(heart.node_sets["base"].iter().all(|&node| heart.points[node][2] == 0.0));
/// for side in ["endo_left", "endo_right", "epi"] {
///     assert!(!heart.facet_sets[side].is_empty());
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biventricle {
    /// Radius of a cavity at the base \[length\].
    pub radius: f64,
    /// Depth of a cavity \[length\].
    pub depth: f64,
    /// Thickness of the free walls \[length\].
    pub wall: f64,
    /// Thickness of the septum where it is thinnest \[length\].
    pub septum: f64,
}

/// A pair of typical size, in mm.
impl Default for Biventricle {
    fn default() -> Self {
        Self { radius: 20.0, depth: 60.0, wall: 10.0, septum: 10.0 }
    }
}

/// Longest edge \[relative to the wall's thickness\]: the diagonal of a grid cell, 1.73 edges, must be shorter than the
/// wall.
const THICKNESS_SHARE: f64 = 0.55;
/// Most cells of the background grid; with their tetrahedra they take a few gigabytes.
const GRID_CELLS: f64 = 2e6;

impl Biventricle {
    /// Tetrahedra with edges of about `edge` \[length\].
    ///
    /// Node and facet sets are `base`, `endo_left` (negative x), `endo_right`, both together `endo`, and `epi`.
    ///
    /// # Panics
    /// When a size or the edge is not positive and finite, or the edge is not between [`Biventricle::shortest_edge`] and
    /// [`Biventricle::longest_edge`].
    pub fn tetrahedra(&self, edge: f64) -> TetMesh {
        let Self { radius, depth, wall, septum } = *self;
        let sizes = [radius, depth, wall, septum, edge];
        let (shortest, longest) = (self.shortest_edge(), self.longest_edge());
        assert!(
            sizes.iter().all(|size| size.is_finite() && *size > 0.0)
                && (shortest..=longest).contains(&edge),
            "radius, depth, walls and edge must be positive, and an edge at most {THICKNESS_SHARE} of a wall's thickness \
             and at least {shortest}, for a grid of at most {GRID_CELLS} cells, not {sizes:?}"
        );
        let [x, y, down] = self.reach();
        let body = |x| self.outer(x).min(self.cavity(-1.0, x)).min(self.cavity(1.0, x));
        let mut mesh = implicit_tetrahedra([[x, y, down], [x, y, 0.0]], edge, body);
        let boundary = boundary_facets(&mesh);
        let near = 1e-6 * edge;
        let left = |x: [f64; 3]| self.cavity(-1.0, x).abs() < near;
        let right = |x: [f64; 3]| self.cavity(1.0, x).abs() < near;
        mesh.name_side(&boundary, "base", |x| x[2] == 0.0);
        mesh.name_side(&boundary, "endo_left", left);
        mesh.name_side(&boundary, "endo_right", right);
        mesh.name_side(&boundary, "endo", |x| left(x) || right(x));
        mesh.name_side(&boundary, "epi", |x| self.outer(x).abs() < near);
        mesh
    }

    /// Longest allowed edge, 0.55 of the thinnest wall \[length\].
    pub fn longest_edge(&self) -> f64 {
        THICKNESS_SHARE * self.wall.min(self.septum)
    }

    /// Shortest allowed edge \[length\], for a grid of at most two million cells. It exceeds the longest if the walls
    /// are thinner than about a hundredth of the heart.
    pub fn shortest_edge(&self) -> f64 {
        // The margin is widest for the longest edge.
        let room = 2.0 * self.longest_edge();
        let side = self.reach().iter().map(|length| (length + room).cbrt()).product::<f64>();
        side * (4.0 / GRID_CELLS).cbrt()
    }

    /// Lengths from the middle of the base to the outer surface along x, y and down.
    fn reach(&self) -> [f64; 3] {
        let Self { radius, depth, wall, .. } = *self;
        [self.centre() + radius + wall, radius + wall, depth + wall]
    }

    /// Distance of a cavity's axis from the middle of the septum.
    fn centre(&self) -> f64 {
        self.radius + 0.5 * self.septum
    }

    /// Approximate distance from a cavity, negative within it.
    fn cavity(&self, side: f64, [x, y, z]: [f64; 3]) -> f64 {
        -within([x - side * self.centre(), y, z], self.radius, self.depth)
    }

    /// Approximate distance from the outer surface, positive within it.
    fn outer(&self, [x, y, z]: [f64; 3]) -> f64 {
        let Self { radius, depth, wall, .. } = *self;
        let side = |s: f64| within([x - s * self.centre(), y, z], radius + wall, depth + wall);
        let (a, b) = (side(-1.0), side(1.0));
        // Smooth maximum: the fold between the two is filled within a wall's thickness.
        let blend = (1.0 - (a - b).abs() / wall).max(0.0);
        a.max(b) + 0.25 * wall * blend * blend
    }
}

/// Approximate distance to the surface of an ellipsoid of revolution about z, positive within it.
fn within([x, y, z]: [f64; 3], short: f64, long: f64) -> f64 {
    let across = x.hypot(y);
    let ratio = (across / short).hypot(z / long);
    let slope = (across / (short * short)).hypot(z / (long * long));
    if slope == 0.0 { short.min(long) } else { (1.0 - ratio) * ratio / slope }
}
