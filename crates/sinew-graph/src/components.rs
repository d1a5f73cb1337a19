//! Connected components.

/// Nodes of each connected component, largest first. Edge ends must be below `nodes`.
pub(crate) fn component_sizes(
    nodes: usize,
    edges: impl IntoIterator<Item = [usize; 2]>,
) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..nodes).collect();
    for [a, b] in edges {
        let (a, b) = (representative(&mut parent, a), representative(&mut parent, b));
        parent[a.max(b)] = a.min(b);
    }
    let mut sizes = vec![0usize; nodes];
    for node in 0..nodes {
        sizes[representative(&mut parent, node)] += 1;
    }
    sizes.retain(|&size| size > 0);
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

/// Follows parents to the root of the union-find tree, halving the path on the way.
fn representative(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn isolated_nodes_are_components() {
        assert_eq!(component_sizes(6, [[1, 0], [2, 1], [4, 3]]), [3, 2, 1]);
        assert!(component_sizes(0, []).is_empty());
    }
}
