//! Standardisation of features.

use sinew_graph::{ColumnStatistics, FeatureMatrix, FeatureStatistics, GraphFeatures};

fn features(nodes: &[f64], edges: &[f64]) -> GraphFeatures {
    let column = |v: &[f64]| FeatureMatrix { rows: v.len(), columns: 1, values: v.to_vec() };
    GraphFeatures { nodes: column(nodes), edges: column(edges) }
}

#[test]
fn over_all_rows_of_all_geometries() {
    let geometries = [features(&[1.0, 2.0], &[0.1; 3]), features(&[3.0, 6.0], &[0.1; 3])];
    let statistics = FeatureStatistics::over(&geometries).unwrap();
    let expected = ColumnStatistics { mean: vec![3.0], scale: vec![3.5f64.sqrt()] };
    assert_eq!(statistics.nodes, expected);
    let standardised = statistics.standardise(&geometries[1]).unwrap();
    assert_eq!(standardised.nodes.values, [0.0, 3.0 / 3.5f64.sqrt()]);
}

#[test]
fn a_constant_column_becomes_zeros() {
    let statistics = FeatureStatistics::over(&[features(&[0.0, 1.0], &[0.1; 7])]).unwrap();
    assert_eq!(statistics.edges, ColumnStatistics { mean: vec![0.1], scale: vec![1.0] });
    let standardised = statistics.standardise(&features(&[0.5], &[0.1; 2])).unwrap();
    assert_eq!(standardised.edges.values, [0.0; 2]);
    // Rounding alone is no spread either.
    let jitter = [1e6, 1e6 + 1e-7, 1e6 - 1e-7];
    let statistics = FeatureStatistics::over(&[features(&jitter, &[])]).unwrap();
    assert_eq!(statistics.nodes.scale, [1.0]);
    assert_eq!(statistics.edges, ColumnStatistics { mean: vec![0.0], scale: vec![1.0] });
}

#[test]
fn the_unit_of_length_does_not_matter() {
    for unit in [1.0, 2f64.powi(900), 2f64.powi(-900)] {
        let lengths = features(&[0.0], &[1.0, 2.0, 6.0].map(|x| unit * x));
        let statistics = FeatureStatistics::over(std::slice::from_ref(&lengths)).unwrap();
        assert_eq!(statistics.edges.scale, [unit * (14f64 / 3.0).sqrt()]);
        let standardised = statistics.standardise(&lengths).unwrap().edges.values;
        assert_eq!(standardised, [-2.0, -1.0, 3.0].map(|x| x / (14f64 / 3.0).sqrt()));
    }
}

#[test]
fn unlike_geometries_are_refused() {
    let none = FeatureStatistics::over(&[]).unwrap_err();
    assert_eq!(none.to_string(), "no geometry was given: at least 1 is needed");
    let one = features(&[1.0, 2.0], &[1.0, 3.0]);
    let mut two = one.clone();
    two.nodes = FeatureMatrix::from_rows(&[[0.0, 1.0]]);
    let error = FeatureStatistics::over(&[one.clone(), two.clone()]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "node features: 1 columns needed, 2 given: all geometries and their statistics must use the same features"
    );
    let statistics = FeatureStatistics::over(&[one]).unwrap();
    assert_eq!(statistics.standardise(&two), Err(error));
    let nan = features(&[f64::NAN], &[1.0]);
    let error = FeatureStatistics::over(&[nan]).unwrap_err();
    assert!(error.to_string().starts_with("node features: row 0, column 0 is NaN"), "{error}");
}
