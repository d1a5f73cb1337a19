//! Thesis Algorithm 1, with its settings.

use crate::{
    GraphError, Topology, kmeans::cluster, positions::Extent, positions::check_positions,
    positions::cluster_means,
};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use sinew_num::ascending;
use std::num::NonZero;

/// Augments the graph of a mesh with layers of virtual nodes (thesis Algorithm 1).
///
/// Layer `l` groups the nodes of layer `l − 1` into η_l clusters by k-means and puts a root at
/// the mean of each. Every root is joined to its leaves and to its κ nearest roots (all, where there are
/// no more than κ others); those of the last layer are all joined.
///
/// * `positions` — mesh node positions [any length unit]; of several geometries that shall
///   share the topology, their mean or a template.
/// * `mesh_edges` — pairs of mesh nodes, in any order and orientation; repeats are merged.
///
/// The same input gives the same topology, for any number of threads. Positions enter relative to the bounding box, so
/// translation or scaling of the body changes the topology only where rounding decides a tie. Coincident nodes and parts of
/// a mesh that share no cell are accepted: virtual nodes join them.
///
/// # Errors
/// When the mesh or the configuration is unusable, or the result is not connected.
pub fn augment(
    positions: &[[f64; 3]],
    mesh_edges: &[[usize; 2]],
    config: &AugmentationConfig,
) -> Result<Topology, GraphError> {
    let real_nodes = positions.len();
    ensure!(
        real_nodes >= 2,
        "a graph needs at least 2 nodes, the mesh has {real_nodes}: was the file read completely, and does it hold cells of the expected kind?"
    );
    let extent = check_positions(positions)?;
    check_edges(mesh_edges, real_nodes)?;
    check_config(config, real_nodes)?;

    let mut edges: Vec<[usize; 2]> =
        mesh_edges.iter().map(|&[a, b]| [a.max(b), a.min(b)]).collect();
    let mut leaves = in_unit_box(positions, extent);
    let mut first_leaf = 0;
    let mut clusters = Vec::with_capacity(config.roots_per_layer.len());
    for (layer, &roots) in config.roots_per_layer.iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(config.seed);
        random.set_stream(layer as u64);
        let cluster_of = cluster(&leaves, roots, config.runs, &mut random)?;
        let means = cluster_means(leaves.as_flattened(), 3, &cluster_of, roots);
        let positions: Vec<[f64; 3]> = means.as_chunks().0.to_vec();

        let first_root = first_leaf + leaves.len();
        // Those of the last layer are all joined.
        if layer + 1 < config.roots_per_layer.len() {
            let pairs = nearest_pairs(&positions, config.neighbours)?;
            edges.extend(pairs.iter().map(|pair| pair.map(|root| first_root + root)));
        }
        clusters.push(cluster_of);
        (leaves, first_leaf) = (positions, first_root);
    }
    let mut topology = Topology {
        real_nodes,
        nodes: first_leaf + leaves.len(),
        senders: Vec::new(),
        receivers: Vec::new(),
        roots_per_layer: config.roots_per_layer.clone(),
        clusters,
    };
    edges.extend(topology.edges_of_clusters());
    (topology.senders, topology.receivers) =
        ascending(edges).into_iter().map(|[sender, receiver]| (sender, receiver)).unzip();
    topology.validate()?;
    Ok(topology)
}

/// Positions relative to the bounding box, so that k-means' tolerance has a meaning.
fn in_unit_box(positions: &[[f64; 3]], (corner, longest): Extent) -> Vec<[f64; 3]> {
    let length = if longest > 0.0 { longest } else { 1.0 };
    let relative = |x: &[f64; 3]| std::array::from_fn(|axis| (x[axis] - corner[axis]) / length);
    positions.iter().map(relative).collect()
}

fn check_edges(mesh_edges: &[[usize; 2]], nodes: usize) -> Result<(), GraphError> {
    for (edge, &[a, b]) in mesh_edges.iter().enumerate() {
        ensure!(
            a < nodes && b < nodes,
            "mesh edge {edge} joins the nodes {a} and {b}, but there are {nodes} nodes, counted from 0: do the edges and the positions belong to the same mesh?"
        );
        ensure!(
            a != b,
            "mesh edge {edge} joins node {a} to itself: remove cells that repeat a node"
        );
    }
    Ok(())
}

fn check_config(config: &AugmentationConfig, nodes: usize) -> Result<(), GraphError> {
    ensure!(config.runs > 0, "k-means needs at least 1 run, `runs` is 0: 10 is a good number");
    let mut leaves = nodes;
    for (layer, &roots) in (1..).zip(&config.roots_per_layer) {
        ensure!(roots > 0, "layer {layer} asks for 0 virtual nodes: give fewer layers");
        ensure!(
            roots < leaves,
            "layer {layer} asks for {roots} virtual nodes of {leaves} below: each layer must be smaller than the one before; usual for this mesh are {:?}",
            AugmentationConfig::for_nodes(nodes).roots_per_layer
        );
        leaves = roots;
    }
    Ok(())
}

