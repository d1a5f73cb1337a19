//! Graphs of small meshes by hand, and meshes and configurations that give none.

use sinew_graph::{AugmentationConfig, Topology, augment};

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const SIDES: [[usize; 2]; 4] = [[0, 1], [1, 2], [2, 3], [3, 0]];

fn config(roots_per_layer: &[usize], neighbours: usize) -> AugmentationConfig {
    let roots_per_layer = roots_per_layer.to_vec();
    AugmentationConfig { roots_per_layer, neighbours, seed: 7, runs: 3 }
}

fn on_square(roots_per_layer: &[usize], neighbours: usize) -> Topology {
    augment(&SQUARE, &SIDES, &config(roots_per_layer, neighbours)).unwrap()
}

fn refused(
    positions: &[[f64; 3]],
    mesh_edges: &[[usize; 2]],
    config: &AugmentationConfig,
) -> String {
    augment(positions, mesh_edges, config).unwrap_err().to_string()
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
    assert_eq!(crate::inertia(&topology, &positions), 0.25);
}

#[test]
fn meshes_that_are_no_graph() {
    let none = config(&[], 5);
    assert_eq!(
        refused(&[], &[], &none),
        "a graph needs at least 2 nodes, the mesh has 0: was the file read completely, and does it hold cells of the expected kind?"
    );
    assert_eq!(
        refused(&SQUARE[..1], &[], &none),
        "a graph needs at least 2 nodes, the mesh has 1: was the file read completely, and does it hold cells of the expected kind?"
    );
    assert_eq!(
        refused(&SQUARE, &[[0, 1], [2, 4]], &none),
        "mesh edge 1 joins the nodes 2 and 4, but there are 4 nodes, counted from 0: do the edges and the positions belong to the same mesh?"
    );
    assert_eq!(
        refused(&SQUARE, &[[3, 3]], &none),
        "mesh edge 0 joins node 3 to itself: remove cells that repeat a node"
    );
}

#[test]
fn positions_that_are_no_numbers() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut positions = SQUARE;
        positions[2][1] = value;
        let error = refused(&positions, &SIDES, &config(&[2], 0));
        assert!(error.starts_with("coordinate 1 of node 2 is "), "{error}");
    }
    let mut positions = SQUARE;
    (positions[0][2], positions[1][2]) = (-1.5e308, 1.5e308);
    let error = refused(&positions, &SIDES, &config(&[2], 0));
    assert!(error.starts_with("coordinate 2 runs from -1.5e308 to 1.5e308"), "{error}");
}

#[test]
fn configurations_that_do_not_fit() {
    let error = |layers: &[usize]| refused(&SQUARE, &SIDES, &config(layers, 1));
    let larger = error(&[9]);
    assert!(larger.starts_with("layer 1 asks for 9 virtual nodes of 4 below"), "{larger}");
    assert!(larger.ends_with("usual for this mesh are [1]"), "{larger}");
    assert!(error(&[4]).starts_with("layer 1 asks for 4 virtual nodes of 4 below"));
    assert!(error(&[2, 2]).starts_with("layer 2 asks for 2 virtual nodes of 2 below"));
    assert_eq!(error(&[2, 0]), "layer 2 asks for 0 virtual nodes: give fewer layers");
    let no_runs = AugmentationConfig { runs: 0, ..config(&[2], 1) };
    assert_eq!(
        refused(&SQUARE, &SIDES, &no_runs),
        "k-means needs at least 1 run, `runs` is 0: 10 is a good number"
    );
}

#[test]
fn the_last_layer_and_small_ones_are_fully_connected_however_many_neighbours() {
    assert_eq!(on_square(&[3], 5).senders.len(), 4 + 4 + 3);
    assert_eq!(on_square(&[3, 2, 1], 5).senders.len(), 4 + (4 + 3) + (3 + 1) + 2);
}

#[test]
fn parts_are_reported_and_joined_by_virtual_nodes() {
    assert_eq!(
        refused(&SQUARE, &[[0, 1]], &config(&[], 0)),
        "the graph falls into 3 parts of 2 down to 1 nodes: merge coincident nodes, drop nodes no cell uses, or add a layer of virtual nodes to join them"
    );
    let topology = augment(&SQUARE, &[[0, 1]], &config(&[2], 0)).unwrap();
    assert_eq!(topology.nodes, 4 + 2);
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
