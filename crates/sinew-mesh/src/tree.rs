//! A tree of boxes around the triangles of a surface, for rays, distances and crossings; surfaces that pass through themselves.

use crate::TriangleMesh;
use crate::geometry::{bounds, merged};
use nalgebra::Vector3;

type Point = Vector3<f64>;

/// Triangles in a leaf of the tree.
const LEAF: usize = 4;
/// Margin beyond its edges at which a triangle still meets a ray \[relative to its size\]: a ray must not pass between
/// two triangles at their edge.
const EDGE: f64 = 1e-9;
/// Sine of the angle to a triangle's plane below which a line counts as parallel to it: some thousand rounding errors.
const PARALLEL: f64 = 1e-12;

/// Least distance of a crossing from ends and edges \[relative to their lengths\]: contact is no crossing.
const MARGIN: f64 = 1e-9;

/// Triangles sorted into nested boxes (a bounding volume hierarchy, split at the median of the longest side).
pub(crate) struct SurfaceTree {
    corners: Vec<[Point; 3]>,
    /// Triangles in the order of the leaves.
    order: Vec<usize>,
    nodes: Vec<Node>,
}

struct Node {
    low: Point,
    high: Point,
    /// The triangles of the node in `order`.
    start: usize,
    end: usize,
    /// The second child; the first one follows its parent, and a leaf has none.
    second: Option<usize>,
}

impl SurfaceTree {
    pub(crate) fn new(surface: &TriangleMesh) -> Self {
        Self::of((0..surface.cells.len()).map(|cell| surface.corners(cell)).collect())
    }

    pub(crate) fn of(corners: Vec<[Point; 3]>) -> Self {
        let mut tree = Self { order: (0..corners.len()).collect(), corners, nodes: Vec::new() };
        tree.split(0, tree.order.len());
        tree
    }

    fn split(&mut self, start: usize, end: usize) -> usize {
        let members = self.order[start..end].iter().flat_map(|&t| &self.corners[t]);
        let [low, high] = bounds(members.copied());
        let node = self.nodes.len();
        self.nodes.push(Node { low, high, start, end, second: None });
        if end - start > LEAF {
            let corners = &self.corners;
            let centre = |t: usize| corners[t].iter().sum::<Point>();
            // Boxes of long triangles do not tell along which axis there are many.
            let [first, last] = bounds(self.order[start..end].iter().map(|&t| centre(t)));
            let axis = (last - first).imax();
            let centre = |t: usize| centre(t)[axis];
            let middle = (end - start) / 2;
            self.order[start..end].select_nth_unstable_by(middle, |&a, &b| {
                (centre(a), a).partial_cmp(&(centre(b), b)).unwrap_or(a.cmp(&b))
            });
            self.split(start, start + middle);
            self.nodes[node].second = Some(self.split(start + middle, end));
        }
        node
    }

    /// Visits the triangles in all leaves whose boxes are wanted.
    fn visit(&self, wanted: impl Fn(&Node) -> bool, mut see: impl FnMut(usize)) {
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if wanted(node) {
                match node.second {
                    Some(second) => stack.extend([second, at + 1]),
                    None => self.order[node.start..node.end].iter().for_each(|&t| see(t)),
                }
            }
        }
    }

    /// Distances along a ray (in lengths of `direction`) at which it meets triangles, ascending; an edge is met twice.
    pub(crate) fn hits(&self, origin: Point, direction: Point) -> Vec<f64> {
        let mut found = Vec::new();
        let meets = |node: &Node| {
            let (mut near, mut far) = (0.0_f64, f64::INFINITY);
            for axis in 0..3 {
                let [a, b] = [node.low[axis], node.high[axis]].map(|x| x - origin[axis]);
                if direction[axis] == 0.0 {
                    if a > 0.0 || b < 0.0 {
                        return false;
                    }
                } else {
                    let [a, b] = [a, b].map(|x| x / direction[axis]);
                    (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
                }
            }
            // Boxes of triangles in a plane have no thickness.
            near <= far * (1.0 + EDGE) + EDGE
        };
        self.visit(meets, |t| {
            let way = crossing(&self.corners[t], origin, direction, -EDGE);
            found.extend(way.filter(|&way| way >= 0.0));
        });
        found.sort_by(f64::total_cmp);
        found
    }

    /// Distance of a point from the surface; infinite when it has no triangles.
    pub(crate) fn distance(&self, point: Point) -> f64 {
        let mut best = f64::INFINITY;
        let mut stack = vec![0];
        let from_box = |node: &Node| (point - point.sup(&node.low).inf(&node.high)).norm();
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if from_box(node) >= best {
                continue;
            }
            let Some(second) = node.second else {
                for &t in &self.order[node.start..node.end] {
                    best = best.min((point - nearest(&self.corners[t], point)).norm());
                }
                continue;
            };
            // The nearer child is looked at first.
            let first_is_nearer = from_box(&self.nodes[at + 1]) <= from_box(&self.nodes[second]);
            stack.extend(if first_is_nearer { [second, at + 1] } else { [at + 1, second] });
        }
        best
    }

    /// Triangles that a point lies on, within a part of their longest edges, away from their corners.
    pub(crate) fn below(&self, point: Point, part: f64) -> Vec<usize> {
        let reach = Point::repeat(part * (self.nodes[0].high - self.nodes[0].low).norm());
        let on = |&triangle: &usize| {
            let corners @ [a, b, c] = &self.corners[triangle];
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            let far = |other: &Point| (other - point).norm() > part * longest;
            !far(&nearest(corners, point)) && corners.iter().all(far)
        };
        self.near(point - reach, point + reach).into_iter().filter(on).collect()
    }

    /// Triangles whose leaf meets the box.
    fn near(&self, low: Point, high: Point) -> Vec<usize> {
        let mut found = Vec::new();
        let meets = |node: &Node| (0..3).all(|i| node.low[i] <= high[i] && low[i] <= node.high[i]);
        self.visit(meets, |t| found.push(t));
        found
    }
}

