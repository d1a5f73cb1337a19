//! Sums of edge messages at the nodes of a graph.

use super::comparison::{Comparison, device, random};
use burn::tensor::Tensor;
use sinew_gnn::fused::{EdgeTopology, received_edge_sum, reference, signed_edge_sum};
use std::sync::Arc;

// Node 4 has no edge; node 0 has a loop; edges 1 and 2 are parallel.
const NODES: usize = 5;
const SENDERS: [usize; 6] = [0, 1, 1, 2, 3, 0];
const RECEIVERS: [usize; 6] = [1, 2, 2, 0, 1, 0];

fn topology() -> Arc<EdgeTopology> {
    EdgeTopology::new(NODES, &SENDERS, &RECEIVERS)
}

#[test]
fn both_sums_agree_with_plain_tensors() {
    let (topology, device) = (topology(), device());
    for width in [1, 7, 40] {
        let messages = random([6, width], 1, &device);
        let comparison = Comparison::of([messages]);
        comparison.assert_close(
            |x| signed_edge_sum(x[0].clone(), &topology),
            |x| reference::signed_edge_sum(x[0].clone(), &topology),
        );
        comparison.assert_close(
            |x| received_edge_sum(x[0].clone(), &topology),
            |x| reference::received_edge_sum(x[0].clone(), &topology),
        );
    }
}

/// Sums in another order would round differently.
#[test]
fn every_message_counts_once_and_in_the_order_of_the_edges() {
    const WIDTH: usize = 40;
    let messages = random([SENDERS.len(), WIDTH], 3, &device());
    let values = messages.to_data().try_to_vec::<f32>().unwrap();
    let mut expected = vec![0.0_f32; NODES * WIDTH];
    let mut add = |ends: &[usize], sign: f32| {
        for (message, node) in values.chunks(WIDTH).zip(ends) {
            let sum = &mut expected[node * WIDTH..][..WIDTH];
            sum.iter_mut().zip(message).for_each(|(sum, x)| *sum += sign * x);
        }
        expected.clone()
    };
    let (received, signed) = (add(&RECEIVERS, 1.0), add(&SENDERS, -1.0));
    let found = |sum: Tensor<2>| sum.into_data().try_to_vec::<f32>().unwrap();
    assert_eq!(found(received_edge_sum(messages.clone(), &topology())), received);
    assert_eq!(found(signed_edge_sum(messages, &topology())), signed);
}

#[test]
fn signed_sums_vanish_in_total() {
    let messages = random([6, 3], 2, &device());
    let total = signed_edge_sum(messages, &topology()).sum_dim(0).abs().max().into_scalar::<f32>();
    assert!(total < 1e-6, "what one end receives the other sends: {total}");
}

#[test]
#[should_panic(expected = "Some(2)")]
fn nodes_that_do_not_exist_are_refused_with_numbers() {
    EdgeTopology::new(2, &[0, 2], &[1, 0]);
}

#[test]
#[should_panic(expected = "senders and receivers of edges")]
fn edges_without_an_end_are_refused() {
    EdgeTopology::new(2, &[0], &[1, 0]);
}