/// Pairs `[larger, smaller]` of roots of which one is among the `neighbours` nearest of the
/// other (thesis Eqs. 2.18 and 2.19, made symmetric as in Fig. 2.4).
///
/// Among roots at the same distance the lower index is taken, so the result depends neither on the
/// layout of the tree nor on threads. The immutable tree takes any number of points that share a
/// coordinate, as on regular grids, where trees with bounded buckets fail.
pub(crate) fn nearest_pairs(
    roots: &[[f64; 3]],
    neighbours: usize,
) -> Result<Vec<[usize; 2]>, GraphError> {
    let tree: ImmutableKdTree<f64, 3> =
        ImmutableKdTree::new_from_slice(roots).map_err(|error| {
            GraphError(format!("no nearest-neighbour tree of {} roots: {error}", roots.len()))
        })?;
    // The root itself is its own nearest, at distance zero.
    let wanted = NonZero::<usize>::MIN.saturating_add(neighbours);
    let mut pairs = Vec::with_capacity(roots.len() * neighbours);
    for (root, position) in roots.iter().enumerate() {
        let query = || tree.query(position);
        let nearest = query().nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
        let Some(reach) = nearest.last().map(|n| n.distance) else { continue };
        let within = query().within::<SquaredEuclidean<f64>>(reach).unsorted().execute();
        let mut others: Vec<(f64, usize)> = within
            .into_iter()
            .map(|n| (n.distance, n.item as usize))
            .filter(|&(_, other)| other != root)
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let kept = others.into_iter().take(neighbours);
        pairs.extend(kept.map(|(_, other)| [root.max(other), root.min(other)]));
    }
    Ok(ascending(pairs))
}

/// The inputs η and κ of thesis Algorithm 1, and how k-means is run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentationConfig {
    /// η: virtual nodes of layer 1, 2, …, strictly decreasing. Empty leaves the mesh graph as it is.
    pub roots_per_layer: Vec<usize>,
    /// κ: nearest roots each root is joined to, at most all others, in every layer but the last, which is fully connected.
    pub neighbours: usize,
    /// Seed of the k-means starts.
    pub seed: u64,
    /// k-means starts per layer; the one with the least inertia is kept.
    pub runs: usize,
}

impl AugmentationConfig {
    /// κ of the ventricles and of all scenes of thesis chapter 3.
    const NEIGHBOURS: usize = 5;
    /// Nodes of a tetrahedron: the factor by which thesis §2.2.3 shrinks each layer.
    const SHRINKAGE: usize = 4;
    /// No further layer follows one of at most this many roots. The lists of thesis Table 3.1
    /// end with 24, 14 and 24 roots and go on after 58, so any bound from 24 to 57 gives them.
    const LAST_LAYER: usize = 32;

    /// k-means runs of a mesh on which they are cheap. On the beam of 390 nodes ten instead of
    /// one lower the inertia by 4 % in layer 1 and 6 % in layer 2 (means over 100 seeds).
    const RUNS: usize = 10;
    /// Distances one k-means iteration may evaluate over all runs of the largest layer. It leaves
    /// ten runs to 4000 nodes and one to 21 952, where one takes seconds and gains little.
    const DISTANCES: usize = 45_000_000;

    /// Layers that shrink by four, the last one being the first of at most 32 roots, which are the lists of thesis
    /// Table 3.1.
    ///
    /// A mesh of fewer than four nodes gets no virtual nodes. The seed is 0; set another with
    /// `AugmentationConfig { seed, ..AugmentationConfig::for_nodes(nodes) }`.
    ///
    /// ```
    /// use sinew_graph::AugmentationConfig;
    ///
    /// assert_eq!(AugmentationConfig::for_nodes(390).roots_per_layer, [97, 24]);
    /// assert_eq!(AugmentationConfig::for_nodes(935).roots_per_layer, [233, 58, 14]);
    /// assert_eq!(AugmentationConfig::for_nodes(1570).roots_per_layer, [392, 98, 24]);
    /// ```
    pub fn for_nodes(nodes: usize) -> Self {
        let next = |&roots: &usize| (roots > Self::LAST_LAYER).then_some(roots / Self::SHRINKAGE);
        let first = Some(nodes / Self::SHRINKAGE).filter(|&roots| roots > 0);
        Self::of_layers(nodes, std::iter::successors(first, next).collect())
    }

    /// Layers that shrink by `shrinkage`, down to a single root: clusters within clusters up to the whole body, for
    /// outputs at every scale.
    ///
    /// ```
    /// use sinew_graph::AugmentationConfig;
    ///
    /// assert_eq!(AugmentationConfig::to_one_root(390, 4).roots_per_layer, [97, 24, 6, 1]);
    /// ```
    pub fn to_one_root(nodes: usize, shrinkage: usize) -> Self {
        let next = |&roots: &usize| (roots > 1).then(|| (roots / shrinkage.max(2)).max(1));
        let roots_per_layer = std::iter::successors(next(&nodes), next).collect();
        Self::of_layers(nodes, roots_per_layer)
    }

    /// Layers of so many virtual nodes on a mesh of `nodes` nodes.
    pub fn of_layers(nodes: usize, roots_per_layer: Vec<usize>) -> Self {
        let largest = roots_per_layer.first().copied().unwrap_or(0);
        let per_run = nodes.saturating_mul(largest).max(1);
        let runs = (Self::DISTANCES / per_run).clamp(1, Self::RUNS);
        Self { roots_per_layer, neighbours: Self::NEIGHBOURS, seed: 0, runs }
    }
}
