//! Rigid motions of a body's clusters as the coordinates of its displacement.

mod costs;

pub(crate) use costs::{matrix, of_eigenvalues, rigid_motions};

use crate::coordinates::packed::{doubles, read_doubles};
use crate::coordinates::{
    Anchors, CoordinateError, Dirichlet, MotionTree, Result, all_terms, check_terms,
    cluster_centres, cluster_counts, ensure, expansion, require_count, require_finite,
    require_positive,
};
use serde::{Deserialize, Serialize};
use sinew_energy::Body;
use sinew_num::{add3, dot};
use std::sync::Arc;

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
    /// Taylor coefficients of the outputs of clusters, six each, then of nodes, three each, per unit of each standardised parameter and of
    /// each product of two; empty without a Taylor expansion.
    pub(super) slopes: Arc<[Vec<f64>]>,
    /// Logarithm of the amplitude per unit of each of these terms; none where outputs follow without one.
    pub(super) rates: Arc<[f64]>,
    /// Further solved states, whose displacements are added.
    pub(super) anchors: Option<Arc<Anchors>>,
}

/// A solved state that displacements are to go through.
#[derive(Clone, Debug)]
pub struct Anchor {
    /// Standardised parameters of the state.
    pub at: Vec<f64>,
    /// Taylor polynomial there, node by node \[length\]: the displacement, and its changes with each parameter and each product of two.
    pub changes: Vec<Vec<f64>>,
}

impl Motions {
    /// Motions about a displacement of a body \[length\], that of zero outputs, with the stiffness there at θ. The nested
    /// clusters are those of [`halves`](crate::coordinates::halves) or of a graph's virtual nodes. A unit output costs an energy of ½; see
    /// [`Motions::of_energy`].
    ///
    /// # Errors
    /// Clusters or a displacement that do not belong to the body, cells that the displacement inverts, no
    /// clusters, a body that no motion costs energy.
    pub fn about(
        displacement: &[f64],
        clusters: &[Vec<usize>],
        body: &Body,
        theta: &[f64],
    ) -> Result<Self> {
        let counts = cluster_counts(clusters, body.nodes)?;
        let [node_parents, above @ ..] = clusters else {
            return Err(CoordinateError::None("outputs at every scale need clusters"));
        };
        require_count("displacement values", displacement.len(), 3 * body.nodes)?;
        require_finite("a displacement", displacement)?;
        body.check_theta(theta)?;
        let dirichlet = Dirichlet::of_body(body);
        let (u, _) = displacement.as_chunks::<3>();
        let places: Vec<_> = body.positions.iter().zip(u).map(|(x, u)| add3(x, u)).collect();
        let mut centres = Vec::new();
        let mut cluster_parents = Vec::new();
        let mut leaves = places.clone();
        for (layer, &count) in clusters.iter().zip(&counts) {
            leaves = cluster_centres(&leaves, layer, count);
            centres.extend_from_slice(&leaves);
        }
        for (layer, count) in above.iter().zip(&counts) {
            let first = cluster_parents.len() + count;
            cluster_parents.extend(layer.iter().map(|cluster| Some(first + cluster)));
        }
        cluster_parents.resize(centres.len(), None);
        let table = dirichlet.projectors(3);
        let (rows, _) = table.as_chunks::<3>();
        let (free, _) = rows.as_chunks::<3>();
        let mut tree = MotionTree {
            node_scales: Vec::new(),
            cluster_parents,
            cluster_scales: Vec::new(),
            node_parents: node_parents.clone(),
            centres,
            positions: places,
        };
        costs::scale(&mut tree, &counts, (body, free), (displacement, theta))
            .ok_or(CoordinateError::None("the stiffness of the body is not finite at the displacement given: it inverts a cell, or an energy overflows; give a smaller one"))?;
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
    pub fn with_amplitude(
        mut self,
        changes: &[Vec<f64>],
        parameters: usize,
        body: &Body,
    ) -> Result<Self> {
        require_count("changes to second order", changes.len(), all_terms(parameters))?;
        let size = dot(&self.origin, &self.origin);
        require_positive("the displacement that an amplitude multiplies", size)?;
        let parts: Vec<f64> =
            changes.iter().map(|change| dot(&self.origin, change) / size).collect();
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
        let mut outputs = expansion((&self.slopes, &self.rates), parameters, None);
        outputs.resize(self.tree.of_clusters() + self.origin.len(), 0.0);
        let moved = self.tree.moved(&outputs);
        Ok(moved.iter().zip(&*self.origin).map(|(u, at)| u + at).collect())
    }

    /// The slopes as features of nodes, then of clusters, one row each: six columns for each change that outputs follow, of
    /// which nodes fill three. In units of outputs, they mean the same on every body.
    pub fn features(&self) -> Vec<f64> {
        let (clusters, nodes) = (self.tree.centres.len(), self.tree.node_parents.len());
        let row = |node: usize| {
            self.slopes.iter().flat_map(move |slope| {
                let (of_clusters, of_nodes) = slope.split_at(6 * clusters);
                let mut columns = [0.0; 6];
                match node.checked_sub(nodes) {
                    Some(cluster) => columns.copy_from_slice(&of_clusters[6 * cluster..][..6]),
                    None => columns[..3].copy_from_slice(&of_nodes[3 * node..][..3]),
                }
                columns
            })
        };
        (0..nodes + clusters).flat_map(row).collect()
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

/// Motions with their numbers as bytes, so that they are read to the bit.
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
    slopes: Vec<String>,
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
            origin: doubles(&motions.origin),
            positions: doubles(tree.positions.as_flattened()),
            centres: doubles(tree.centres.as_flattened()),
            node_scales: doubles(tree.node_scales.as_flattened().as_flattened()),
            cluster_scales: doubles(tree.cluster_scales.as_flattened().as_flattened()),
            slopes: motions.slopes.iter().map(|slope| doubles(slope)).collect(),
            rates: motions.rates.to_vec(),
            anchors: motions.anchors.as_deref().cloned(),
        }
    }
}

