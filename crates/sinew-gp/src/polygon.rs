//! Simple polygons, and smooth functions that vanish on their edges.

use crate::edge::Edge;
use crate::error::{GpError, Result};
use crate::grid::grid;
use crate::series::Series;

/// A simple polygon, with its corners in anticlockwise order.
#[derive(Clone, Debug)]
pub struct Polygon {
    corners: Vec<[f64; 2]>,
    edges: Vec<Edge>,
    convex: bool,
    /// Reciprocal of the largest distance found inside, so that features have size one.
    scale: f64,
}

/// Twice the signed area of a triangle, positive if anticlockwise.
fn turn([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]) -> f64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

fn unusable(corners: usize, problem: &str) -> GpError {
    GpError::Problem(format!("polygon of {corners} vertices: {problem}"))
}

impl Polygon {
    /// Creates a polygon from its corners, in either sense of rotation.
    ///
    /// # Errors
    /// If there are fewer than three, some are not finite or coincide, edges cross, or there is
    /// no area.
    pub(crate) fn new(corners: &[[f64; 2]]) -> Result<Self> {
        let fail = |problem| Err(unusable(corners.len(), problem));
        if corners.len() < 3 {
            return fail("give at least three");
        }
        if corners.as_flattened().iter().any(|c| !c.is_finite()) {
            return fail("give finite coordinates");
        }
        let count = corners.len();
        let area: f64 =
            (0..count).map(|i| turn([0.0; 2], corners[i], corners[(i + 1) % count])).sum();
        let mut corners = corners.to_vec();
        if area < 0.0 {
            corners.reverse();
        }
        let edge = |i: usize| (corners[i], corners[(i + 1) % count]);
        if (0..count).any(|i| edge(i).0 == edge(i).1) {
            return fail("two corners in a row coincide; give each once");
        }
        let crossing = (0..count)
            .any(|i| (i + 2..count).any(|j| (j + 1) % count != i && cross(edge(i), edge(j))));
        if crossing || area == 0.0 {
            return fail(
                "edges cross or there is no area; give the corners in order along the boundary",
            );
        }
        let edges: Vec<Edge> =
            (0..count).map(|i| Edge::new(corners[i], corners[(i + 1) % count])).collect();
        // Two edges in line count as a notch: each is trimmed to itself.
        let convex = (0..count).all(|i| {
            let (before, after) = (&edges[i], &edges[(i + 1) % count]);
            turn([0.0; 2], before.tangent, after.tangent) > LEAST_TURN
        });
        let polygon = Self { corners, edges, convex, scale: 1.0 };
        let most = polygon.largest(|x, y| polygon.feature(x, y).value());
        Ok(Self { scale: 1.0 / most, ..polygon })
    }

    /// Whether it lies to the left of all its edges and no two are in line.
    pub(crate) fn is_convex(&self) -> bool {
        self.convex
    }

