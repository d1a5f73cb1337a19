//! Implicit bodies cut out of a grid.

use super::box_tetrahedra;
use crate::{TetMesh, remove_unused_nodes, repair_orientation};
use std::collections::HashMap;

/// Share of an edge's length within which a node moves onto the surface instead of leaving a sliver, after Labelle and
/// Shewchuk, ACM Trans. Graph. 26 (2007).
const SNAP: f64 = 0.3;
/// Least depth of the centre of a cell with all nodes on the surface \[relative to a grid cell's edge\]: cells through
/// a thin body reach it, cells along a curved surface do not.
const THIN: f64 = 0.2;
/// Halvings until a crossing is found to rounding.
const HALVINGS: usize = 48;

/// The body where `inside` is positive, as tetrahedra with edges of about `edge` \[length\]. It reaches so far below and above
/// the origin along each axis; a plane through the origin, beyond which it does not reach, cuts it.
///
/// The tetrahedra of a grid are cut where `inside`, a function like a distance, changes its sign; nodes near the surface are moved
/// onto it. Planes cut the body sharply, other edges are rounded off by the grid.
///
/// # Panics
/// When the body has no volume.
pub(super) fn implicit_tetrahedra(
    reach: [[f64; 3]; 2],
    edge: f64,
    inside: impl Fn([f64; 3]) -> f64,
) -> TetMesh {
    // Planes of the grid pass through the origin, and the body has a margin of one cell.
    let cells = |length: f64| if length > 0.0 { (length / edge).ceil() + 1.0 } else { 0.0 };
    let [below, above] = reach.map(|side| side.map(cells));
    let [low, high] = [below.map(|count| -count * edge), above.map(|count| count * edge)];
    let cells: [usize; 3] = std::array::from_fn(|i| (below[i] + above[i]) as usize);
    let extent = std::array::from_fn(|i| high[i] - low[i]);
    let mut grid = box_tetrahedra(extent, cells);
    let place = |i: usize, x: f64| if x == extent[i] { high[i] } else { low[i] + x };
    grid.points.iter_mut().for_each(|x| *x = std::array::from_fn(|i| place(i, x[i])));
    let values = grid.points.iter().map(|&x| inside(x)).collect();
    let step = |i: usize| extent[i] / cells[i] as f64;
    let thin = THIN * step(0).max(step(1)).max(step(2));
    let mut cut = Cut { points: grid.points, values, inside, thin, between: HashMap::new() };
    cut.snap(&grid.cells, low, high);
    let cells = grid.cells.iter().flat_map(|&cell| cut.pieces(cell)).collect();
    let mut mesh = TetMesh { points: cut.points, cells, ..TetMesh::default() };
    remove_unused_nodes(&mut mesh);
    repair_orientation(&mut mesh);
    mesh
}

struct Cut<F> {
    points: Vec<[f64; 3]>,
    /// Positive inside, zero on the surface.
    values: Vec<f64>,
    inside: F,
    /// Depth of a cell's centre below which a cell with all nodes on the surface is not part of the body \[length\].
    thin: f64,
    /// Nodes on cut edges, by the ends.
    between: HashMap<[usize; 2], usize>,
}

const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

impl<F: Fn([f64; 3]) -> f64> Cut<F> {
    /// Moves nodes that are near the surface onto it; those on a side of the box along that side.
    fn snap(&mut self, cells: &[[usize; 4]], low: [f64; 3], high: [f64; 3]) {
        let sides = |x: &[f64; 3]| -> [bool; 6] {
            std::array::from_fn(|s| x[s % 3] == if s < 3 { low[s] } else { high[s % 3] })
        };
        let mut nearest: HashMap<usize, (f64, [f64; 3])> = HashMap::new();
        for [a, b] in cells.iter().flat_map(|cell| EDGES.map(|[i, j]| [cell[i], cell[j]])) {
            if self.values[a] * self.values[b] >= 0.0 {
                continue;
            }
            let share = self.crossing(a, b);
            for (node, other, share) in [(a, b, share), (b, a, 1.0 - share)] {
                let (from, to) = (self.points[node], self.points[other]);
                let mut held = sides(&from).into_iter().zip(sides(&to));
                let leaves_side = held.any(|(own, others)| own && !others);
                let known = nearest.get(&node).is_some_and(|(least, _)| *least <= share);
                if share < SNAP && !leaves_side && !known {
                    nearest.insert(node, (share, along(from, to, share)));
                }
            }
        }
        for (node, (_, place)) in nearest {
            (self.points[node], self.values[node]) = (place, 0.0);
        }
    }

