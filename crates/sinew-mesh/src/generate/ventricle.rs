//! Truncated ellipsoids, the idealised left ventricle.

use super::grid_coordinate;
use super::wall::{InSet, Sheet, Wall, between, side};
use std::f64::consts::{FRAC_PI_4, PI};

/// The wall between two ellipsoids of revolution around the z axis with their apexes at the bottom, cut
/// off by a plane: the idealised left ventricle of Land et al., Proc. R. Soc. A 471:20150641 (2015).
///
/// A surface of the wall at depth t is x = r sin u cos v, y = r sin u sin v, z = l cos u with semi-axes
/// r and l linear in t, from the apex u = −π to the base u = −acos(z_base / l). At the apex lies a square
/// patch of cells, so that none of them degenerates.
///
/// ```
/// use sinew_mesh::TruncatedEllipsoid;
/// // Two layers, 16 cells around and 8 from the apex to the base.
/// let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).quadratic_tetrahedra();
/// let [endo, epi] = ["apex_endo", "apex_epi"].map(|apex| mesh.points[mesh.node_sets[apex][0]]);
/// assert_eq!((endo, epi), ([0.0, 0.0, -17.0], [0.0, 0.0, -20.0]));
/// assert_eq!(mesh.facet_sets["endo"].len(), 2 * (4 * 4 + 16 * 6));
/// assert!(mesh.node_sets["base"].iter().all(|&node| mesh.points[node][2] == 5.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedEllipsoid {
    /// Inner and outer semi-axis across.
    pub short: [f64; 2],
    /// Inner and outer semi-axis along z.
    pub long: [f64; 2],
    /// Height z of the plane of the base.
    pub base: f64,
}

impl TruncatedEllipsoid {
    /// Problems 2 and 3 of Land et al. (2015), in mm.
    pub const LAND: Self = TruncatedEllipsoid { short: [7.0, 10.0], long: [17.0, 20.0], base: 5.0 };

    /// The whole wall, `cells` of which are the layers, the cells around (a multiple of 8) and those
    /// from the apex to the base, of which an eighth of the cells around belong to the patch.
    ///
    /// The sides are `base`, `endo` (inner) and `epi` (outer); the node sets `apex_endo` and `apex_epi`
    /// hold one node each.
    ///
    /// # Panics
    /// When the semi-axes are not positive, finite and ascending, the base does not cut both ellipsoids,
    /// a cell count is zero, the cells around are not a multiple of 8 or not less than 8 times those along.
    pub fn wall(&self, cells: [usize; 3]) -> Wall {
        let TruncatedEllipsoid { short, long, base } = *self;
        for (what, [inner, outer]) in [("short", short), ("long", long)] {
            assert!(
                inner > 0.0 && outer > inner && outer.is_finite(),
                "the {what} semi-axes must be positive and ascending, not {inner} and {outer}"
            );
        }
        assert!(cells.iter().all(|&n| n > 0), "cell counts must be at least 1, not {cells:?}");
        assert!(base.abs() < long[0], "the base at z = {base} does not cut the inner ellipsoid");
        let [layers, around, along] = cells;
        assert!(
            around % 8 == 0 && around < 8 * along,
            "the cells around must be a multiple of 8 and less than 8 times the {along} cells along, \
             not {around}"
        );
        let disk = Disk { half: around / 8, along };
        let ellipsoid = *self;
        let apex = |depth: f64| -> InSet { Box::new(move |at| at == [0.0, 0.0, depth]) };
        Wall {
            sheet: disk.sheet(),
            layers,
            lift: |[a, b, _], depth| [a, b, depth],
            depth: |[_, _, depth]| depth,
            place: Box::new(move |[a, b, depth]| ellipsoid.place(disk.place([a, b]), depth)),
            sides: vec![
                ("base", Box::new(|[a, b, _]| a.abs().max(b.abs()) == 1.0)),
                ("endo", side(2, 0.0)),
                ("epi", side(2, 1.0)),
            ],
            nodes: vec![("apex_endo", apex(0.0)), ("apex_epi", apex(1.0))],
        }
    }

    /// The point over a point of the unit disk, whose centre is the apex and whose rim is the base.
    fn place(&self, [x, y]: [f64; 2], depth: f64) -> [f64; 3] {
        let (short, long) = (between(self.short, depth), between(self.long, depth));
        let radius = x.hypot(y);
        let angle = radius * (PI - (self.base / long).acos());
        // sin u cos v with v the angle in the disk; the rim must not leave the plane by rounding.
        let across = if radius == 0.0 { 0.0 } else { short * angle.sin() / radius };
        let z = if radius > RIM { self.base } else { -long * angle.cos() };
        [across * x, across * y, z]
    }
}

/// Nodes further from the disk's centre than this are on its rim.
const RIM: f64 = 1.0 - 1e-12;

/// The unit disk as the image of a square: a patch of cells in its middle, and rings of cells around.
#[derive(Clone, Copy)]
pub(super) struct Disk {
    /// Cells from the centre to a side of the patch, an eighth of those around.
    pub half: usize,
    /// Cells from the centre to the rim.
    pub along: usize,
}

/// Size of the patch's corners over that of a square inscribed in the same ring, and how far its sides
/// bulge, so that the three cells which meet at a corner of the patch have about equal angles.
const CORNER: f64 = 0.78;
const BULGE: f64 = 0.15;

impl Disk {
    /// The square `[-1, 1]²` as a sheet in the plane.
    pub(super) fn sheet(&self) -> Sheet {
        let half = self.half as i64;
        let mut sheet = Sheet::default();
        let node = |[i, j]: [i64; 2], ring: usize| {
            let scale = self.scale(ring);
            ([i, j, ring as i64], [i, j, 0].map(|at| scale * (at as f64 / half as f64)))
        };
        sheet.patch([2 * self.half; 2], |at| node(at.map(|k| k - half), 0));
        for ring in 0..self.along - self.half {
            for [a, b] in rim(half) {
                let (low, high) = (ring, ring + 1);
                sheet.quad([node(a, low), node(a, high), node(b, high), node(b, low)]);
            }
        }
        sheet
    }

    /// Half the side of the square that is the inner side of a ring, exactly 1 behind the last.
    fn scale(&self, ring: usize) -> f64 {
        grid_coordinate(self.half + ring, self.along, 1.0)
    }

    pub(super) fn place(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let (size, patch) = (a.abs().max(b.abs()), self.scale(0));
        if size <= patch {
            return self.place_in_patch([a, b]);
        }
        let [p, q] = [a / size, b / size];
        let inner = self.place_in_patch([patch * p, patch * q]);
        let outer = if p.abs() >= q.abs() {
            let (sin, cos) = (FRAC_PI_4 * q).sin_cos();
            [cos.copysign(p), sin]
        } else {
            let (sin, cos) = (FRAC_PI_4 * p).sin_cos();
            [sin, cos.copysign(q)]
        };
        let way = (size - patch) / (1.0 - patch);
        [0, 1].map(|axis| between([inner[axis], outer[axis]], way))
    }

    fn place_in_patch(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let patch = self.scale(0);
        let bulge = |across: f64| CORNER * (1.0 + BULGE * (1.0 - (across / patch).powi(2)));
        [a * bulge(b), b * bulge(a)]
    }
}

/// The edges around the square `[-half, half]²` counterclockwise.
fn rim(half: i64) -> impl Iterator<Item = [[i64; 2]; 2]> {
    let along = move |k: i64| [[k, -half], [half, k], [-k, half], [-half, -k]];
    (-half..half).flat_map(move |k| (0..4).map(move |s| [along(k)[s], along(k + 1)[s]]))
}
