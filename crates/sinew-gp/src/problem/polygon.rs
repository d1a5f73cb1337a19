//! Convex polygons, and functions that vanish on their edges.

use crate::error::{Result, place};
use crate::series::Series;

/// A convex polygon, with its corners in anticlockwise order.
#[derive(Clone, Debug)]
pub struct Polygon {
    corners: Vec<[f64; 2]>,
    /// Unit vector to the inside of the edge that starts at each corner.
    normals: Vec<[f64; 2]>,
}

/// Sine of the least angle between two edges that meet.
const LEAST_TURN: f64 = 1e-9;

/// Cross product of b − a and c − a, positive if the three lie anticlockwise.
fn cross([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]) -> f64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

impl Polygon {
    /// Creates a polygon from its corners, in either sense of rotation.
    ///
    /// # Errors
    /// If there are fewer than three, some are not finite, one is re-entrant, in line with its neighbours or repeated, or edges
    /// cross.
    pub(crate) fn new(corners: &[[f64; 2]]) -> Result<Self> {
        let count = corners.len();
        ensure!(count >= 3, "polygon of {count} vertices: give at least three");
        let finite = corners.as_flattened().iter().all(|c| c.is_finite());
        ensure!(finite, "polygon of {count} vertices: give finite coordinates");
        let area = |corners: &[[f64; 2]]| -> f64 {
            (0..count).map(|i| cross([0.0; 2], corners[i], corners[(i + 1) % count])).sum()
        };
        let mut corners = corners.to_vec();
        if area(&corners) < 0.0 {
            corners.reverse();
        }
        let at = |k: usize| corners[k % count];
        let length = |k: usize| (at(k + 1)[0] - at(k)[0]).hypot(at(k + 1)[1] - at(k)[1]);
        for k in 0..count {
            // Of a repeated corner it is no number.
            let sine = cross(at(k), at(k + 1), at(k + 2)) / (length(k) * length(k + 1));
            ensure!(
                sine > LEAST_TURN,
                "polygon of {count} vertices: its corner {} is re-entrant, in line with its neighbours or given twice; leave it out, or take a convex domain around yours and impose the conditions at points by `Data::imposed`",
                place(&at(k + 1))
            );
        }
        let simple = |i: usize| (2..count).all(|j| cross(at(i), at(i + 1), at(i + j)) > 0.0);
        ensure!(
            (0..count).all(simple),
            "polygon of {count} vertices: edges cross; give the corners in order along the boundary"
        );
        let normal = |k: usize| {
            let [[ax, ay], [bx, by]] = [at(k), at(k + 1)];
            [(ay - by) / length(k), (bx - ax) / length(k)]
        };
        let normals = (0..count).map(normal).collect();
        Ok(Self { corners, normals })
    }

    /// Corners in anticlockwise order.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// Smallest and largest coordinate along each axis.
    pub(crate) fn extents(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|d| {
            let along = self.corners.iter().map(|corner| corner[d]);
            [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    /// Distances from the lines of all edges, positive inside.
    fn distances(&self, x: &Series, y: &Series) -> impl Iterator<Item = Series> {
        let edges = self.corners.iter().zip(&self.normals);
        edges.map(move |([ax, ay], [nx, ny])| (x - *ax) * *nx + (y - *ay) * *ny)
    }

    /// Whether a point lies inside or not farther outside of any edge than a share of the polygon's size.
    pub(crate) fn contains_within(&self, point: [f64; 2], share: f64) -> bool {
        // Distances to lines are rounded.
        let (margin, [x, y]) = (share.max(1e-12) * self.size(), Series::plain(point));
        self.distances(&x, &y).all(|distance| distance.value() >= -margin)
    }

    /// A function of size one that vanishes on all edges and is positive inside, but rises from the edges evenly: the
    /// R₀-conjunction a + b − √(a² + b²) of the distances from one edge after the other (Rvachev, Sheiko, Shapiro &
    /// Tsukanov 2001). It has no derivatives at corners.
    pub(crate) fn conjunction(&self, x: &Series, y: &Series) -> Series {
        let both = |a: Series, b: Series| &a + &b - (a.squared() + b.squared()).sqrt();
        self.distances(x, y).reduce(both).expect("three edges at least") / self.size()
    }

    /// The product of the distances, one at the mean of the corners: smooth, and of the second power at corners.
    pub(crate) fn product(&self, x: &Series, y: &Series) -> Series {
        let middle = [0, 1].map(|d| {
            let sum: f64 = self.corners.iter().map(|corner| corner[d]).sum();
            Series::number(sum / self.corners.len() as f64)
        });
        let shares = self.distances(x, y).zip(self.distances(&middle[0], &middle[1]));
        shares.fold(x.constant(1.0), |product, (distance, most)| product * distance / most.value())
    }

    /// Largest extent.
    pub(crate) fn size(&self) -> f64 {
        self.extents().map(|[low, high]| high - low).into_iter().fold(0.0, f64::max)
    }

    /// The point at `fraction` of the way along edge `edge`, which runs from the corner of that number to the next.
    ///
    /// # Panics
    /// If there is no such edge.
    pub fn on_edge(&self, edge: usize, fraction: f64) -> [f64; 2] {
        let (a, b) = (self.corners[edge], self.corners[(edge + 1) % self.corners.len()]);
        std::array::from_fn(|d| a[d] + fraction * (b[d] - a[d]))
    }
}