    /// Share of the way from a to b, of different signs, at which the sign changes.
    fn crossing(&self, a: usize, b: usize) -> f64 {
        let (from, to) = (self.points[a], self.points[b]);
        let (mut near, mut far) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            let same = (self.inside)(along(from, to, middle)) * self.values[a] > 0.0;
            *if same { &mut near } else { &mut far } = middle;
        }
        0.5 * (near + far)
    }

    /// The node where the edge from an inner to an outer node meets the surface.
    fn cut(&mut self, inner: usize, outer: usize) -> usize {
        let key = [inner.min(outer), inner.max(outer)];
        if let Some(&node) = self.between.get(&key) {
            return node;
        }
        let share = self.crossing(key[0], key[1]);
        self.points.push(along(self.points[key[0]], self.points[key[1]], share));
        self.values.push(0.0);
        self.between.insert(key, self.points.len() - 1);
        self.points.len() - 1
    }

    /// The part of a cell that is inside.
    fn pieces(&mut self, cell: [usize; 4]) -> Vec<[usize; 4]> {
        let with = |sign: fn(&f64) -> bool| -> Vec<usize> {
            cell.into_iter().filter(|&node| sign(&self.values[node])).collect()
        };
        let sum = |i: usize| cell.iter().map(|&node| self.points[node][i]).sum::<f64>();
        let centre = || std::array::from_fn(|i| 0.25 * sum(i));
        let (inner, on, outer) = (with(|v| *v > 0.0), with(|v| *v == 0.0), with(|v| *v < 0.0));
        match (&inner[..], &on[..], &outer[..]) {
            // All nodes on the surface: a thin part of the body if deep enough, else outside.
            ([], _, []) if (self.inside)(centre()) < self.thin => Vec::new(),
            (.., []) => vec![cell],
            ([], ..) => Vec::new(),
            (&[a], on, outer) => {
                let mut corners = vec![a];
                corners.extend(on);
                corners.extend(outer.iter().map(|&o| self.cut(a, o)));
                vec![[corners[0], corners[1], corners[2], corners[3]]]
            }
            (&[a, b], &[c], &[o]) => {
                let [d, e] = [self.cut(a, o), self.cut(b, o)];
                pyramid([a, b, e, d], c).to_vec()
            }
            (&[a, b], _, &[o, p]) => {
                let [ao, ap] = [self.cut(a, o), self.cut(a, p)];
                let [bo, bp] = [self.cut(b, o), self.cut(b, p)];
                prism([a, ao, ap], [b, bo, bp]).to_vec()
            }
            (&[a, b, c], _, &[o]) => {
                let cuts = [self.cut(a, o), self.cut(b, o), self.cut(c, o)];
                prism([a, b, c], cuts).to_vec()
            }
            _ => Vec::new(),
        }
    }
}

fn along(from: [f64; 3], to: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|i| {
        if from[i] == to[i] { from[i] } else { from[i] + share * (to[i] - from[i]) }
    })
}

/// Two tetrahedra; the quadrilateral is cut from its smallest node, on which neighbours agree.
fn pyramid([a, b, c, d]: [usize; 4], apex: usize) -> [[usize; 4]; 2] {
    if a.min(c) < b.min(d) {
        [[a, b, c, apex], [a, c, d, apex]]
    } else {
        [[b, c, d, apex], [b, d, a, apex]]
    }
}

/// Three tetrahedra; all quadrilaterals are cut from their smallest node (Dompierre et al., 1999).
fn prism(low: [usize; 3], high: [usize; 3]) -> [[usize; 4]; 3] {
    // The smallest node of all comes first.
    let smallest = (0..3).min_by_key(|&i| low[i].min(high[i])).unwrap_or(0);
    let turned =
        |nodes: [usize; 3]| -> [usize; 3] { std::array::from_fn(|i| nodes[(smallest + i) % 3]) };
    let (mut low, mut high) = (turned(low), turned(high));
    if high[0] < low[0] {
        (low, high) = (high, low);
    }
    let first = [low[0], high[0], high[1], high[2]];
    let [second, third] = pyramid([low[1], low[2], high[2], high[1]], low[0]);
    [first, second, third]
}
