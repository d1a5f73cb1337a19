//! Numbers on nodes and edges, and their means at virtual nodes.

use sinew_graph::{FeatureMatrix, Topology, graph_features, pool_features, pool_positions};

fn pair() -> Topology {
    Topology {
        real_nodes: 2,
        nodes: 2,
        senders: vec![1],
        receivers: vec![0],
        roots_per_layer: vec![],
        clusters: vec![],
    }
}

/// Nodes 0, 1, 2 below the roots 3 and 4, and these below root 5.
fn tree() -> Topology {
    Topology {
        real_nodes: 3,
        nodes: 6,
        senders: vec![3, 4, 4, 4, 5, 5],
        receivers: vec![0, 1, 2, 3, 3, 4],
        roots_per_layer: vec![2, 1],
        clusters: vec![vec![0, 1, 1], vec![0, 0]],
    }
}

#[test]
fn edges_point_from_sender_to_receiver() {
    let nodes = FeatureMatrix::indicator(2, &[1]).unwrap();
    let positions = [[1.0, 2.0, 7.0], [4.0, 6.0, 7.0]];
    let plane = graph_features(&pair(), &positions, &nodes, 2).unwrap();
    assert_eq!(plane.nodes.values, [0.0, 1.0]);
    assert_eq!(plane.edges.values, [-3.0, -4.0, 5.0]);
    let space = graph_features(&pair(), &positions, &nodes, 3).unwrap();
    assert_eq!(space.edges.values, [-3.0, -4.0, 0.0, 5.0]);
}

#[test]
fn dimensions_must_hold_the_shape() {
    let nodes = FeatureMatrix::indicator(2, &[]).unwrap();
    let features =
        |z, dimensions| graph_features(&pair(), &[[0.0; 3], [1.0, 0.0, z]], &nodes, dimensions);
    assert!(features(0.0, 1).is_ok());
    let error = features(0.5, 1).unwrap_err().to_string();
    assert!(error.starts_with("coordinate 2 runs from 0 to 0.5"), "{error}");
    assert!(error.ends_with("use 3"), "{error}");
    for dimensions in [0, 4] {
        assert_eq!(
            features(0.0, dimensions).unwrap_err().to_string(),
            format!("{dimensions} space dimensions were asked for: use 1, 2 or 3")
        );
    }
}

#[test]
fn columns_side_by_side() {
    let clamped = FeatureMatrix::indicator(2, &[0, 0]).unwrap();
    let fibres = FeatureMatrix::from_rows(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let both = clamped.hstack(&fibres).unwrap();
    assert_eq!((both.rows, both.columns), (2, 4));
    assert_eq!(both.row(1), [0.0, 4.0, 5.0, 6.0]);
    let three = FeatureMatrix::indicator(3, &[]).unwrap();
    assert!(clamped.hstack(&three).unwrap_err().to_string().contains("3 given"));
    assert_eq!(
        FeatureMatrix::indicator(2, &[2]).unwrap_err().to_string(),
        "node 2 of the set does not exist, there are 2 nodes, counted from 0"
    );
}

#[test]
fn roots_are_means_of_their_leaves_not_of_all_below() {
    let real = FeatureMatrix { rows: 3, columns: 2, values: vec![1., 0., 2., 6., 4., 0.] };
    let pooled = pool_features(&tree(), &real).unwrap();
    assert_eq!(pooled.values, [1., 0., 2., 6., 4., 0., 1., 0., 3., 3., 2., 1.5]);
    let positions = [[1., 0., 5.], [2., 6., 5.], [4., 0., 5.]];
    let pooled = pool_positions(&tree(), &positions).unwrap();
    assert_eq!(pooled[..3], positions);
    assert_eq!(pooled[3..], [[1., 0., 5.], [3., 3., 5.], [2., 1.5, 5.]]);
}

#[test]
fn constants_stay_exact() {
    let real = FeatureMatrix { rows: 3, columns: 1, values: vec![0.1; 3] };
    assert_eq!(pool_features(&tree(), &real).unwrap().values, [0.1; 6]);
}

#[test]
fn foreign_tables_are_refused() {
    assert_eq!(
        pool_positions(&tree(), &[[0.0; 3]; 2]).unwrap_err().to_string(),
        "node positions: 3 rows needed, 2 given: use the mesh the graph was built of"
    );
    let short = FeatureMatrix { rows: 3, columns: 2, values: vec![0.0; 5] };
    assert_eq!(
        pool_features(&tree(), &short).unwrap_err().to_string(),
        "a table of 3 rows and 2 columns cannot hold 5 values"
    );
    let nan = FeatureMatrix { rows: 3, columns: 1, values: vec![0.0, f64::NAN, 0.0] };
    let error = pool_features(&tree(), &nan).unwrap_err();
    assert!(error.to_string().contains("row 1, column 0 is NaN"), "{error}");
}
