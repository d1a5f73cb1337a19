//! Nodes that cells connect.

use sinew_num::{cells_of_nodes, connected_components};

#[test]
fn components_are_in_the_order_of_their_least_nodes() {
    let cells: [&[usize]; 4] = [&[6, 4], &[1, 5, 0], &[], &[3, 5]];
    let expected = [vec![0, 1, 3, 5], vec![2], vec![4, 6], vec![7]];
    assert_eq!(connected_components(8, cells), expected);
    assert!(connected_components(0, [[0; 2]; 0]).is_empty());
}

#[test]
fn a_chain_in_any_order_is_one_component() {
    let links = [[7, 6], [3, 2], [5, 4], [1, 0], [6, 5], [2, 1], [4, 3]];
    assert_eq!(connected_components(8, links), [(0..8).collect::<Vec<_>>()]);
}

#[test]
fn nodes_list_their_cells_in_order() {
    let expected = [vec![0], vec![0, 1], vec![], vec![1]];
    assert_eq!(cells_of_nodes(4, [[1, 0], [3, 1]]), expected);
}