/// Square matrices that were packed one after the other.
fn read_matrices<const N: usize>(text: &str, count: usize) -> Result<Vec<[[f64; N]; N]>, String> {
    Ok(read_doubles(text, N * N * count)?.as_chunks().0.as_chunks().0.to_vec())
}

impl TryFrom<Packed> for Motions {
    type Error = String;

    fn try_from(packed: Packed) -> Result<Self, String> {
        let (nodes, clusters) = (packed.node_parents.len(), packed.cluster_parents.len());
        let known = packed.node_parents.iter().all(|&parent| parent < clusters);
        let mut parents = packed.cluster_parents.iter().enumerate();
        let above = parents.all(|(k, p)| p.is_none_or(|p| p > k && p < clusters));
        ensure(known && above, "clusters of the outputs do not form a tree")?;
        let tree = MotionTree {
            positions: read_doubles(&packed.positions, 3 * nodes)?.as_chunks().0.to_vec(),
            centres: read_doubles(&packed.centres, 3 * clusters)?.as_chunks().0.to_vec(),
            node_scales: read_matrices(&packed.node_scales, nodes)?,
            cluster_scales: read_matrices(&packed.cluster_scales, clusters)?,
            node_parents: packed.node_parents,
            cluster_parents: packed.cluster_parents,
        };
        let origin: Arc<[f64]> = read_doubles(&packed.origin, 3 * nodes)?.into();
        let slopes =
            packed.slopes.iter().map(|slope| read_doubles(slope, 6 * clusters + 3 * nodes));
        let slopes: Arc<[Vec<f64>]> = slopes.collect::<Result<_, _>>()?;
        let rates: Arc<[f64]> = packed.rates.into();
        let same_terms = rates.is_empty() || rates.len() + 1 == slopes.len();
        ensure(same_terms, "the amplitude of the outputs has other terms than they")?;
        let anchors = packed.anchors.as_ref();
        let same_nodes = anchors.is_none_or(|anchors| anchors.length() == origin.len());
        ensure(same_nodes, "the anchors of the outputs have other nodes than they")?;
        let (unknowns, anchors) = (packed.unknowns, packed.anchors.map(Arc::new));
        Ok(Self { origin, unknowns, tree: tree.into(), slopes, rates, anchors })
    }
}
