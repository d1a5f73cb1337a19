//! Rigid motions of a body's clusters as the coordinates of its displacement.

use std::sync::Arc;

use crate::anchors::Anchors;
use crate::tree::MotionTree;
use nalgebra::{DMatrix, SMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};
use sinew_energy::{Body, Stiffness};
use sinew_graph::{FeatureMatrix, Topology, pool_positions};

use crate::dirichlet::Dirichlet;
use crate::error::{CoordinateError, Result, require_count, require_finite, require_positive};
use crate::packed;
use crate::polynomial::{all_terms, check_terms, terms, with_amplitude};

/// Outputs at every scale: each virtual node moves the nodes below it as a rigid body, and each node adds its own
/// displacement, `u = T_root ∘ … ∘ T_parent(X + d) − X`.
///
/// The motions of slender bodies differ in energy by a factor of a million. A network in plain displacements learns the
/// soft ones last. Here every motion is scaled by its own energy, `S_k = c (P_kᵀ K P_k)^(−½)` with the stiffness K and the
/// rigid motions `P_k` of the cluster's free nodes. In this multilevel frame the Hessian of the energy is well conditioned.
/// The motions are finite and composed, so that this also holds when the body rotates. Memory and time are proportional to
/// the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Packed", into = "Packed")]
pub struct Motions {
    /// Displacement of zero outputs, at every real node \[length\].
    origin: Arc<[f64]>,
    unknowns: usize,
    tree: Arc<MotionTree>,
    /// Taylor coefficients of the outputs of clusters, then of nodes, per unit of each standardised parameter and of each
    /// product of two; empty without a Taylor expansion.
    slopes: Arc<[Vec<f64>]>,
    /// Logarithm of the amplitude per unit of each of these terms; none where outputs follow without one.
    rates: Arc<[f64]>,
    /// Further solved states, whose displacements are added.
    anchors: Option<Arc<Anchors>>,
}

/// A solved state that displacements are to go through.
#[derive(Clone, Debug)]
pub struct Anchor {
    /// Its standardised parameters.
    pub at: Vec<f64>,
    /// Taylor polynomial there, node by node \[length\]: the displacement, and its changes with each parameter and each product of two.
    pub changes: Vec<Vec<f64>>,
}

/// Eigenvalue \[relative to the largest of a cluster's stiffness\] below which a motion has scale zero.
const SMALLEST_STIFFNESS: f64 = 1e-9;

impl Motions {
    /// Motions about a displacement of a body \[length\], that of zero outputs, with the stiffness there at θ. A unit
    /// output costs an energy of ½; see [`Motions::of_energy`].
    ///
    /// # Errors
    /// A graph or a displacement that does not belong to the body, cells that the displacement inverts, a graph without
    /// virtual nodes, a body that no motion costs energy.
    pub fn about(
        displacement: &[f64],
        topology: &Topology,
        body: &Body,
        theta: &[f64],
    ) -> Result<Self> {
        let nodes = topology.real_nodes;
        require_count("nodes of the body", body.nodes, nodes)?;
        let stiffness = stiffness(body, displacement, theta)?;
        let dirichlet = Dirichlet::of_body(body);
        let (u, _) = displacement.as_chunks::<3>();
        let places: Vec<[f64; 3]> = body
            .positions
            .iter()
            .zip(u)
            .map(|(x, u)| std::array::from_fn(|i| x[i] + u[i]))
            .collect();
        let mut places = pool_positions(topology, &places)?;
        let centres = places.split_off(nodes);
        let parents: Vec<Option<usize>> = topology
            .parents()
            .into_iter()
            .map(|parent| parent.map(|parent| parent - nodes))
            .collect();
        let node_parents: Option<Vec<usize>> = parents[..nodes].iter().copied().collect();
        let node_parents = node_parents
            .ok_or(CoordinateError::None("outputs at every scale need virtual nodes"))?;
        let table = dirichlet.projectors(3);
        let (rows, _) = table.as_chunks::<3>();
        let (free, _) = rows.as_chunks::<3>();
        let costs = Costs { stiffness: &stiffness, free, places: &places };
        let node_scales = (0..nodes).map(|node| inverse_root(costs.of_node(node)));
        let mut tree = MotionTree {
            node_scales: node_scales.collect(),
            cluster_parents: parents[nodes..].to_vec(),
            cluster_scales: Vec::with_capacity(centres.len()),
            node_parents,
            centres,
            positions: places.clone(),
        };
        costs.scale_clusters(&mut tree, &topology.roots_per_layer);
        let largest =
            tree.node_scales.as_flattened().as_flattened().iter().fold(0f64, |m, s| m.max(s.abs()));
        require_positive("the displacement of a unit output", largest)?;
        let unknowns = dirichlet.prescribed.iter().filter(|value| value.is_none()).count();
        Ok(Self {
            origin: displacement.into(),
            unknowns,
            tree: tree.into(),
            slopes: Arc::new([]),
            rates: Arc::new([]),
            anchors: None,
        })
    }

