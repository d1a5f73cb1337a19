//! Small sets of vertices that cut a graph in two.

use super::graph::{Graph, Random};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Graphs are coarsened down to this many vertices.
const COARSEST: usize = 120;
/// Number of separators grown in the coarsest graph, each from a random vertex.
const GROWN: usize = 8;
/// Largest weight of a side \[relative to the whole\].
const MOST_BALANCED: f64 = 0.6;
/// Penalty of imbalance: a fully unbalanced separator costs as much as a balanced one that is heavier by 1/`UNEVEN`.
const UNEVEN: u64 = 4;
/// Refinement passes per level; most end before. Measured on the beams: 12 passes to one side in
/// turn give 6 % fewer operations than passes to both.
const PASSES: usize = 12;
/// Moves without improvement that end a pass.
const MOST_MOVES: usize = 300;

/// Side of a vertex: one of two, or the separator in between.
pub(super) const BETWEEN: u8 = 2;

/// A division of the vertices: no edge joins side 0 and side 1.
#[derive(Clone, Debug)]
pub(super) struct Separation {
    pub part: Vec<u8>,
    /// Weights of side 0, side 1, and of what is between.
    pub weights: [u64; 3],
}

impl Separation {
    /// Finds a light separator: the graph is coarsened, the coarsest one is cut, and the cut is refined on
    /// the way back.
    pub(super) fn find(graph: &Graph, random: &mut Random) -> Self {
        let most_weight = (1.5 * graph.total_weight() as f64 / COARSEST as f64).max(1.0) as u32;
        let mut levels: Vec<(Graph, Vec<u32>)> = Vec::new();
        loop {
            let last = levels.last().map_or(graph, |(coarse, _)| coarse);
            if last.len() <= COARSEST {
                break;
            }
            let next = last.coarsened(most_weight, random);
            // A graph that hardly shrinks (a star, say) is cut as it is.
            if next.0.len() as f64 > 0.95 * last.len() as f64 {
                break;
            }
            levels.push(next);
        }
        let coarsest = levels.last().map_or(graph, |(coarse, _)| coarse);
        let mut separation = Self::best_grown(coarsest, random);
        for level in (0..levels.len()).rev() {
            let fine = if level == 0 { graph } else { &levels[level - 1].0 };
            let map = &levels[level].1;
            separation.part = map.iter().map(|&coarse| separation.part[coarse as usize]).collect();
            separation.refine(fine);
        }
        separation
    }

    fn best_grown(graph: &Graph, random: &mut Random) -> Self {
        let mut grown = || {
            let mut separation = Self::grow(graph, random.below(graph.len()));
            separation.refine(graph);
            separation
        };
        let mut best = grown();
        for _ in 1..GROWN {
            let next = grown();
            if next.cost() < best.cost() {
                best = next;
            }
        }
        best
    }

    /// Light separators first, then even sides. A side that is empty separates nothing.
    pub(super) fn cost(&self) -> (bool, u64) {
        let [a, b, between] = self.weights;
        let total = a + b + between;
        (a == 0 || b == 0, between * (UNEVEN * total + a.abs_diff(b)))
    }

    /// Grows side 0 from a vertex, nearest vertices first, to half the weight; what it touches is between.
    fn grow(graph: &Graph, start: usize) -> Self {
        let total = graph.total_weight();
        let mut separation = Self { part: vec![1; graph.len()], weights: [0, total, 0] };
        let mut queue = std::collections::VecDeque::from([start]);
        let mut seen = vec![false; graph.len()];
        seen[start] = true;
        let mut unseen = 0;
        while 2 * separation.weights[0] < total {
            let Some(vertex) = queue.pop_front() else {
                // The component is exhausted: continue in the next one.
                match (unseen..graph.len()).find(|&v| !seen[v]) {
                    Some(next) => {
                        (unseen, seen[next]) = (next, true);
                        queue.push_back(next);
                        continue;
                    }
                    None => break,
                }
            };
            separation.put(graph, vertex, 0);
            for &neighbour in graph.neighbours(vertex) {
                if !std::mem::replace(&mut seen[neighbour as usize], true) {
                    queue.push_back(neighbour as usize);
                }
            }
        }
        for vertex in 0..graph.len() {
            let touches = |&n: &u32| separation.part[n as usize] == 0;
            if separation.part[vertex] == 1 && graph.neighbours(vertex).iter().any(touches) {
                separation.put(graph, vertex, BETWEEN);
            }
        }
        separation
    }