    /// The edges, of which number i starts at corner i.
    pub(crate) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// A distance to one edge that vanishes nowhere else in the polygon.
    pub(crate) fn edge_distance(&self, edge: usize, x: &Series, y: &Series) -> Series {
        let edge = &self.edges[edge];
        if self.convex { edge.height(x, y) } else { edge.trimmed_distance(x, y) }
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

    /// Whether a point lies inside or not farther outside than `margin`.
    pub(crate) fn contains_within(&self, [x, y]: [f64; 2], margin: f64) -> bool {
        // Edges that a ray to the right crosses.
        let ends = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        let crossed = |([ax, ay], [bx, by]): &(&[f64; 2], &[f64; 2])| {
            (*ay > y) != (*by > y) && x < ax + (y - ay) * (bx - ax) / (by - ay)
        };
        ends.filter(crossed).count() % 2 == 1
            || self.edges.iter().any(|edge| edge.distance([x, y]) <= margin)
    }

    /// The feature that vanishes on all edges and is positive, at most about one, inside.
    pub(crate) fn feature(&self, x: &Series, y: &Series) -> Series {
        let all: Vec<usize> = (0..self.edges.len()).collect();
        self.feature_of(&all, x, y) * self.scale
    }

    /// A function that vanishes on some edges only, of any size: Π ωᵢ of a convex polygon, else Π ωᵢ / Σᵢ Πⱼ ωⱼ with j ≠ i, the
    /// R-equivalence (4.56) of order one without its divisions by zero.
    pub(crate) fn feature_of(&self, edges: &[usize], x: &Series, y: &Series) -> Series {
        let distances: Vec<Series> =
            edges.iter().map(|edge| self.edge_distance(*edge, x, y) / self.size()).collect();
        let product = distances.iter().fold(x.constant(self.size()), |product, d| product * d);
        if self.convex {
            return product;
        }
        let others = products_of_others(&distances);
        let sum = others.iter().fold(x.constant(0.0), |sum, other| sum + other);
        if sum.value() == 0.0 {
            // At a corner: the value is zero, derivatives do not exist.
            return product.squared().sqrt();
        }
        product / sum
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

    /// Largest value on a grid over the polygon.
    pub(crate) fn largest(&self, of: impl Fn(&Series, &Series) -> f64) -> f64 {
        const POINTS_PER_AXIS: usize = 40;
        let along = |[low, high]: [f64; 2]| {
            let share = |i: usize| (i as f64 + 0.5) / POINTS_PER_AXIS as f64;
            (0..POINTS_PER_AXIS).map(|i| low + (high - low) * share(i)).collect()
        };
        let points = grid(&self.extents().map(along)).into_iter();
        let value = |point: [f64; 2]| {
            let [x, y] = Series::plain(point);
            of(&x, &y)
        };
        let inside = points.filter(|point| self.contains_within(*point, 0.0));
        inside.map(value).fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// Sine of the angle between two edges up to which they are in line.
const LEAST_TURN: f64 = 1e-9;

/// Product of all other numbers, for each.
pub(crate) fn products_of_others(numbers: &[Series]) -> Vec<Series> {
    (0..numbers.len())
        .map(|own| {
            let others = numbers.iter().enumerate().filter(|(other, _)| *other != own);
            let start = numbers[own].constant(1.0);
            others.fold(start, |product, (_, number)| product * number)
        })
        .collect()
}

/// Whether two segments without a common end have a common point.
fn cross((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    turn(a, b, c) * turn(a, b, d) <= 0.0
        && turn(c, d, a) * turn(c, d, b) <= 0.0
        && (0..2).all(|k| a[k].min(b[k]) <= c[k].max(d[k]) && c[k].min(d[k]) <= a[k].max(b[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn feature(polygon: &Polygon, point: [f64; 2]) -> f64 {
        let [x, y] = Series::plain(point);
        polygon.feature(&x, &y).value()
    }

    /// Winding number by angles: an independent test for lying inside.
    fn inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
        let angle: f64 = (0..corners.len())
            .map(|i| {
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                let (a, b) = ([a[0] - x, a[1] - y], [b[0] - x, b[1] - y]);
                (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
            })
            .sum();
        angle.abs() > 3.0
    }

    #[test]
    fn the_feature_is_positive_exactly_inside() {
        let shapes: [&[[f64; 2]]; 4] = [
            &[[0.0, 1.0], [-0.95, 0.31], [-0.59, -0.81], [0.59, -0.81], [0.95, 0.31]],
            // An L, a notch in a notch, and clockwise.
            &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]],
            &[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [3.0, 1.0], [2.0, 2.0], [1.0, 1.0], [0.0, 3.0]],
            &[[0.0, 2.0], [1.0, 0.5], [2.0, 2.0], [2.0, 0.0], [0.0, 0.0]],
        ];
        for corners in shapes {
            check_feature(corners);
        }
    }

    fn check_feature(corners: &[[f64; 2]]) {
        let polygon = Polygon::new(corners).unwrap();
        let [[left, right], [bottom, top]] = polygon.extents();
        for k in 0..900 {
            let point = [
                left + (right - left) * (f64::from(k % 30) + 0.37) / 30.0,
                bottom + (top - bottom) * (f64::from(k / 30) + 0.41) / 30.0,
            ];
            let within = inside(corners, point);
            assert_eq!(polygon.contains_within(point, 0.0), within, "{point:?}");
            if within {
                let value = feature(&polygon, point);
                assert!(0.0 < value && value < 1.1, "{point:?} {value}");
            }
        }
        for edge in 0..corners.len() {
            let value = feature(&polygon, polygon.on_edge(edge, 0.3));
            assert!(value.abs() < 1e-12, "edge {edge}: {value}");
        }
    }

    #[test]
    fn unusable_polygons_are_refused() {
        for corners in [
            vec![[0.0, 0.0], [1.0, 0.0]],
            vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            vec![[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]],
            vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]],
        ] {
            assert!(Polygon::new(&corners).is_err(), "{corners:?}");
        }
    }
}
