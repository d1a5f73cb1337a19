//! The axis of a ventricle, and the plane of its base.

use super::size::Trim;
use super::trees::{Point, Result, Trees, shown};
use crate::geometry::merged;
use crate::quality::Spread;
use crate::{Refusal, TriangleMesh};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Rays of a section.
const RAYS: usize = 64;
/// A rim counts as plane when its points are within this fraction of the axis' length of a plane.
const PLANE: f64 = 0.01;
/// Distance below its rim at which a surface is cut, so that rays still meet it \[relative to the axis' length\].
const BELOW: f64 = 1e-4;
/// Step of the search for a base, and where it ends, relative to the axis' length.
const STEP: f64 = 0.01;
const LOWEST: f64 = 0.4;
/// Least thickness at the base relative to its median there.
const THIN: f64 = 0.5;
/// Two points on a ray nearer than this, relative to their distance from its start, are one: an edge of two triangles.
const SAME: f64 = 1e-6;

/// Axis from the apex to the middle of the valves; its length is zero if the endocardium is closed.
#[derive(Default)]
pub(super) struct Axis {
    apex: Point,
    /// Unit direction from the apex to the base.
    up: Point,
    length: f64,
    /// Points of the rims.
    rim: Vec<Point>,
    /// Normal of the plane that they lie in.
    rim_normal: Option<Point>,
    points: Vec<Point>,
}

/// The plane that the wall ends at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    /// Middle of the cavity there.
    pub centre: Point,
    /// Unit normal away from the apex.
    pub normal: Point,
    /// The point of the endocardium farthest below.
    pub apex: Point,
}

impl Axis {
    pub(super) fn new(endocardium: &TriangleMesh) -> Self {
        let points: Vec<Point> = endocardium.points.iter().map(|&x| x.into()).collect();
        let edges = rims(endocardium).into_iter();
        let ends: Vec<[Point; 2]> = edges.map(|edge| edge.map(|node| points[node])).collect();
        let Some(middle) = middle(ends.iter().copied()) else {
            return Self { points, ..Self::default() };
        };
        let apex = farthest(&points, |x| (x - middle).norm_squared());
        let length = (middle - apex).norm();
        let up = (middle - apex) / length;
        // The vector area of the rims; edges run along their triangles, so their order does not matter.
        let area: Point = ends.iter().map(|[a, b]| (a - middle).cross(&(b - middle))).sum();
        let rim: Vec<Point> = ends.iter().map(|[a, _]| *a).collect();
        let normal = area.try_normalize(0.0).map(|n| if n.dot(&up) < 0.0 { -n } else { n });
        let is_plane = |n: &Point| rim.iter().all(|x| (x - middle).dot(n).abs() < PLANE * length);
        let rim_normal = normal.filter(is_plane);
        Self { apex, up, length, rim, rim_normal, points }
    }

    /// Finds the base; none where no plane is one.
    pub(super) fn base(&self, trees: &Trees, trim: &Trim) -> Result<Option<Base>> {
        match *trim {
            Trim::Plane { point, normal } => {
                let (point, normal) = (Point::from(point), Point::from(normal));
                let finite = point.iter().chain(&normal).all(|x| x.is_finite());
                let normal = normal.try_normalize(0.0).filter(|_| finite).ok_or_else(|| {
                    Refusal("the plane of the base has no normal; give a fraction between 0 and 1, or a point and a normal of finite length".into())
                })?;
                let centroid = self.points.iter().sum::<Point>() / self.points.len() as f64;
                let away = if self.length > 0.0 { self.up } else { point - centroid };
                let normal = if normal.dot(&away) < 0.0 { -normal } else { normal };
                let below = self.points.iter().filter(|x| (*x - point).dot(&normal) < 0.0);
                let count = below.clone().count();
                let middle = below.sum::<Point>() / count.max(1) as f64;
                let start = middle - normal * (middle - point).dot(&normal);
                Ok(Some(Section::new(trees, start, normal)?.base(self)))
            }
            _ if self.rim.is_empty() => Err(Refusal("the endocardium is closed, so nothing says where its base is; give the plane of the base: a point and a normal".into())),
            Trim::Fraction(part) if part > 0.0 && part <= 1.0 => {
                let start = self.apex + self.up * (part.min(1.0 - BELOW) * self.length);
                Ok(Some(Section::new(trees, start, self.up)?.base(self)))
            }
            Trim::Fraction(part) => Err(Refusal(format!(
                "the base cannot be at {part} of the axis; give a fraction between 0 and 1, or a point and a normal of finite length"
            ))),
            Trim::Auto => Ok(self.highest(trees)),
        }
    }

    fn highest(&self, trees: &Trees) -> Option<Base> {
        let normal = self.rim_normal.unwrap_or(self.up);
        let heights = self.rim.iter().map(|x| (x - self.apex).dot(&normal));
        let mut height = heights.fold(f64::INFINITY, f64::min) - BELOW * self.length;
        while height > LOWEST * self.length {
            let start = self.apex + self.up * (height / self.up.dot(&normal));
            if let Ok(section) = Section::new(trees, start, normal)
                && section.is_whole(trees)
            {
                return Some(section.base(self));
            }
            height -= STEP * self.length;
        }
        None
    }