    fn put(&mut self, graph: &Graph, vertex: usize, part: u8) {
        let weight = u64::from(graph.weights[vertex]);
        self.weights[self.part[vertex] as usize] -= weight;
        self.weights[part as usize] += weight;
        self.part[vertex] = part;
    }

    /// Moves vertices out of the separator while that makes it lighter (C. M. Fiduccia, R. M. Mattheyses,
    /// DAC 1982, for separators as in B. Hendrickson, E. Rothberg, SIAM J. Sci. Comput. 20, 1998).
    fn refine(&mut self, graph: &Graph) {
        let most = (MOST_BALANCED * graph.total_weight() as f64) as u64;
        let mut pass = Pass::new(graph);
        let mut side = usize::from(self.weights[1] < self.weights[0]);
        let mut fruitless = 0;
        for _ in 0..PASSES {
            let before = self.cost();
            pass.run(self, side, most);
            fruitless = if self.cost() < before { 0 } else { fruitless + 1 };
            if fruitless == 2 {
                return;
            }
            side = 1 - side;
        }
    }
}

/// State of a refinement pass. A pass moves vertices to one side only, so that the separator sweeps over the other
/// side. Moves to both sides would stop in local minima that this passes.
struct Pass<'g> {
    graph: &'g Graph,
    /// Weight that the separator loses when a vertex of it goes to the side.
    gain: Vec<i64>,
    moved: Vec<bool>,
    /// Vertices of the separator by gain; an entry with an outdated gain is void.
    queue: BinaryHeap<(i64, Reverse<u32>)>,
    /// Vertices that changed, with the part they came from.
    log: Vec<(u32, u8)>,
}

impl<'g> Pass<'g> {
    fn new(graph: &'g Graph) -> Self {
        let (gain, moved) = (vec![0; graph.len()], vec![false; graph.len()]);
        Self { graph, gain, moved, queue: BinaryHeap::new(), log: Vec::new() }
    }

    fn run(&mut self, separation: &mut Separation, side: usize, most: u64) {
        self.queue.clear();
        self.log.clear();
        self.moved.fill(false);
        for vertex in 0..self.graph.len() {
            if separation.part[vertex] == BETWEEN {
                self.enter(separation, vertex, side);
            }
        }
        let (mut best, mut best_log, mut since) = (separation.cost(), 0, 0);
        while since < MOST_MOVES {
            let Some((gain, Reverse(vertex))) = self.queue.pop() else { break };
            let vertex = vertex as usize;
            if self.moved[vertex] || self.gain[vertex] != gain {
                continue;
            }
            if separation.weights[side] + u64::from(self.graph.weights[vertex]) > most {
                continue;
            }
            self.transfer(separation, vertex, side);
            since += 1;
            if separation.cost() < best {
                (best, best_log, since) = (separation.cost(), self.log.len(), 0);
            }
        }
        for &(vertex, part) in self.log[best_log..].iter().rev() {
            separation.put(self.graph, vertex as usize, part);
        }
    }

    /// Computes the gain of a vertex that is in the separator, and queues it.
    fn enter(&mut self, separation: &Separation, vertex: usize, side: usize) {
        let mut gain = i64::from(self.graph.weights[vertex]);
        for &neighbour in self.graph.neighbours(vertex) {
            if separation.part[neighbour as usize] == 1 - side as u8 {
                gain -= i64::from(self.graph.weights[neighbour as usize]);
            }
        }
        self.gain[vertex] = gain;
        self.queue.push((gain, Reverse(vertex as u32)));
    }

    /// Moves a vertex to a side; its neighbours on the other side take its place between.
    fn transfer(&mut self, separation: &mut Separation, vertex: usize, side: usize) {
        let graph = self.graph;
        let other = 1 - side as u8;
        self.moved[vertex] = true;
        self.log.push((vertex as u32, BETWEEN));
        separation.put(graph, vertex, side as u8);
        for &pulled in graph.neighbours(vertex) {
            if separation.part[pulled as usize] != other {
                continue;
            }
            self.log.push((pulled, other));
            separation.put(graph, pulled as usize, BETWEEN);
            for &near in graph.neighbours(pulled as usize) {
                let near = near as usize;
                if separation.part[near] == BETWEEN && !self.moved[near] {
                    self.gain[near] += i64::from(graph.weights[pulled as usize]);
                    self.queue.push((self.gain[near], Reverse(near as u32)));
                }
            }
            self.enter(separation, pulled as usize, side);
        }
    }
}
