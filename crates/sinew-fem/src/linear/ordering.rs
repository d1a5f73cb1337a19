//! Orders of elimination that keep factors sparse.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;
use sinew_num::in_parallel;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Graphs up to this many vertices are ordered by minimum degree. Measured on beams with three unknowns per vertex:
/// entries of the factor by degree and by dissection are 0.41 and 0.43 million with 784 vertices, 1.21 and
/// 1.19 with 1620, and 16.9 and 14.8 with 10 080.
const MOST_BY_DEGREE: usize = 1_500;
/// Parts up to this many vertices are not cut further; 200 gives 1 % more operations.
const LEAF: usize = 50;

/// Puts some vertices of a graph in an order of elimination for little fill in the Cholesky factor of a symmetric matrix with these vertices. The
/// graph lists the neighbours of each vertex without itself, on both sides.
///
/// Few vertices are ordered by approximate minimum degree (P. R. Amestoy, T. A. Davis, I. S. Duff, SIAM J. Matrix
/// Anal. Appl. 17, 1996), many by nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973) with separators
/// across the axes of `positions`. The same graph has the same order, on any number of threads.
pub(crate) fn fill_reducing_order(
    graph: &[Vec<usize>],
    mut vertices: Vec<usize>,
    positions: &[[f64; 3]],
) -> Vec<usize> {
    let small = vertices.len() <= MOST_BY_DEGREE;
    let leaf = if small { MOST_BY_DEGREE } else { LEAF };
    dissect(&induced(graph, &vertices), positions, leaf, &mut vertices);
    vertices
}

/// Orders the names of the vertices of a part of the graph: both sides of a separator, then itself.
fn dissect(graph: &[Vec<usize>], positions: &[[f64; 3]], leaf: usize, names: &mut [usize]) {
    let places: Vec<_> = names.iter().map(|&name| positions[name]).collect();
    let part = if graph.len() > leaf { separate(graph, &places) } else { None };
    let sides = [0, 1, BETWEEN].map(|side| {
        let inside = |vertex: &usize| part.as_ref().is_some_and(|part| part[*vertex] == side);
        (0..graph.len()).filter(inside).collect::<Vec<_>>()
    });
    let order = if part.is_some() { sides.concat() } else { minimum_degree(graph) };
    let ordered: Vec<_> = order.into_iter().map(|vertex| names[vertex]).collect();
    names.copy_from_slice(&ordered);
    if part.is_some() {
        let (left, rest) = names.split_at_mut(sides[0].len());
        let (right, _) = rest.split_at_mut(sides[1].len());
        let order_side = |side: usize, names: &mut [usize]| {
            dissect(&induced(graph, &sides[side]), positions, leaf, names);
        };
        rayon::join(|| order_side(0, left), || order_side(1, right));
    }
}

/// The graph of some vertices, with the edges among them.
fn induced(graph: &[Vec<usize>], vertices: &[usize]) -> Vec<Vec<usize>> {
    let mut place = vec![None; graph.len()];
    vertices.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = Some(at));
    let neighbours = |&vertex: &usize| graph[vertex].iter().filter_map(|&n| place[n]).collect();
    vertices.iter().map(neighbours).collect()
}

/// The vertices ordered by approximate minimum degree.
fn minimum_degree(graph: &[Vec<usize>]) -> Vec<usize> {
    let size = graph.len();
    let (mut starts, mut rows) = (vec![0], Vec::new());
    for (vertex, neighbours) in graph.iter().enumerate() {
        rows.extend(neighbours.iter().filter(|&&n| n < vertex));
        starts.push(rows.len());
    }
    let entries = rows.len();
    let upper = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
    let (mut forward, mut inverse) = (vec![0; size], vec![0; size]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(size, entries));
    let control = amd::Control::default();
    let ordered =
        amd::order(&mut forward, &mut inverse, upper.as_ref(), control, MemStack::new(&mut memory));
    match ordered {
        Ok(_) => forward,
        // Only memory can run out, and any order is an order.
        Err(_) => (0..size).collect(),
    }
}

/// Largest side \[relative to the whole\].
const MOST_BALANCED: f64 = 0.6;
/// Penalty of imbalance: a fully unbalanced separator costs as much as a balanced one that is larger by 1/`UNEVEN`.
const UNEVEN: u64 = 4;
/// Refinement passes; most end before. Measured on the beams: 12 passes to one side in
/// turn give 6 % fewer operations than passes to both.
const PASSES: usize = 12;
/// Moves without improvement that end a pass.
const MOST_MOVES: usize = 300;

/// Side of a vertex: one of two, or the separator in between.
const BETWEEN: u8 = 2;

