//! Graphs and solution of the first bodies of a population, reused for other bodies.

use super::settings::Start;
use crate::graph::{topology, topology_of_met};
use crate::{Error, Result};
use sinew_emulate::Body;
use sinew_emulate::parts::{Axis, axes, check_body, listed};
use sinew_fem::{Options, Solver};
use sinew_graph::Topology;

/// Template from the first bodies: the graphs of their connectivities, and the equilibrium of the very first one.
#[derive(Clone, Debug)]
pub(super) struct Template {
    graphs: Vec<(Vec<[usize; 2]>, Topology)>,
    /// Parameters of every body.
    parameters: Vec<Axis>,
    /// Equilibrium of the first body, where outputs start near to one.
    pub solved: Option<Solved>,
}

/// A body's equilibrium at the centre of the parameters' ranges.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    edges: Vec<[usize; 2]>,
    positions: Vec<[f64; 3]>,
    state: Vec<f64>,
}

impl Template {
    pub(super) fn new(bodies: &[Body], start: Start, seed: u64) -> Result<Self> {
        let mut graphs: Vec<(Vec<[usize; 2]>, Topology)> = Vec::new();
        let parameters = bodies.first().map(axes).unwrap_or_default();
        for body in bodies {
            check_body(body)?;
            require_axes(&parameters, body)?;
            let edges = body.mesh.edges();
            if graphs.iter().all(|(known, _)| *known != edges) {
                graphs.push((edges, topology(body, true, seed)?));
            }
        }
        let solved = match (start, bodies.first()) {
            (Start::Near { .. }, Some(body)) => Some(Solved {
                edges: body.mesh.edges(),
                positions: body.positions.clone(),
                state: Solver::new(body)?.solve(&body.centre(), &Options::default())?.displacement,
            }),
            _ => None,
        };
        Ok(Self { graphs, parameters, solved })
    }

    /// Requires the parameters of the population.
    pub(super) fn require(&self, body: &Body) -> Result<()> {
        require_axes(&self.parameters, body)
    }

    /// The graph of a body: clusters of a first one where it has its connectivity, which takes no time.
    pub(super) fn graph(&self, body: &Body, seed: u64) -> Result<Topology> {
        let edges = body.mesh.edges();
        match self.graphs.iter().find(|(known, _)| *known == edges) {
            Some((_, topology)) => Ok(topology.clone()),
            None => topology_of_met(body, seed),
        }
    }
}

/// Requires these parameters of a body: names, order, ranges, units and scales, which inputs of a network mean.
fn require_axes(parameters: &[Axis], body: &Body) -> Result<()> {
    let own = axes(body);
    if own == parameters {
        return Ok(());
    }
    let (population, body) = (listed(parameters), listed(&own));
    Err(Error::OtherParameters { population, body })
}

impl Solved {
    /// Displacement of this body interpolated to the nodes of another, both scaled to the same bounding box \[length\].
    pub(super) fn interpolated_to(&self, body: &Body) -> Vec<f64> {
        /// Nodes that a state is averaged over, by the inverse squares of their squared distances.
        const NEAREST: usize = 4;
        let ([from, own], [to, size]) = (bounds(&self.positions), bounds(&body.positions));
        let scale: [f64; 3] = std::array::from_fn(|i| size[i] / own[i]);
        let moved = |node: usize| -> [f64; 3] {
            std::array::from_fn(|i| scale[i] * self.state[3 * node + i])
        };
        if body.nodes == self.positions.len() && body.mesh.edges() == self.edges {
            return (0..body.nodes).flat_map(moved).collect();
        }
        let at = |x: &[f64; 3]| -> [f64; 3] {
            let x: [f64; 3] = std::array::from_fn(|i| from[i] + (x[i] - to[i]) / scale[i]);
            let distance = |node: &usize| -> f64 {
                self.positions[*node].iter().zip(x).map(|(a, b)| (a - b).powi(2)).sum()
            };
            let mut near: Vec<(f64, usize)> =
                (0..self.positions.len()).map(|node| (distance(&node), node)).collect();
            let last = NEAREST.min(near.len()) - 1;
            near.select_nth_unstable_by(last, |a, b| a.0.total_cmp(&b.0));
            let (mut sum, mut weights) = ([0.0; 3], 0.0);
            for (distance, node) in &near[..=last] {
                let weight = 1.0 / (distance + 1e-6).powi(2);
                weights += weight;
                sum.iter_mut().zip(moved(*node)).for_each(|(sum, u)| *sum += weight * u);
            }
            sum.map(|sum| sum / weights)
        };
        body.positions.iter().flat_map(at).collect()
    }
}

/// Least coordinates, and extents.
fn bounds(positions: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let end = |i: usize, pick: fn(f64, f64) -> f64, from: f64| {
        positions.iter().map(|x| x[i]).fold(from, pick)
    };
    let least: [f64; 3] = std::array::from_fn(|i| end(i, f64::min, f64::INFINITY));
    let extent = |i: usize| end(i, f64::max, f64::NEG_INFINITY) - least[i];
    [least, std::array::from_fn(|i| extent(i).max(f64::MIN_POSITIVE))]
}
