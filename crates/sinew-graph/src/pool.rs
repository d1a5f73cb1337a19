//! Averages of mesh nodes at virtual nodes, through the clusters of a topology.

use crate::{
    FeatureMatrix, GraphError, Topology,
    positions::{check_positions, cluster_means},
};

/// Positions of all nodes of a geometry: a virtual node is the mean of its leaves (thesis
/// Eq. 2.16), found through the clusters of the shared topology instead of by k-means.
///
/// # Errors
/// When the positions do not belong to the topology or are not finite.
pub fn pool_positions(
    topology: &Topology,
    positions: &[[f64; 3]],
) -> Result<Vec<[f64; 3]>, GraphError> {
    topology.validate_clusters()?;
    let (expected, found) = (topology.real_nodes, positions.len());
    ensure!(
        expected == found,
        "node positions: {expected} rows needed, {found} given: use the mesh the graph was built of"
    );
    check_positions(positions)?;
    let pooled = pool(topology, positions.as_flattened(), 3);
    Ok(pooled.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect())
}

/// Features of all nodes: those of a virtual node are the mean over its leaves, layer by
/// layer (thesis §2.2.3).
///
/// # Errors
/// When the table does not have one row per mesh node or a number is not finite.
pub fn pool_features(
    topology: &Topology,
    real: &FeatureMatrix,
) -> Result<FeatureMatrix, GraphError> {
    topology.validate_clusters()?;
    real.check("node features", topology.real_nodes)?;
    let values = pool(topology, &real.values, real.columns);
    Ok(FeatureMatrix { rows: topology.nodes, columns: real.columns, values })
}

/// Appends the means over the clusters of every layer; the clusters must be valid.
fn pool(topology: &Topology, real: &[f64], columns: usize) -> Vec<f64> {
    let mut all = real.to_vec();
    let mut layer_start = 0;
    for (clusters, &roots) in topology.clusters.iter().zip(&topology.roots_per_layer) {
        let means = cluster_means(&all[layer_start..], columns, clusters, roots);
        layer_start = all.len();
        all.extend(means);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let (what, expected, found) = ("node positions", 3, 2);
        let error = GraphError(format!(
            "{what}: {expected} rows needed, {found} given: use the mesh the graph was built of"
        ));
        assert_eq!(pool_positions(&tree(), &[[0.0; 3]; 2]), Err(error));
        let short = FeatureMatrix { rows: 3, columns: 2, values: vec![0.0; 5] };
        let error = GraphError("a table of 3 rows and 2 columns cannot hold 5 values".into());
        assert_eq!(pool_features(&tree(), &short), Err(error));
        let nan = FeatureMatrix { rows: 3, columns: 1, values: vec![0.0, f64::NAN, 0.0] };
        let error = pool_features(&tree(), &nan).unwrap_err();
        assert!(error.to_string().contains("row 1, column 0 is NaN"), "{error}");
    }
}
