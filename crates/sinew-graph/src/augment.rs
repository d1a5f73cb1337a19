//! Thesis Algorithm 1.

use crate::{
    AugmentationConfig, GraphError, Topology,
    kmeans::cluster,
    neighbours::nearest_pairs,
    positions::{Extent, check_positions, cluster_means},
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

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
/// a mesh that share no cell are accepted: virtual
/// nodes join them ([`Topology::mesh_components`] tells).
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
        let positions: Vec<_> = means.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect();

        let first_root = first_leaf + leaves.len();
        let upwards = cluster_of.iter().enumerate();
        edges.extend(upwards.map(|(leaf, root)| [first_root + root, first_leaf + leaf]));
        let last = layer + 1 == config.roots_per_layer.len();
        let pairs =
            if last { all_pairs(roots) } else { nearest_pairs(&positions, config.neighbours)? };
        edges.extend(pairs.iter().map(|pair| pair.map(|root| first_root + root)));

        clusters.push(cluster_of);
        (leaves, first_leaf) = (positions, first_root);
    }
    edges.sort_unstable();
    edges.dedup();
    let topology = Topology {
        real_nodes,
        nodes: first_leaf + leaves.len(),
        senders: edges.iter().map(|edge| edge[0]).collect(),
        receivers: edges.iter().map(|edge| edge[1]).collect(),
        roots_per_layer: config.roots_per_layer.clone(),
        clusters,
    };
    topology.validate()?;
    Ok(topology)
}