    /// Outputs with a Taylor expansion in the parameters; a network adds the remainder. `changes` are the derivatives of
    /// the displacement in the standardised parameters, node by node \[length\], optionally followed by the coefficients of
    /// the products `p_i p_j`, `j ≥ i`.
    ///
    /// The outputs of a change are not unique. From the whole body down, every cluster takes as much of it as it can, and
    /// the nodes take the rest.
    ///
    /// # Errors
    /// Another body than the motions', or changes that do not belong to it.
    #[doc(alias = "following")]
    pub fn with_expansion(mut self, changes: &[Vec<f64>], body: &Body) -> Result<Self> {
        self.slopes = self.outputs_of(changes, &Dirichlet::of_body(body))?.into();
        (self.rates, self.anchors) = (Arc::new([]), None);
        Ok(self)
    }

    /// [`Motions::with_expansion`] to second order, multiplied by an amplitude: `u = a (u₀ + v)` for small rotations, with the
    /// displacement u₀ of zero outputs. The logarithm of a and the remainder v, perpendicular to u₀, are polynomials of
    /// second order, with 1/20 ≤ a ≤ 20. If displacements fall like an inverse stiffness over decades, they stay positive
    /// multiples of each other. No polynomial has this property. Both forms agree to second order.
    ///
    /// # Errors
    /// As [`Motions::with_expansion`]; changes of first order alone, or a displacement of zero.
    pub fn in_proportion(
        mut self,
        changes: &[Vec<f64>],
        parameters: usize,
        body: &Body,
    ) -> Result<Self> {
        require_count("changes to second order", changes.len(), all_terms(parameters))?;
        let dot = |change: &[f64]| -> f64 {
            self.origin.iter().zip(change).map(|(u, change)| u * change).sum()
        };
        let size = dot(&self.origin);
        require_positive("the displacement that an amplitude multiplies", size)?;
        let parts: Vec<f64> = changes.iter().map(|change| dot(change) / size).collect();
        let rest: Vec<f64> = self.origin.iter().map(|u| -u).collect();
        let all: Vec<Vec<f64>> = changes.iter().cloned().chain([rest]).collect();
        let mut slopes = self.outputs_of(&all, &Dirichlet::of_body(body))?;
        let mut rates = parts.clone();
        let rest = slopes.len() - 1;
        // First order of v, then the remainder of second order.
        for k in 0..rest {
            add(&mut slopes, k, rest, parts[k]);
        }
        let mut k = parameters;
        for i in 0..parameters {
            for j in i..parameters {
                let half = if i == j { 0.5 } else { 1.0 };
                rates[k] -= half * parts[i] * parts[j];
                add(&mut slopes, k, j, -half * parts[i]);
                add(&mut slopes, k, i, -half * parts[j]);
                k += 1;
            }
        }
        (self.slopes, self.rates) = (slopes.into(), rates.into());
        Ok(self)
    }

    /// Outputs whose Taylor terms are damped: the first `count` changes by one factor, the others by the second.
    pub fn damped(mut self, [first, others]: [f64; 2], count: usize) -> Self {
        let part = |k: usize| if k < count { first } else { others };
        let rest = self.rates.len();
        let slopes = self.slopes.iter().enumerate().map(|(k, slope)| {
            // The last term, after those of an amplitude, leads to rest.
            let part = if rest > 0 && k == rest { 1.0 } else { part(k) };
            slope.iter().map(|y| part * y).collect()
        });
        self.slopes = slopes.collect();
        self.rates = self.rates.iter().enumerate().map(|(k, rate)| part(k) * rate).collect();
        self
    }