    pub(super) fn no_base(&self) -> Refusal {
        let [apex, axis] = [self.apex, self.up].map(shown);
        Refusal(format!(
            "no plane across the axis from {apex} along {axis} cuts a whole wall below the valves; give the plane of the base: a point and a normal"
        ))
    }
}

/// The middle of edges, longer ones with more weight; none where they have no length.
fn middle(edges: impl Iterator<Item = [Point; 2]> + Clone) -> Option<Point> {
    let length: f64 = edges.clone().map(|[a, b]| (b - a).norm()).sum();
    let sum: Point = edges.map(|[a, b]| (a + b) * ((b - a).norm() / 2.0)).sum();
    (length > 0.0).then(|| sum / length)
}

fn farthest(points: &[Point], measure: impl Fn(&Point) -> f64) -> Point {
    let best = points.iter().max_by(|a, b| measure(a).total_cmp(&measure(b)));
    best.copied().unwrap_or_default()
}

/// The edges that belong to one triangle only, along it; points at the same place are one.
pub(super) fn rims(surface: &TriangleMesh) -> Vec<[usize; 2]> {
    let place = merged(&surface.points, |_| 0.0);
    let edges = surface.cells.iter().flat_map(|cell| {
        let [a, b, c] = cell.map(|node| place[node]);
        [[a, b], [b, c], [c, a]]
    });
    let mut count: HashMap<[usize; 2], usize> = HashMap::new();
    edges.clone().for_each(|[a, b]| *count.entry([a.min(b), a.max(b)]).or_insert(0) += 1);
    edges.filter(|&[a, b]| count[&[a.min(b), a.max(b)]] == 1).collect()
}

/// The cavity in a plane, seen from its middle.
pub(super) struct Section {
    pub centre: Point,
    normal: Point,
    ends: Vec<Point>,
}

impl Section {
    /// Rays in the plane from a point in the cavity, moved to the middle of what they meet.
    pub(super) fn new(trees: &Trees, start: Point, normal: Point) -> Result<Self> {
        let [across, along] = frame(normal, None);
        let mut centre = start;
        let mut ends = Vec::new();
        for _ in 0..6 {
            let end = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / RAYS as f64).sin_cos();
                wall(trees, centre, across * cos + along * sin)
            };
            ends = (0..RAYS).map(end).collect::<Result<_, _>>()?;
            // The middle of the polygon's edges, which does not depend on how rays are spread.
            let edges = (0..RAYS).map(|k| [ends[k], ends[(k + 1) % RAYS]]);
            let next = middle(edges).unwrap_or(start);
            centre = next - normal * (next - start).dot(&normal);
        }
        Ok(Self { centre, normal, ends })
    }

    /// Whether there is a wall all around, nowhere much thinner than elsewhere.
    fn is_whole(&self, trees: &Trees) -> bool {
        let outward = self.ends.iter().map(|end| (*end, (end - self.centre).normalize()));
        let ways: Option<Vec<f64>> =
            outward.map(|(end, way)| Some(trees.outside(end, way)?.0)).collect();
        ways.and_then(Spread::of).is_some_and(|ways| ways.min > THIN * ways.median)
    }

    fn base(&self, axis: &Axis) -> Base {
        let below = |x: &Point| -(x - self.centre).dot(&self.normal);
        // Without rims, the apex is the lowest point.
        let apex = if axis.length > 0.0 { axis.apex } else { farthest(&axis.points, below) };
        Base { centre: self.centre, normal: self.normal, apex }
    }
}

/// Point at which a ray from the cavity meets the endocardium.
pub(super) fn wall(trees: &Trees, origin: Point, direction: Point) -> Result<Point> {
    let hits = trees.endocardium.hits(origin, direction);
    let (Some(&first), Some(&last)) = (hits.first(), hits.last()) else {
        let [from, way] = [origin, direction].map(shown);
        return Err(Refusal(format!(
            "the endocardium has a hole below the base: nothing lies from {from} along {way}; put the base further down, or close the hole"
        )));
    };
    let point = origin + direction * first;
    if last - first > SAME * last {
        return Err(Refusal(format!(
            "seen from its axis the endocardium lies behind itself at {}; smooth its folds and papillary muscles, or put the base further down",
            shown(point)
        )));
    }
    Ok(point)
}

/// Two unit directions perpendicular to a unit normal and to each other, the first as near to a hint as can be.
pub(super) fn frame(normal: Point, hint: Option<Point>) -> [Point; 2] {
    let axis = Point::ith(normal.iamin(), 1.0);
    let flat = |x: Point| (x - normal * x.dot(&normal)).try_normalize(1e-9);
    let across = hint.and_then(flat).or_else(|| flat(axis)).unwrap_or(axis);
    [across, normal.cross(&across)]
}
