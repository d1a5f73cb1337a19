//! Thesis Algorithm 1.

use crate::{
    AugmentationConfig, GraphError, Topology,
    kmeans::cluster,
    neighbours::nearest_pairs,
    positions::{Extent, check_positions, cluster_means},
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_num::ascending;

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
        ensure!(roots > 0, "layer {layer} asks for 0 roots: shorten `roots_per_layer` instead");
        ensure!(
            roots < leaves,
            "layer {layer} asks for {roots} roots of {leaves} leaves: each layer must be smaller than the one before; for this mesh `AugmentationConfig::for_nodes` gives {:?}",
            AugmentationConfig::for_nodes(nodes).roots_per_layer
        );
        leaves = roots;
    }
    Ok(())
}