    /// Displacement of a body at standardised parameters without a network, node by node \[length\].
    ///
    /// # Errors
    /// Another body than the motions', other parameters than the expansion has.
    #[doc(alias = "followed")]
    pub fn expansion_at(&self, parameters: &[f64], body: &Body) -> Result<Vec<f64>> {
        require_count("nodes of the body", body.nodes, self.tree.positions.len())?;
        let mut moved = self.expanded(parameters)?;
        if let Some(anchors) = &self.anchors {
            let added = anchors.at_parameters(parameters, None)?;
            moved.iter_mut().zip(added).for_each(|(u, added)| *u += added);
        }
        Ok(Dirichlet::of_body(body).write_over(&moved))
    }

    /// Displacement of the Taylor expansion alone, node by node \[length\].
    pub(crate) fn expanded(&self, parameters: &[f64]) -> Result<Vec<f64>> {
        check_terms(self.slopes.len() - usize::from(!self.rates.is_empty()), parameters.len())?;
        let mut terms = with_amplitude(terms(parameters), &self.rates);
        terms.truncate(self.slopes.len());
        let clusters = 6 * self.tree.centres.len();
        let mut outputs = vec![0.0; clusters + self.origin.len()];
        for (slope, term) in self.slopes.iter().zip(terms) {
            outputs.iter_mut().zip(slope).for_each(|(y, slope)| *y += term * slope);
        }
        let moved = self.tree.moved(&outputs[..clusters], &outputs[clusters..]);
        Ok(moved.iter().zip(&*self.origin).map(|(u, at)| u + at).collect())
    }

    /// Motions that pass through further solved states.
    pub(crate) fn with_anchors(self, anchors: Anchors) -> Self {
        Self { anchors: Some(anchors.into()), ..self }
    }

    /// The slopes as features of a graph's nodes, virtual ones after the real ones: six columns for each change that outputs follow, of
    /// which real nodes fill three. In units of outputs, they mean the same on every body.
    pub fn features(&self) -> FeatureMatrix {
        let (clusters, nodes) = (self.tree.centres.len(), self.tree.node_parents.len());
        let columns = 6 * self.slopes.len();
        let row = |node: usize| {
            self.slopes.iter().flat_map(move |slope| -> [f64; 6] {
                let (of_clusters, of_nodes) = slope.split_at(6 * clusters);
                match node.checked_sub(nodes) {
                    Some(cluster) => std::array::from_fn(|i| of_clusters[6 * cluster + i]),
                    None => {
                        std::array::from_fn(|i| if i < 3 { of_nodes[3 * node + i] } else { 0.0 })
                    }
                }
            })
        };
        let values = (0..nodes + clusters).flat_map(row).collect();
        FeatureMatrix { rows: nodes + clusters, columns, values }
    }

    /// Taylor coefficients of [`Motions::with_expansion`]: outputs of clusters, six each, and then of nodes, three each.
    pub fn slopes(&self) -> &[Vec<f64>] {
        &self.slopes
    }

    /// Logarithm of the amplitude per unit of each term, see [`Motions::in_proportion`]; none where outputs follow without one.
    pub fn rates(&self) -> &[f64] {
        &self.rates
    }

    /// Further solved states that displacements go through, see [`Motions::through`]; none where there is one alone.
    pub fn anchors(&self) -> Option<&Arc<Anchors>> {
        self.anchors.as_ref()
    }

    /// Outputs scaled so that unit outputs of all nodes together cost this `energy`.
    ///
    /// # Errors
    /// An energy that is not positive.
    pub fn of_energy(mut self, energy: f64) -> Result<Self> {
        require_positive("the energy of outputs of one", energy)?;
        let size = (2.0 * energy / self.unknowns as f64).sqrt();
        let tree = Arc::make_mut(&mut self.tree);
        let of_nodes = tree.node_scales.as_flattened_mut().as_flattened_mut();
        let of_clusters = tree.cluster_scales.as_flattened_mut().as_flattened_mut();
        of_nodes.iter_mut().chain(of_clusters).for_each(|entry| *entry *= size);
        let slopes = self.slopes.iter().map(|slope| slope.iter().map(|y| y / size).collect());
        self.slopes = slopes.collect();
        Ok(self)
    }

    /// Displacement of zero outputs, node by node \[length\].
    pub fn origin(&self) -> &[f64] {
        &self.origin
    }

    /// The clusters, with their scales.
    pub fn tree(&self) -> &Arc<MotionTree> {
        &self.tree
    }
}

/// Adds a part of one row to another.
fn add(rows: &mut [Vec<f64>], to: usize, from: usize, part: f64) {
    let other = rows[from].clone();
    rows[to].iter_mut().zip(other).for_each(|(y, other)| *y += part * other);
}