/// Intersection of a line and a triangle, in lengths of its direction (Möller and Trumbore, J. Graphics Tools 2, 1997). With a
/// positive margin the edges do not count, with a negative one a strip beyond them does.
fn crossing([a, b, c]: &[Point; 3], origin: Point, direction: Point, margin: f64) -> Option<f64> {
    let (along, up) = (b - a, c - a);
    let across = direction.cross(&up);
    let volume = along.dot(&across);
    if volume.abs() <= PARALLEL * along.norm() * up.norm() * direction.norm() {
        return None;
    }
    let from = origin - a;
    let turned = from.cross(&along);
    let [u, v] = [from.dot(&across), direction.dot(&turned)].map(|x| x / volume);
    let inside = u >= margin && v >= margin && u + v <= 1.0 - margin;
    inside.then(|| up.dot(&turned) / volume)
}

/// The point of a triangle nearest to a point (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn nearest([a, b, c]: &[Point; 3], point: Point) -> Point {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|edge| edge.dot(&(point - a)));
    let [d3, d4] = [ab, ac].map(|edge| edge.dot(&(point - b)));
    let [d5, d6] = [ab, ac].map(|edge| edge.dot(&(point - c)));
    let [va, vb, vc] = [d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2];
    if d1 <= 0.0 && d2 <= 0.0 {
        *a
    } else if d3 >= 0.0 && d4 <= d3 {
        *b
    } else if d6 >= 0.0 && d5 <= d6 {
        *c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        a + (ab * vb + ac * vc) / (va + vb + vc)
    }
}

/// Pairs of triangles that intersect: an edge of one passes through the interior of the other. Coincident points count
/// as one; coplanar triangles are not found.
///
/// ```
/// use sinew_mesh::{TriangleMesh, self_intersections};
///
/// let points = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.5, -1.0], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]];
/// let mut surface = TriangleMesh::new(points, vec![[0, 1, 2], [3, 4, 5]])?;
/// assert_eq!(self_intersections(&surface), [[0, 1]]);
/// surface.points[3][2] = 0.5;
/// assert!(self_intersections(&surface).is_empty());
/// # Ok::<(), sinew_mesh::Refusal>(())
/// ```
pub fn self_intersections(surface: &TriangleMesh) -> Vec<[usize; 2]> {
    let tree = SurfaceTree::new(surface);
    let place = merged(&surface.points, |_| 0.0);
    let named = |cell: usize| surface.cells[cell].map(|node| place[node]);
    let mut pairs = Vec::new();
    for cell in 0..surface.cells.len() {
        let corners = surface.corners(cell);
        let [low, high] = bounds(corners);
        for other in tree.near(low, high).into_iter().filter(|&other| other > cell) {
            let of_other = surface.corners(other);
            let (a, b) = (named(cell), named(other));
            if pierces((a, &corners), (b, &of_other)) || pierces((b, &of_other), (a, &corners)) {
                pairs.push([cell, other]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Whether an edge of the first triangle passes through the second; edges that share an end with it do not count.
fn pierces(
    (names, corners): ([usize; 3], &[Point; 3]),
    (others, triangle): ([usize; 3], &[Point; 3]),
) -> bool {
    (0..3).any(|k| {
        let ends = [k, (k + 1) % 3];
        let apart = ends.iter().all(|&end| !others.contains(&names[end]));
        let [from, to] = ends.map(|end| corners[end]);
        let inside = |way: f64| (MARGIN..1.0 - MARGIN).contains(&way);
        apart && crossing(triangle, from, to - from, MARGIN).is_some_and(inside)
    })
}
