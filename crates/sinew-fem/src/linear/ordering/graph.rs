//! Undirected graphs with weights, and their coarsening.

use sinew_num::SplitMix64;

/// A graph: the neighbours of each vertex, without itself, compressed.
#[derive(Clone, Debug)]
pub(super) struct Graph {
    /// Offset of the neighbours of each vertex, and their number.
    pub starts: Vec<u32>,
    pub neighbours: Vec<u32>,
    /// Number of fine edges that each neighbour stands for.
    pub edge_weights: Vec<u32>,
    /// Number of fine vertices that each vertex stands for.
    pub weights: Vec<u32>,
}

impl Graph {
    /// A graph whose vertices and edges all weigh 1.
    pub(super) fn unweighted(starts: &[usize], neighbours: &[usize]) -> Self {
        Self {
            starts: starts.iter().map(|&s| s as u32).collect(),
            neighbours: neighbours.iter().map(|&n| n as u32).collect(),
            edge_weights: vec![1; neighbours.len()],
            weights: vec![1; starts.len() - 1],
        }
    }

    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    pub(super) fn total_weight(&self) -> u64 {
        self.weights.iter().map(|&w| u64::from(w)).sum()
    }

    pub(super) fn neighbours(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Neighbours with the weights of the edges to them.
    fn edges(&self, vertex: usize) -> impl Iterator<Item = (usize, u32)> {
        let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
        let weights = &self.edge_weights[range.clone()];
        self.neighbours[range].iter().zip(weights).map(|(&n, &w)| (n as usize, w))
    }

    /// The graph of some vertices, whose places in the result `place` holds (others: anything from
    /// `vertices.len()` on), with the edges among them.
    pub(super) fn induced(&self, vertices: &[u32], place: &[u32]) -> Self {
        let mut starts = Vec::with_capacity(vertices.len() + 1);
        starts.push(0);
        let (mut neighbours, mut edge_weights) = (Vec::new(), Vec::new());
        for &vertex in vertices {
            for (neighbour, weight) in self.edges(vertex as usize) {
                if (place[neighbour] as usize) < vertices.len() {
                    neighbours.push(place[neighbour]);
                    edge_weights.push(weight);
                }
            }
            starts.push(neighbours.len() as u32);
        }
        let weights = vertices.iter().map(|&v| self.weights[v as usize]).collect();
        Self { starts, neighbours, edge_weights, weights }
    }

    /// Merges neighbours along heavy edges (G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20, 1998): the coarse
    /// graph and the coarse vertex of each vertex. No coarse vertex weighs more than `most_weight` unless
    /// a fine one did.
    pub(super) fn coarsened(&self, most_weight: u32, random: &mut Random) -> (Self, Vec<u32>) {
        const UNMATCHED: u32 = u32::MAX;
        let mut mate = vec![UNMATCHED; self.len()];
        for &vertex in &random.permutation(self.len()) {
            let vertex = vertex as usize;
            if mate[vertex] != UNMATCHED {
                continue;
            }
            let fits = |n: usize| {
                mate[n] == UNMATCHED && self.weights[vertex] + self.weights[n] <= most_weight
            };
            let open = self.edges(vertex).filter(|&(n, _)| fits(n));
            // Of equally heavy edges the one to the lightest vertex keeps the weights even.
            let best = open.max_by_key(|&(n, w)| (w, std::cmp::Reverse(self.weights[n])));
            let partner = best.map_or(vertex, |(n, _)| n);
            mate[vertex] = partner as u32;
            mate[partner] = vertex as u32;
        }
        let mut coarse_of = vec![0; self.len()];
        let mut leaders = Vec::with_capacity(self.len());
        for vertex in 0..self.len() {
            if vertex <= mate[vertex] as usize {
                coarse_of[vertex] = leaders.len() as u32;
                coarse_of[mate[vertex] as usize] = leaders.len() as u32;
                leaders.push(vertex);
            }
        }
        (self.contracted(&leaders, &mate, &coarse_of), coarse_of)
    }

    /// The graph in which each leader is merged with its mate.
    fn contracted(&self, leaders: &[usize], mate: &[u32], coarse_of: &[u32]) -> Self {
        let mut starts = Vec::with_capacity(leaders.len() + 1);
        starts.push(0);
        let mut neighbours: Vec<u32> = Vec::with_capacity(self.neighbours.len() / 2);
        let mut edge_weights: Vec<u32> = Vec::with_capacity(self.neighbours.len() / 2);
        let mut weights = Vec::with_capacity(leaders.len());
        // Index of the edge to each coarse vertex, valid only for the current vertex.
        let mut seen = vec![0; leaders.len()];
        for (coarse, &leader) in leaders.iter().enumerate() {
            let first = neighbours.len();
            let partner = mate[leader] as usize;
            let both = [leader, partner];
            let members = if partner == leader { &both[..1] } else { &both[..] };
            for (neighbour, weight) in members.iter().flat_map(|&v| self.edges(v)) {
                let target = coarse_of[neighbour];
                if target as usize == coarse {
                    continue;
                }
                let at = seen[target as usize];
                if at >= first && at < neighbours.len() && neighbours[at] == target {
                    edge_weights[at] += weight;
                } else {
                    seen[target as usize] = neighbours.len();
                    neighbours.push(target);
                    edge_weights.push(weight);
                }
            }
            starts.push(neighbours.len() as u32);
            weights.push(members.iter().map(|&v| self.weights[v]).sum());
        }
        Self { starts, neighbours, edge_weights, weights }
    }
}

/// Random numbers for visiting orders.
#[derive(Clone, Debug)]
pub(super) struct Random(pub SplitMix64);

impl Random {
    pub(super) fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.0.bits()) * bound as u128) >> 64) as usize
    }

    pub(super) fn permutation(&mut self, size: usize) -> Vec<u32> {
        let mut order: Vec<u32> = (0..size as u32).collect();
        for i in (1..size).rev() {
            order.swap(i, self.below(i + 1));
        }
        order
    }
}
