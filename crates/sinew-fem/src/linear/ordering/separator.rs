//! Small sets of vertices that cut a graph in two.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
pub(super) const BETWEEN: u8 = 2;

/// Side of each vertex by a small separator, the best of those from cuts in halves across each axis; `None` where nothing separates the graph: it is
/// complete, or nearly so. Multilevel bisection without positions (G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20, 1998) takes twice the time; factors
/// take 0.95 to 1.08 times as many operations by it on beams and shells.
pub(super) fn separate(graph: &[Vec<usize>], positions: &[[f64; 3]]) -> Option<Vec<u8>> {
    let cut = |axis: usize| {
        let mut order: Vec<_> = (0..graph.len()).collect();
        order.sort_by(|&a, &b| positions[a][axis].total_cmp(&positions[b][axis]));
        Separation::halves(graph, &order)
    };
    let best = (0..3).map(cut).min_by_key(Separation::cost)?;
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
