//! Domain of a problem: boxes, and convex polygons with functions that vanish on their edges.

use crate::error::place;
use crate::series::Series;
use crate::{Derivative, GpError, Result};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// One end of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Least coordinate; the start of a time axis.
    Lower,
    /// Largest coordinate.
    Upper,
}

impl Side {
    /// Both, lower first.
    pub const BOTH: [Self; 2] = [Self::Lower, Self::Upper];
}

/// A box with named axes, or a convex polygon in a box of two.
#[derive(Clone, Debug)]
pub struct Domain<const D: usize> {
    names: [String; D],
    /// Coordinates of both ends of each axis.
    pub(crate) ends: [[f64; 2]; D],
    polygon: Option<Polygon>,
}

impl Domain<1> {
    /// An interval.
    ///
    /// # Errors
    /// If its ends are not in ascending order.
    pub fn interval(name: &str, ends: [f64; 2]) -> Result<Self> {
        Self::cuboid([(name, ends)])
    }
}

impl Domain<2> {
    /// A convex polygon, with its corners in order along the boundary.
    ///
    /// Values on its boundary are held by [`crate::Problem::boundary`]. Where the Laplacian leads the equation, solutions are rougher
    /// at corners than functions of a prior (like r^(π/α) at an angle α), about re-entrant ones so much that these are refused: imposed at
    /// points of the boundary ([`crate::Data::imposed`]) conditions give smaller errors there.
    ///
    /// # Errors
    /// If it has fewer than three corners, repeated or re-entrant ones, or edges that cross.
    pub fn polygon(names: [&str; 2], corners: &[[f64; 2]]) -> Result<Self> {
        let polygon = Polygon::new(corners)?;
        let [x, y] = polygon.extents();
        Ok(Self { polygon: Some(polygon), ..Self::cuboid([(names[0], x), (names[1], y)])? })
    }
}

impl<const D: usize> Domain<D> {
    /// A box, from a name and the two ends for each axis.
    ///
    /// # Errors
    /// If there are more than three axes or none, the ends of an axis are not in ascending order, or a name repeats.
    pub fn cuboid(axes: [(&str, [f64; 2]); D]) -> Result<Self> {
        ensure!((1..=3).contains(&D), "a domain of {D} axes; give it one to three");
        for (d, (name, [lower, upper])) in axes.iter().enumerate() {
            // Neither end nor their distance may overflow.
            ensure!(
                (upper - lower).is_finite() && lower < upper,
                "axis {name} runs from {lower} to {upper}; give finite bounds in ascending order"
            );
            let new = axes[..d].iter().all(|(earlier, _)| earlier != name);
            ensure!(new, "two axes are called {name}; name each axis once");
        }
        Ok(Self {
            names: axes.map(|(name, _)| name.to_string()),
            ends: axes.map(|(_, ends)| ends),
            polygon: None,
        })
    }

    /// The operators ∂/∂x of all axes.
    pub fn derivatives(&self) -> [Derivative<D>; D] {
        std::array::from_fn(Derivative::along)
    }

    /// Names of the axes.
    pub fn names(&self) -> &[String; D] {
        &self.names
    }

    /// Lower and upper end of each axis, of the bounding box for a polygon.
    pub fn ends(&self) -> [[f64; 2]; D] {
        self.ends
    }

    /// Length of each axis.
    pub(crate) fn extents(&self) -> [f64; D] {
        self.ends.map(|[lower, upper]| upper - lower)
    }

    /// Distance of two points in units of the lengths of the axes.
    pub(crate) fn apart(&self, a: &[f64; D], b: &[f64; D]) -> f64 {
        let axis = |d: usize| ((a[d] - b[d]) / self.extents()[d]).powi(2);
        (0..D).map(axis).sum::<f64>().sqrt()
    }

    /// The polygon that restricts the axes, if any.
    pub fn cross_section(&self) -> Option<&Polygon> {
        self.polygon.as_ref()
    }

