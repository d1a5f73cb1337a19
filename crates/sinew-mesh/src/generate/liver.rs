//! A body of the shape of a liver.

use super::implicit::implicit_tetrahedra;
use crate::{TetMesh, boundary_facets};

/// Length that [`IdealLiver`]'s other sizes are in proportion to \[mm\].
const LENGTH: f64 = 150.0;
/// Lobes: centre and semi-axes of ellipsoids \[mm\], the right one thick, the left one thin and long.
const LOBES: [[[f64; 3]; 2]; 2] =
    [[[-27.0, 0.0, 6.0], [48.0, 46.0, 52.0]], [[27.0, 6.0, 4.0], [48.0, 32.0, 24.0]]];
/// Width within which the fold between the lobes is filled \[mm\].
const FOLD: f64 = 14.0;
/// Longest and shortest edges over the length: two through the thin lobe, and a grid that can be held.
const EDGES: [f64; 2] = [0.09, 0.005];

/// An ideal liver: a thick and a thin lobe side by side along x, cut off by the plane z = 0.
///
/// It is no person's liver, and stands in where none is at hand.
///
/// ```
/// let liver = sinew_mesh::IdealLiver { length: 150.0 };
/// let mesh = liver.tetrahedra(12.0);
/// assert!(mesh.node_sets["clamped"].iter().all(|&node| mesh.points[node][2] == 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealLiver {
    /// Length along x \[length\].
    pub length: f64,
}

impl IdealLiver {
    /// Tetrahedra with edges of about `edge` \[length\]. Node and facet sets are `bottom` (z = 0) and `clamped`, the half of it below the
    /// thick lobe.
    ///
    /// # Panics
    /// When the length is not positive and finite, or the edge is not within [`IdealLiver::edges`].
    pub fn tetrahedra(&self, edge: f64) -> TetMesh {
        let [shortest, longest] = self.edges();
        assert!(
            self.length > 0.0 && self.length.is_finite() && (shortest..=longest).contains(&edge),
            "the length {} must be positive, and the edge {edge} between {shortest} and {longest}",
            self.length
        );
        let scale = self.length / LENGTH;
        let ends = |axis: usize, sign: f64| {
            let end = LOBES.map(|[centre, semi]| sign * centre[axis] + semi[axis]);
            scale * end[0].max(end[1])
        };
        let reach = [[ends(0, -1.0), ends(1, -1.0), 0.0], [0, 1, 2].map(|axis| ends(axis, 1.0))];
        let body = |x: [f64; 3]| scale * inside(x.map(|x| x / scale));
        let mut mesh = implicit_tetrahedra(reach, edge, body);
        let boundary = boundary_facets(&mesh);
        mesh.name_side(&boundary, "bottom", |x| x[2] == 0.0);
        mesh.name_side(&boundary, "clamped", |x| x[2] == 0.0 && x[0] <= 0.5 * edge);
        mesh
    }

    /// Shortest and longest edges that it can be made of \[length\].
    pub fn edges(&self) -> [f64; 2] {
        let [longest, shortest] = EDGES;
        [shortest * self.length, longest * self.length]
    }
}

/// Approximate distance from the surface, positive inside \[mm\].
fn inside(x: [f64; 3]) -> f64 {
    let [a, b] = LOBES.map(|[centre, semi]| {
        let part = |power: i32| -> f64 {
            (0..3).map(|i| ((x[i] - centre[i]) / semi[i].powi(power)).powi(2)).sum::<f64>().sqrt()
        };
        let (ratio, slope) = (part(1), part(2));
        if slope == 0.0 { semi[2] } else { (1.0 - ratio) * ratio / slope }
    });
    // Smooth maximum: the fold between the lobes is filled.
    let blend = (1.0 - (a - b).abs() / FOLD).max(0.0);
    a.max(b) + 0.25 * FOLD * blend * blend
}