fn all_pairs(roots: usize) -> Vec<[usize; 2]> {
    (0..roots).flat_map(|larger| (0..larger).map(move |smaller| [larger, smaller])).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    const SIDES: [[usize; 2]; 4] = [[0, 1], [1, 2], [2, 3], [3, 0]];

    fn config(roots_per_layer: &[usize], neighbours: usize) -> AugmentationConfig {
        let roots_per_layer = roots_per_layer.to_vec();
        AugmentationConfig { roots_per_layer, neighbours, seed: 7, runs: 3 }
    }

    #[test]
    fn the_square_by_hand() {
        // Two heaps of two nodes each, whatever the seed; the roots are 4 and 5.
        let positions = SQUARE.map(|[x, y, z]| [10.0 * x, y, z]);
        let topology = augment(&positions, &SIDES, &config(&[2], 0)).unwrap();
        assert_eq!(topology.clusters, [[0, 1, 1, 0]]);
        let edges: Vec<_> = topology.edges().collect();
        let mesh = [[1, 0], [2, 1], [3, 0], [3, 2]];
        let virtual_ones = [[4, 0], [4, 3], [5, 1], [5, 2], [5, 4]];
        assert_eq!(edges, [mesh.as_slice(), &virtual_ones].concat());
        assert_eq!(topology.mesh_components(), [4]);
        assert_eq!(topology.inertia_per_leaf(&positions).unwrap(), [0.25]);
    }

    #[test]
    fn meshes_that_are_no_graph() {
        let none = config(&[], 5);
        assert_eq!(
            augment(&[], &[], &none),
            Err(GraphError("a graph needs at least 2 nodes, the mesh has 0: was the file read completely, and does it hold cells of the expected kind?".into()))
        );
        assert_eq!(
            augment(&SQUARE[..1], &[], &none),
            Err(GraphError("a graph needs at least 2 nodes, the mesh has 1: was the file read completely, and does it hold cells of the expected kind?".into()))
        );
        let expected = GraphError("mesh edge 1 joins the nodes 2 and 4, but there are 4 nodes, counted from 0: do the edges and the positions belong to the same mesh?".into());
        assert_eq!(augment(&SQUARE, &[[0, 1], [2, 4]], &none), Err(expected));
        let expected = GraphError(
            "mesh edge 0 joins node 3 to itself: remove cells that repeat a node".into(),
        );
        assert_eq!(augment(&SQUARE, &[[3, 3]], &none), Err(expected));
    }

    #[test]
    fn positions_that_are_no_numbers() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut positions = SQUARE;
            positions[2][1] = value;
            let error = augment(&positions, &SIDES, &config(&[2], 0)).unwrap_err();
            assert!(error.to_string().starts_with("coordinate 1 of node 2 is "), "{error}");
        }
        let mut positions = SQUARE;
        (positions[0][2], positions[1][2]) = (-1.5e308, 1.5e308);
        let error = augment(&positions, &SIDES, &config(&[2], 0)).unwrap_err();
        assert!(
            error.to_string().starts_with("coordinate 2 runs from -1.5e308 to 1.5e308"),
            "{error}"
        );
    }

    #[test]
    fn configurations_that_do_not_fit() {
        let error = |layers: &[usize], neighbours| {
            augment(&SQUARE, &SIDES, &config(layers, neighbours)).unwrap_err()
        };
        let larger = error(&[9], 1).to_string();
        assert!(larger.starts_with("layer 1 asks for 9 roots of 4 leaves"), "{larger}");
        assert!(larger.ends_with("`AugmentationConfig::for_nodes` gives [1]"), "{larger}");
        assert!(error(&[4], 1).to_string().starts_with("layer 1 asks for 4 roots of 4 leaves"));
        assert!(error(&[2, 2], 1).to_string().starts_with("layer 2 asks for 2 roots of 2 leaves"));
        assert_eq!(
            error(&[2, 0], 1),
            GraphError("layer 2 asks for 0 roots: shorten `roots_per_layer` instead".into())
        );
        let no_runs = AugmentationConfig { runs: 0, ..config(&[2], 1) };
        assert_eq!(
            augment(&SQUARE, &SIDES, &no_runs),
            Err(GraphError(
                "k-means needs at least 1 run, `runs` is 0: 10 is a good number".into()
            ))
        );
    }

    #[test]
    fn the_last_layer_and_small_ones_are_fully_connected_however_many_neighbours() {
        let topology = augment(&SQUARE, &SIDES, &config(&[3], 5)).unwrap();
        assert_eq!(topology.senders.len(), 4 + 4 + 3);
        let topology = augment(&SQUARE, &SIDES, &config(&[3, 2, 1], 5)).unwrap();
        assert_eq!(topology.senders.len(), 4 + (4 + 3) + (3 + 1) + 2);
    }

    #[test]
    fn parts_are_reported_and_joined_by_virtual_nodes() {
        let error = augment(&SQUARE, &[[0, 1]], &config(&[], 0)).unwrap_err();
        let parts = GraphError("the graph falls into 3 parts of 2 down to 1 nodes: merge coincident nodes, drop nodes no cell uses, or add a layer of virtual nodes to join them".into());
        assert_eq!(error, parts);
        let topology = augment(&SQUARE, &[[0, 1]], &config(&[2], 0)).unwrap();
        assert_eq!(topology.mesh_components(), [2, 1, 1]);
    }

    #[test]
    fn coincident_and_collinear_nodes() {
        let chain: Vec<_> = (1..60).map(|node| [node, node - 1]).collect();
        let collinear: Vec<_> = (0..60).map(|i| [0.0, 0.0, i as f64]).collect();
        let mut doubled = collinear.clone();
        doubled.copy_within(0..30, 30);
        for positions in [vec![[4.0; 3]; 60], collinear, doubled] {
            let topology = augment(&positions, &chain, &config(&[40, 20, 10], 5)).unwrap();
            assert_eq!(topology.nodes, 60 + 40 + 20 + 10);
        }
    }

    #[test]
    fn the_unit_of_length_does_not_matter() {
        let beam = sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
        let edges = sinew_mesh::edges(&beam);
        let config = AugmentationConfig::for_nodes(beam.points.len());
        let expected = augment(&beam.points, &edges, &config).unwrap();
        for unit in [0.5f64.powi(40), 2.0f64.powi(900)] {
            let scaled: Vec<_> = beam.points.iter().map(|x| x.map(|x| unit * x)).collect();
            assert_eq!(augment(&scaled, &edges, &config).unwrap(), expected);
        }
    }
}
