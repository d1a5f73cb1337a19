//! Promises of a topology are checked, also of one that comes from a file.

use sinew_graph::Topology;

/// A path 0 – 1 – 2 – 3 below the roots 4 and 5.
fn path() -> Topology {
    Topology {
        real_nodes: 4,
        nodes: 6,
        senders: vec![1, 2, 3, 4, 4, 5, 5, 5],
        receivers: vec![0, 1, 2, 0, 1, 2, 3, 4],
        roots_per_layer: vec![2],
        clusters: vec![vec![0, 0, 1, 1]],
    }
}

fn broken(change: impl FnOnce(&mut Topology)) -> String {
    let mut topology = path();
    change(&mut topology);
    topology.validate().unwrap_err().to_string()
}

#[test]
fn a_valid_one_passes() {
    assert_eq!(path().validate(), Ok(()));
    assert_eq!((path().layer(0), path().layer(1)), (0..4, 4..6));
}

#[test]
fn each_broken_promise_has_its_error() {
    assert_eq!(
        broken(|t| t.nodes = 7),
        "nodes: 6 expected, 7 found; build the topology with `augment`"
    );
    assert_eq!(
        broken(|t| t.clusters[0][2] = 2),
        "leaf 2 of layer 0 names root 2, the layer above has 2"
    );
    assert_eq!(
        broken(|t| t.clusters[0] = vec![0; 4]),
        "root 1 of layer 1 has no leaves: its features would be undefined"
    );
    assert_eq!(
        broken(|t| t.receivers[0] = 1),
        "edge 0 runs from 1 to 1 in a graph of 6 nodes: senders must exist and exceed their receivers, a pair is stored once"
    );
    assert_eq!(
        broken(|t| t.senders[7] = 6),
        "edge 7 runs from 6 to 4 in a graph of 6 nodes: senders must exist and exceed their receivers, a pair is stored once"
    );
    assert_eq!(
        broken(|t| t.receivers[4] = 0),
        "edge 4 does not follow its predecessor in order: sort the edges, drop repeats"
    );
    assert_eq!(
        broken(|t| t.receivers.truncate(3)),
        "receivers: 8 expected, 3 found; build the topology with `augment`"
    );
}

#[test]
fn topologies_are_written_and_read() {
    let text = serde_json::to_string(&path()).unwrap();
    assert_eq!(serde_json::from_str::<Topology>(&text).unwrap(), path());
    let misspelt = text.replace("senders", "sender");
    assert!(serde_json::from_str::<Topology>(&misspelt).is_err());
}
