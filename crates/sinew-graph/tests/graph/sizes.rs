//! Sizes of the layers of virtual nodes.

use sinew_graph::AugmentationConfig;

/// Most roots of a last layer: any bound from 24 to 57 gives the lists of thesis Table 3.1.
const LAST_LAYER: usize = 32;

#[test]
fn layers_shrink_down_to_a_small_last_one() {
    for nodes in 4..5000 {
        let config = AugmentationConfig::for_nodes(nodes);
        let layers = config.roots_per_layer;
        let mut leaves = nodes;
        for (at, &roots) in layers.iter().enumerate() {
            assert_eq!(roots, leaves / 4);
            let last = at + 1 == layers.len();
            assert_eq!(roots <= LAST_LAYER, last, "{layers:?}");
            assert!(last || roots > config.neighbours);
            leaves = roots;
        }
    }
}

#[test]
fn small_meshes_get_no_virtual_nodes_and_large_ones_fewer_runs() {
    for nodes in 0..4 {
        assert!(AugmentationConfig::for_nodes(nodes).roots_per_layer.is_empty());
    }
    assert_eq!(AugmentationConfig::for_nodes(1570).runs, 10);
    assert_eq!(AugmentationConfig::for_nodes(21_952).runs, 1);
    assert_eq!(AugmentationConfig::for_nodes(usize::MAX).runs, 1);
}

#[test]
fn a_case_file_with_a_misspelt_field_is_refused() {
    let config = AugmentationConfig::for_nodes(390);
    let text = serde_json::to_string(&config).unwrap();
    assert_eq!(serde_json::from_str::<AugmentationConfig>(&text).unwrap(), config);
    let misspelt = text.replace("neighbours", "neighbors");
    assert!(serde_json::from_str::<AugmentationConfig>(&misspelt).is_err());
}
