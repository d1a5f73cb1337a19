//! Reactions of the supports.

use crate::elements::supports::part;
use nalgebra::Vector3;
use sinew_energy::Body;

/// Resultant of the supports of a group of nodes on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// The nodes, ascending.
    pub nodes: Vec<usize>,
    /// Their mean reference position \[length\].
    pub centre: [f64; 3],
    /// Force \[stress·length²\].
    pub force: [f64; 3],
    /// Moment about `centre` of the forces at the deformed positions \[stress·length³\].
    pub moment: [f64; 3],
}

/// Reactions of held nodes, in groups that share cells: the two ends of a beam are two groups. The third
/// direction of a body in two dimensions, which is held everywhere, does not count.
pub(super) fn groups(potential: &Body, displacement: &[f64], forces: &[f64]) -> Vec<Reaction> {
    let axes = potential.element().dimension;
    let held = |node: usize| (0..axes).any(|i| potential.prescribed[3 * node + i].is_some());
    let mut parent: Vec<_> = (0..potential.nodes).collect();
    for nodes in potential.cell_nodes() {
        let mut of_cell = nodes.iter().copied().filter(|&node| held(node));
        let Some(first) = of_cell.next() else { continue };
        for node in of_cell {
            let (a, b) = (root(&mut parent, first), root(&mut parent, node));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut members = vec![Vec::new(); potential.nodes];
    for node in (0..potential.nodes).filter(|&node| held(node)) {
        members[root(&mut parent, node)].push(node);
    }
    let reaction = |nodes: Vec<usize>| {
        let place = |node: usize| Vector3::from(potential.positions[node]);
        let sum = nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + place(node));
        let centre = sum / nodes.len() as f64;
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for &node in &nodes {
            let dof = |i: usize| 3 * node + i;
            let held = part(potential, node, &[0, 1, 2].map(|i| forces[dof(i)]), true);
            let own = Vector3::from_fn(|i, _| if i < axes { held[i] } else { 0.0 });
            let moved = Vector3::from_fn(|i, _| displacement[dof(i)]);
            force += own;
            moment += (place(node) + moved - centre).cross(&own);
        }
        Reaction { nodes, centre: centre.into(), force: force.into(), moment: moment.into() }
    };
    members.into_iter().filter(|nodes| !nodes.is_empty()).map(reaction).collect()
}

/// The least node of a group, with the way there shortened.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}
