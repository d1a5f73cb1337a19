//! Every promise of a topology is checked, also of one that comes from a file.

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
        broken(|t| t.clusters[0][1] = 1),
        "node 1 of layer 0 is joined to node 4 of layer 1, which is not its root: between layers a node is joined to its root only"
    );
    let error = broken(|t| {
        t.senders.pop();
        t.receivers.pop();
    });
    assert_eq!(
        error,
        "node 4 is not joined to node 5: each node needs its root, and a root of the last layer all others there"
    );
    assert_eq!(
        broken(|t| t.receivers.truncate(3)),
        "receivers: 8 expected, 3 found; build the topology with `augment`"
    );
}

#[test]
fn layers_must_follow_each_other() {
    let mut topology = path();
    topology.nodes = 7;
    topology.roots_per_layer.push(1);
    topology.clusters.push(vec![0, 0]);
    topology.senders.extend([6, 6]);
    topology.receivers.extend([4, 5]);
    assert_eq!(topology.validate(), Ok(()));
    topology.senders.insert(8, 6);
    topology.receivers.insert(8, 0);
    assert_eq!(
        topology.validate().unwrap_err().to_string(),
        "node 0 of layer 0 is joined to node 6 of layer 2, which is not its root: between layers a node is joined to its root only"
    );
}

#[test]
fn files_are_checked_when_read() {
    let text = serde_json::to_string(&path()).unwrap();
    assert_eq!(serde_json::from_str::<Topology>(&text).unwrap(), path());
    let turned = text.replace("[0,0,1,1]", "[0,0,1,0]");
    assert!(serde_json::from_str::<Topology>(&turned).is_err());
    let nodes = u64::MAX;
    let empty = format!(
        r#"{{"real_nodes":{nodes},"nodes":{nodes},"senders":[],"receivers":[],
           "roots_per_layer":[],"clusters":[]}}"#
    );
    let error = serde_json::from_str::<Topology>(&empty).unwrap_err();
    assert!(error.to_string().contains("0 edges cannot connect"), "{error}");
    // Roots whose pairs would take 80 GB.
    let many = 100_000;
    let star = Topology {
        real_nodes: many,
        nodes: 2 * many,
        senders: (1..2 * many).collect(),
        receivers: (0..2 * many - 1).collect(),
        roots_per_layer: vec![many],
        clusters: vec![(0..many).collect()],
    };
    let error = star.validate().unwrap_err().to_string();
    assert!(
        error.starts_with("the 100000 roots of the last layer need 4999950000 edges"),
        "{error}"
    );
}