/// The stiffness of a body at a displacement.
fn stiffness(body: &Body, displacement: &[f64], theta: &[f64]) -> Result<Stiffness> {
    require_count("displacement values", displacement.len(), 3 * body.nodes)?;
    require_finite("a displacement", displacement)?;
    body.check_theta(theta)?;
    body.stiffness(displacement, theta).ok_or(CoordinateError::NoStiffness)
}

/// Energies of motions of nodes and of clusters.
struct Costs<'a> {
    stiffness: &'a Stiffness,
    /// Projector onto the free directions of each node.
    free: &'a [[[f64; 3]; 3]],
    places: &'a [[f64; 3]],
}

impl Costs<'_> {
    fn of_node(&self, node: usize) -> SMatrix<f64, 3, 3> {
        let own = self.stiffness.row(node).find(|(neighbour, _)| *neighbour == node);
        let block = own.map_or([[0.0; 3]; 3], |(_, block)| *block);
        let (free, block) = (matrix(&self.free[node]), matrix(&block));
        free * block * free
    }

    /// Gives every cluster of a tree its scale, layer by layer.
    fn scale_clusters(&self, tree: &mut MotionTree, roots_per_layer: &[usize]) {
        let mut ancestors = tree.node_parents.clone();
        let mut first = 0;
        for &count in roots_per_layer {
            let of_layer = self.of_clusters(&ancestors, first..first + count, &tree.centres);
            tree.cluster_scales.extend(of_layer.into_iter().map(|(cost, radius)| {
                let mut scale = inverse_root(cost);
                scale[3..].as_flattened_mut().iter_mut().for_each(|entry| *entry /= radius);
                scale
            }));
            first += count;
            for ancestor in &mut ancestors {
                *ancestor = tree.cluster_parents[*ancestor].unwrap_or(*ancestor);
            }
        }
    }

    /// Translations, and turns measured by the displacement at the radius of gyration, of each cluster of a layer, and
    /// that radius. `ancestors` are the clusters of the nodes.
    fn of_clusters(
        &self,
        ancestors: &[usize],
        layer: std::ops::Range<usize>,
        centres: &[[f64; 3]],
    ) -> Vec<(SMatrix<f64, 6, 6>, f64)> {
        let mut sums = vec![(0.0, 0usize); layer.len()];
        let arm = |node: usize| -> [f64; 3] {
            std::array::from_fn(|i| self.places[node][i] - centres[ancestors[node]][i])
        };
        for (node, &cluster) in ancestors.iter().enumerate() {
            let sum = &mut sums[cluster - layer.start];
            *sum = (sum.0 + arm(node).iter().map(|r| r * r).sum::<f64>(), sum.1 + 1);
        }
        let radius = |&(squares, count): &(f64, usize)| {
            let radius = (squares / count.max(1) as f64).sqrt();
            if radius > 0.0 { radius } else { 1.0 }
        };
        let mut costs: Vec<_> =
            sums.iter().map(|sum| (SMatrix::<f64, 6, 6>::zeros(), radius(sum))).collect();
        let rigid = |node: usize, radius: f64| {
            matrix(&self.free[node]) * rigid_motions(arm(node).map(|r| r / radius))
        };
        for (node, &cluster) in ancestors.iter().enumerate() {
            let (cost, radius) = &mut costs[cluster - layer.start];
            let mut force = SMatrix::<f64, 3, 6>::zeros();
            for (neighbour, block) in self.stiffness.row(node) {
                if ancestors[neighbour] == cluster {
                    force += matrix(block) * rigid(neighbour, *radius);
                }
            }
            *cost += rigid(node, *radius).transpose() * force;
        }
        costs
    }
}

fn matrix(entries: &[[f64; 3]; 3]) -> SMatrix<f64, 3, 3> {
    SMatrix::from_fn(|i, j| entries[i][j])
}

/// `|A|^(−½)` on the directions that cost anything.
fn inverse_root<const N: usize>(cost: SMatrix<f64, N, N>) -> [[f64; N]; N] {
    let symmetric = DMatrix::from_fn(N, N, |i, j| 0.5 * (cost[(i, j)] + cost[(j, i)]));
    let root = of_eigenvalues(symmetric, SMALLEST_STIFFNESS, |value| value.abs().powf(-0.5));
    std::array::from_fn(|i| std::array::from_fn(|j| root[(i, j)]))
}

