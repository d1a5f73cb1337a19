//! Small sets of vertices that cut a graph in two.

use super::graph::{Graph, Random};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Graphs are coarsened down to this many vertices.
const COARSEST: usize = 120;
/// Separators that are grown in the coarsest graph, from as many vertices.
const GROWN: usize = 8;
/// A side may weigh this part of the whole.
const MOST_BALANCED: f64 = 0.6;
/// Refinement passes per level; most end by themselves before.
const PASSES: usize = 8;
/// Moves without improvement that end a pass.
const MOST_MOVES: usize = 150;

/// Where a vertex lies: on one of two sides, or in between.
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
    pub fn find(graph: &Graph, random: &mut Random) -> Self {
        let total = graph.total_weight();
        let most_weight = (1.5 * total as f64 / COARSEST as f64).max(1.0) as u32;
        let mut levels: Vec<(Graph, Vec<u32>)> = Vec::new();
        loop {
            let finest = levels.last().map_or(graph, |(coarse, _)| coarse);
            if finest.len() <= COARSEST {
                break;
            }
            let next = finest.coarsened(most_weight, random);
            // A graph that hardly shrinks (a star, say) is cut as it is.
            if next.0.len() as f64 > 0.95 * finest.len() as f64 {
                break;
            }
            levels.push(next);
        }
        let coarsest = levels.last().map_or(graph, |(coarse, _)| coarse);
        let grown = (0..GROWN).map(|_| {
            let mut separation = Self::grow(coarsest, random.below(coarsest.len()));
            separation.refine(coarsest);
            separation
        });
        let best = grown.min_by_key(Self::cost);
        let mut separation = best.unwrap_or_else(|| Self::grow(coarsest, 0));
        for level in (0..levels.len()).rev() {
            let fine = if level == 0 { graph } else { &levels[level - 1].0 };
            let map = &levels[level].1;
            separation.part = map.iter().map(|&coarse| separation.part[coarse as usize]).collect();
            separation.refine(fine);
        }
        separation
    }

    /// Light separators first, then even sides. A side that is empty separates nothing.
    pub fn cost(&self) -> (bool, u64, u64) {
        let [a, b, between] = self.weights;
        (a == 0 || b == 0, between, a.abs_diff(b))
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
                // The component is used up: go on in the next one.
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
        for _ in 0..PASSES {
            let before = self.cost();
            pass.run(self, most);
            if self.cost() >= before {
                return;
            }
        }
    }
}

/// What a pass of refinement keeps.
struct Pass<'g> {
    graph: &'g Graph,
    /// By how much the separator gets lighter when a vertex of it goes to either side.
    gain: Vec<[i64; 2]>,
    moved: Vec<bool>,
    /// Vertices of the separator by gain for each side; an entry whose gain is no longer true is void.
    queues: [BinaryHeap<(i64, Reverse<u32>)>; 2],
    /// Vertices that changed, with the part they came from.
    log: Vec<(u32, u8)>,
}

impl<'g> Pass<'g> {
    fn new(graph: &'g Graph) -> Self {
        let queues = [BinaryHeap::new(), BinaryHeap::new()];
        let (gain, moved) = (vec![[0; 2]; graph.len()], vec![false; graph.len()]);
        Self { graph, gain, moved, queues, log: Vec::new() }
    }

    fn run(&mut self, separation: &mut Separation, most: u64) {
        self.queues.iter_mut().for_each(BinaryHeap::clear);
        self.log.clear();
        self.moved.fill(false);
        for vertex in 0..self.graph.len() {
            if separation.part[vertex] == BETWEEN {
                self.enter(separation, vertex);
            }
        }
        let (mut best, mut best_log, mut since) = (separation.cost(), 0, 0);
        while since < MOST_MOVES {
            let Some((vertex, side)) = self.choose(separation, most) else { break };
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

    /// Computes the gains of a vertex that is in the separator, and queues it.
    fn enter(&mut self, separation: &Separation, vertex: usize) {
        let mut gain = [i64::from(self.graph.weights[vertex]); 2];
        for &neighbour in self.graph.neighbours(vertex) {
            let part = separation.part[neighbour as usize];
            if part != BETWEEN {
                gain[1 - part as usize] -= i64::from(self.graph.weights[neighbour as usize]);
            }
        }
        self.gain[vertex] = gain;
        self.queues[0].push((gain[0], Reverse(vertex as u32)));
        self.queues[1].push((gain[1], Reverse(vertex as u32)));
    }

    /// The best move that keeps the balance; of equals, to the lighter side.
    fn choose(&mut self, separation: &Separation, most: u64) -> Option<(usize, usize)> {
        let mut best: Option<(i64, u64, usize, usize)> = None;
        for side in 0..2 {
            while let Some(&(gain, Reverse(vertex))) = self.queues[side].peek() {
                let vertex = vertex as usize;
                let stale = self.moved[vertex]
                    || separation.part[vertex] != BETWEEN
                    || self.gain[vertex][side] != gain;
                if stale {
                    self.queues[side].pop();
                    continue;
                }
                let weight = separation.weights[side] + u64::from(self.graph.weights[vertex]);
                let better = best.is_none_or(|(g, w, ..)| gain > g || (gain == g && weight < w));
                if weight <= most && better {
                    best = Some((gain, weight, vertex, side));
                }
                break;
            }
        }
        best.map(|(_, _, vertex, side)| (vertex, side))
    }

    /// Moves a vertex to a side; its neighbours on the other side take its place between.
    fn transfer(&mut self, separation: &mut Separation, vertex: usize, side: usize) {
        let graph = self.graph;
        let other = 1 - side;
        self.moved[vertex] = true;
        self.log.push((vertex as u32, BETWEEN));
        separation.put(graph, vertex, side as u8);
        for &neighbour in graph.neighbours(vertex) {
            let neighbour = neighbour as usize;
            if separation.part[neighbour] == BETWEEN {
                self.change(neighbour, other, -i64::from(graph.weights[vertex]));
            }
        }
        for &neighbour in graph.neighbours(vertex) {
            let pulled = neighbour as usize;
            if separation.part[pulled] != other as u8 {
                continue;
            }
            self.log.push((neighbour, other as u8));
            separation.put(graph, pulled, BETWEEN);
            for &near in graph.neighbours(pulled) {
                if separation.part[near as usize] == BETWEEN {
                    self.change(near as usize, side, i64::from(graph.weights[pulled]));
                }
            }
            self.enter(separation, pulled);
        }
    }

    fn change(&mut self, vertex: usize, side: usize, by: i64) {
        self.gain[vertex][side] += by;
        if !self.moved[vertex] {
            self.queues[side].push((self.gain[vertex][side], Reverse(vertex as u32)));
        }
    }
}
