//! Nodes that cells connect.

use std::collections::BTreeMap;

/// Cells of each node, ascending. Nodes of cells must be below `nodes`.
pub fn cells_of_nodes<C: AsRef<[usize]>>(
    nodes: usize,
    cells: impl IntoIterator<Item = C>,
) -> Vec<Vec<usize>> {
    let mut cells_of = vec![Vec::new(); nodes];
    for (cell, nodes) in cells.into_iter().enumerate() {
        nodes.as_ref().iter().for_each(|&node| cells_of[node].push(cell));
    }
    cells_of
}

/// Members of a set, ascending, each once.
pub fn ascending<T: Ord>(members: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut members: Vec<T> = members.into_iter().collect();
    members.sort_unstable();
    members.dedup();
    members
}

/// Nodes of each connected component, ascending, in the order of their least nodes; a node in no cell is one of its own.
/// Nodes of cells must be below `nodes`.
pub fn connected_components<C: AsRef<[usize]>>(
    nodes: usize,
    cells: impl IntoIterator<Item = C>,
) -> Vec<Vec<usize>> {
    let mut parent: Vec<_> = (0..nodes).collect();
    for cell in cells {
        for pair in cell.as_ref().windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut components = vec![Vec::new(); nodes];
    (0..nodes).for_each(|node| components[root(&mut parent, node)].push(node));
    components.retain(|component| !component.is_empty());
    components
}

/// Cells of each connected component, in the order of their least nodes. Nodes of cells must be below `nodes`.
pub fn connected_cells<const K: usize>(nodes: usize, cells: &[[usize; K]]) -> Vec<Vec<[usize; K]>> {
    let mut component = vec![0; nodes];
    for (index, found) in connected_components(nodes, cells).iter().enumerate() {
        found.iter().for_each(|&node| component[node] = index);
    }
    let mut groups = BTreeMap::<usize, Vec<_>>::new();
    cells.iter().for_each(|cell| groups.entry(component[cell[0]]).or_default().push(*cell));
    groups.into_values().collect()
}

/// Root of the union-find tree, the least node of its component; the path to it is halved on the way.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}