    /// Position of an axis.
    ///
    /// # Errors
    /// If no axis has that name.
    pub(crate) fn axis(&self, name: &str) -> Result<usize> {
        self.names.iter().position(|n| n == name).ok_or_else(|| {
            let axes = self.names.join(", ");
            GpError::Invalid(format!("there is no axis {name}; the domain has {axes}"))
        })
    }

    /// Position of an axis that is no part of a polygon, for which an error says what to use.
    pub(crate) fn free_axis(&self, name: &str, instead: &str) -> Result<usize> {
        let axis = self.axis(name)?;
        ensure!(self.polygon.is_none(), "{name} is part of the polygon; use {instead}");
        Ok(axis)
    }

    /// A face in words, as `x = 0`.
    pub(crate) fn face(&self, axis: usize, side: Side) -> String {
        format!("{} = {}", self.names[axis], self.ends[axis][side as usize])
    }

    /// Whether a point lies in the domain or on its boundary.
    pub fn contains(&self, point: [f64; D]) -> bool {
        self.contains_within(point, 0.0)
    }

    /// Whether a point lies in the domain or next to it, by no more than `share` of the domain's size.
    pub(crate) fn contains_within(&self, point: [f64; D], share: f64) -> bool {
        let along = |d: usize| {
            let ([lower, upper], margin) = (self.ends[d], share * self.extents()[d]);
            (lower - margin..=upper + margin).contains(&point[d])
        };
        let across = |polygon: &Polygon| polygon.contains_within([point[0], point[1]], share);
        (0..D).all(along) && self.polygon.as_ref().is_none_or(across)
    }

    /// Points drawn uniformly.
    ///
    /// # Errors
    /// If a polygon fills less than about a thousandth of its bounding box.
    pub fn sample(&self, count: usize, seed: u64) -> Result<Vec<[f64; D]>> {
        const TRIES_PER_POINT: usize = 1000;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |_| self.ends.map(|[lower, upper]| random.random_range(lower..upper));
        let tries = (0..TRIES_PER_POINT * (count + 1)).map(draw);
        let points: Vec<_> = tries.filter(|point| self.contains(*point)).take(count).collect();
        ensure!(
            points.len() == count,
            "the domain's polygon has too small a share of its bounding box to sample from; turn it along the axes, or give points of your own"
        );
        Ok(points)
    }

    /// Points on the face at one end of an axis, drawn uniformly.
    ///
    /// # Errors
    /// If there is no such axis, or it belongs to a polygon.
    pub fn on_face(
        &self,
        axis: &str,
        side: Side,
        count: usize,
        seed: u64,
    ) -> Result<Vec<[f64; D]>> {
        let axis = self.free_axis(axis, "`Polygon::on_edge` for points on its edges")?;
        let mut points = self.sample(count, seed)?;
        points.iter_mut().for_each(|point| point[axis] = self.ends[axis][side as usize]);
        Ok(points)
    }

    /// The points of a regular grid, `count` along each axis including the ends, that lie in the
    /// domain; the last axis runs fastest.
    pub fn grid(&self, count: usize) -> Vec<[f64; D]> {
        let steps = count.saturating_sub(1).max(1) as f64;
        let along = |d: usize| {
            let place = |k: usize| self.ends[d][0] + k as f64 / steps * self.extents()[d];
            (0..count).map(place).collect()
        };
        let points = grid(&std::array::from_fn(along)).into_iter();
        points.filter(|point| self.contains(*point)).collect()
    }
}

/// All combinations of one entry for each axis; the last axis runs fastest.
pub(crate) fn grid<T: Copy + Default, const D: usize>(axes: &[Vec<T>; D]) -> Vec<[T; D]> {
    let mut all = vec![[T::default(); D]];
    for (d, axis) in axes.iter().enumerate() {
        let extended = all.iter().flat_map(|point| {
            axis.iter().map(move |entry| {
                let mut point = *point;
                point[d] = *entry;
                point
            })
        });
        all = extended.collect();
    }
    all
}

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
