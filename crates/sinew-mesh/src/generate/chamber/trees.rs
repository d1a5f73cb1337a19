//! The surfaces of a chamber, met by rays.

use crate::Refusal;
use crate::tree::SurfaceTree;
use nalgebra::Vector3;

pub(super) type Point = Vector3<f64>;

/// Result of a step towards a wall.
pub(super) type Result<T, E = Refusal> = std::result::Result<T, E>;

/// A point or direction as people read it.
pub(super) fn shown(point: impl Into<[f64; 3]>) -> String {
    let [x, y, z] = point.into();
    format!("({x:.3}, {y:.3}, {z:.3})")
}

/// Hits nearer than this, relative to the ray's direction of unit length, are the surface that the ray leaves \[length\].
const LEAVES: f64 = 1e-9;

/// The surfaces, ready for rays.
pub(super) struct Trees {
    pub endocardium: SurfaceTree,
    pub epicardium: SurfaceTree,
    pub septum: Option<SurfaceTree>,
}

impl Trees {
    /// Way along a ray of unit direction to the nearest outer surface, and whether that is the septum.
    pub(super) fn outside(&self, origin: Point, direction: Point) -> Option<(f64, bool)> {
        let first =
            |tree: &SurfaceTree| tree.hits(origin, direction).into_iter().find(|&way| way > LEAVES);
        let epicardium = first(&self.epicardium).map(|way| (way, false));
        let septum = self.septum.as_ref().and_then(first).map(|way| (way, true));
        // At the same distance it is the epicardium.
        epicardium.into_iter().chain(septum).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