/// Side of each vertex by a small separator, the best of those from cuts in halves across each axis; `None` where nothing separates the graph: it is
/// complete, or nearly so. Multilevel bisection without positions (G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20, 1998) takes twice the time; factors
/// take 0.95 to 1.08 times as many operations by it on beams and shells.
fn separate(graph: &[Vec<usize>], positions: &[[f64; 3]]) -> Option<Vec<u8>> {
    let cut = |axis: usize| {
        let mut order: Vec<_> = (0..graph.len()).collect();
        order.sort_by(|&a, &b| positions[a][axis].total_cmp(&positions[b][axis]));
        Separation::halves(graph, &order)
    };
    let best = in_parallel(0..3, cut).into_iter().min_by_key(Separation::cost)?;
    (!best.cost().0).then_some(best.part)
}

/// A division of the vertices: no edge joins side 0 and side 1.
struct Separation<'g> {
    graph: &'g [Vec<usize>],
    part: Vec<u8>,
    /// Sizes of side 0, side 1, and of what is between.
    sizes: [usize; 3],
}

impl<'g> Separation<'g> {
    /// The first half of the vertices in some order, and what it touches, refined.
    fn halves(graph: &'g [Vec<usize>], order: &[usize]) -> Self {
        let mut separation = Self { graph, part: vec![1; graph.len()], sizes: [0, graph.len(), 0] };
        order[..order.len().div_ceil(2)].iter().for_each(|&vertex| separation.put(vertex, 0));
        for (vertex, neighbours) in graph.iter().enumerate() {
            let touches = |&n: &usize| separation.part[n] == 0;
            if separation.part[vertex] == 1 && neighbours.iter().any(touches) {
                separation.put(vertex, BETWEEN);
            }
        }
        separation.refine();
        separation
    }

    /// Small separators first, then even sides. A side that is empty separates nothing.
    fn cost(&self) -> (bool, u64) {
        let [a, b, between] = self.sizes.map(|size| size as u64);
        (a == 0 || b == 0, between * (UNEVEN * self.part.len() as u64 + a.abs_diff(b)))
    }

    fn put(&mut self, vertex: usize, part: u8) {
        self.sizes[self.part[vertex] as usize] -= 1;
        self.sizes[part as usize] += 1;
        self.part[vertex] = part;
    }

    /// Moves vertices out of the separator while that makes it smaller (C. M. Fiduccia, R. M. Mattheyses,
    /// DAC 1982, for separators as in B. Hendrickson, E. Rothberg, SIAM J. Sci. Comput. 20, 1998).
    fn refine(&mut self) {
        let mut side = u8::from(self.sizes[1] < self.sizes[0]);
        let mut fruitless = 0;
        for _ in 0..PASSES {
            let before = self.cost();
            self.pass(side);
            fruitless = if self.cost() < before { 0 } else { fruitless + 1 };
            if fruitless == 2 {
                return;
            }
            side = 1 - side;
        }
    }

    /// Moves vertices to one side only, so that the separator sweeps over the other side. Moves to both sides would stop in local minima that this
    /// passes.
    fn pass(&mut self, side: u8) {
        let (graph, other) = (self.graph, 1 - side);
        let most = (MOST_BALANCED * graph.len() as f64) as usize;
        let between = (0..graph.len()).filter(|&vertex| self.part[vertex] == BETWEEN);
        // Vertices of the separator by gain; an entry with an outdated gain is void.
        let mut queue: BinaryHeap<_> =
            between.map(|vertex| (self.gain(vertex, other), Reverse(vertex))).collect();
        // Vertices that changed, with the part they came from.
        let mut log = Vec::new();
        let (mut best, mut best_log, mut since) = (self.cost(), 0, 0);
        while since < MOST_MOVES {
            let Some((gain, Reverse(vertex))) = queue.pop() else { break };
            let present = self.part[vertex] == BETWEEN && self.gain(vertex, other) == gain;
            if !present || self.sizes[side as usize] == most {
                continue;
            }
            log.push((vertex, BETWEEN));
            self.put(vertex, side);
            // Neighbours on the other side take its place.
            for &pulled in &graph[vertex] {
                if self.part[pulled] != other {
                    continue;
                }
                log.push((pulled, other));
                self.put(pulled, BETWEEN);
                let near = graph[pulled].iter().filter(|&&n| self.part[n] == BETWEEN);
                let changed = near.chain([&pulled]);
                queue.extend(changed.map(|&vertex| (self.gain(vertex, other), Reverse(vertex))));
            }
            since += 1;
            if self.cost() < best {
                (best, best_log, since) = (self.cost(), log.len(), 0);
            }
        }
        for (vertex, part) in log.drain(best_log..).rev() {
            self.put(vertex, part);
        }
    }

    /// Number of vertices that the separator loses when one of it leaves for the side opposite to `other`.
    fn gain(&self, vertex: usize, other: u8) -> i64 {
        1 - self.graph[vertex].iter().filter(|&&n| self.part[n] == other).count() as i64
    }
}
