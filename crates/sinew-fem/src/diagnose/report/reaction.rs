//! Reactions of the supports.

use crate::elements::supports::part;
use nalgebra::Vector3;
use sinew_energy::Body;
use sinew_num::connected_components;

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
    let cells = potential.cell_nodes();
    let joined = cells.map(|nodes| nodes.iter().copied().filter(|&n| held(n)).collect::<Vec<_>>());
    let groups = connected_components(potential.nodes, joined).into_iter();
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
    groups.filter(|nodes| held(nodes[0])).map(reaction).collect()
}