/// A function of a symmetric matrix by that of its eigenvalues, zero for those below a part of the largest.
pub(crate) fn of_eigenvalues(
    symmetric: DMatrix<f64>,
    smallest: f64,
    function: impl Fn(f64) -> f64,
) -> DMatrix<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(symmetric);
    let floor = smallest * eigenvalues.amax();
    let function = |value: f64| if value.abs() > floor { function(value) } else { 0.0 };
    &eigenvectors * DMatrix::from_diagonal(&eigenvalues.map(function)) * eigenvectors.transpose()
}

/// Displacement of a node by translations and small turns about a place so far from it.
pub(crate) fn rigid_motions([x, y, z]: [f64; 3]) -> SMatrix<f64, 3, 6> {
    SMatrix::from_row_slice(&[
        1.0, 0.0, 0.0, 0.0, z, -y, //
        0.0, 1.0, 0.0, -z, 0.0, x, //
        0.0, 0.0, 1.0, y, -x, 0.0,
    ])
}

/// How motions are stored: numbers as bytes, so that they come back the same.
#[derive(Serialize, Deserialize)]
struct Packed {
    unknowns: usize,
    node_parents: Vec<usize>,
    cluster_parents: Vec<Option<usize>>,
    origin: String,
    positions: String,
    centres: String,
    node_scales: String,
    cluster_scales: String,
    #[serde(default)]
    slopes: Vec<String>,
    #[serde(default)]
    rates: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    anchors: Option<Anchors>,
}

impl From<Motions> for Packed {
    fn from(motions: Motions) -> Self {
        let tree = &motions.tree;
        Self {
            unknowns: motions.unknowns,
            node_parents: tree.node_parents.clone(),
            cluster_parents: tree.cluster_parents.clone(),
            origin: packed::doubles(&motions.origin),
            positions: packed::doubles(tree.positions.as_flattened()),
            centres: packed::doubles(tree.centres.as_flattened()),
            node_scales: packed::doubles(tree.node_scales.as_flattened().as_flattened()),
            cluster_scales: packed::doubles(tree.cluster_scales.as_flattened().as_flattened()),
            slopes: motions.slopes.iter().map(|slope| packed::doubles(slope)).collect(),
            rates: motions.rates.to_vec(),
            anchors: motions.anchors.as_deref().cloned(),
        }
    }
}

impl TryFrom<Packed> for Motions {
    type Error = String;

    fn try_from(packed: Packed) -> std::result::Result<Self, String> {
        let (nodes, clusters) = (packed.node_parents.len(), packed.cluster_parents.len());
        let read = |text: &str, count: usize| packed::read_doubles(text, count);
        let known = packed.node_parents.iter().all(|&parent| parent < clusters);
        let ascending = packed.cluster_parents.iter().enumerate();
        if !known || !ascending.clone().all(|(k, p)| p.is_none_or(|p| p > k && p < clusters)) {
            return Err("clusters of the outputs do not form a tree".into());
        }
        let tree = MotionTree {
            positions: read(&packed.positions, 3 * nodes)?.as_chunks().0.to_vec(),
            centres: read(&packed.centres, 3 * clusters)?.as_chunks().0.to_vec(),
            node_scales: read(&packed.node_scales, 9 * nodes)?.as_chunks().0.as_chunks().0.to_vec(),
            cluster_scales: read(&packed.cluster_scales, 36 * clusters)?
                .as_chunks()
                .0
                .as_chunks()
                .0
                .to_vec(),
            node_parents: packed.node_parents,
            cluster_parents: packed.cluster_parents,
        };
        let origin: Arc<[f64]> = read(&packed.origin, 3 * nodes)?.into();
        let slopes = packed.slopes.iter().map(|slope| read(slope, 6 * clusters + 3 * nodes));
        let slopes: Arc<[Vec<f64>]> = slopes.collect::<std::result::Result<_, _>>()?;
        let rates: Arc<[f64]> = packed.rates.into();
        if !rates.is_empty() && rates.len() + 1 != slopes.len() {
            return Err("the amplitude of the outputs has other terms than they".into());
        }
        if packed.anchors.as_ref().is_some_and(|anchors| anchors.length() != origin.len()) {
            return Err("the anchors of the outputs have other nodes than they".into());
        }
        let (unknowns, anchors) = (packed.unknowns, packed.anchors.map(Arc::new));
        Ok(Self { origin, unknowns, tree: tree.into(), slopes, rates, anchors })
    }
}
