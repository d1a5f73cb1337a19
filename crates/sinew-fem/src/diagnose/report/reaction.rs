//! Reactions of the supports.

use super::forces::Forces;
use crate::SolveError;
use crate::elements::check::check_fields;
use crate::elements::state::State;
use crate::elements::supports::held_part;
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

/// Forces of the supports on the body \[stress·length²\], for each of [`held_sets`]; `pressure` is that of mixed elements, else empty.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_fem::{Options, Solver, reactions};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let (beam, theta) = (scene.lower()?, [75.0, 75.0]);
/// let solution = Solver::new(&beam)?.solve(&theta, &Options::default())?;
/// let found = reactions(&beam, &solution.displacement, &[], &theta)?;
/// assert!(found.len() == 1 && (found[0][2] - 98.0).abs() < 1e-6); // its weight, at x_min
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Arrays of other lengths than the body's.
pub fn reactions(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<Vec<[f64; 3]>, SolveError> {
    check_fields(body, displacement, pressure, theta)?;
    let total = Forces::of(body, State { displacement, theta, load_factor: 1.0, pressure }).total;
    let sum = |nodes: &[usize]| {
        nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + force_on(body, node, &total)).into()
    };
    Ok(held_sets(body).map(|(_, nodes)| sum(nodes)).collect())
}

/// Node sets of a body's mesh whose nodes are all held, with their names.
pub fn held_sets(body: &Body) -> impl Iterator<Item = (&String, &Vec<usize>)> {
    let all_held = |nodes: &[usize]| !nodes.is_empty() && nodes.iter().all(|&n| held(body, n));
    body.mesh.node_sets().iter().filter(move |(_, nodes)| all_held(nodes))
}

/// Whether a support holds a node; the third direction of a body in two dimensions does not count.
fn held(body: &Body, node: usize) -> bool {
    (0..body.element().dimension).any(|i| body.prescribed[3 * node + i].is_some())
}

/// Force of the supports on a node.
fn force_on(body: &Body, node: usize, forces: &[f64]) -> Vector3<f64> {
    let held = held_part(body, node, [0, 1, 2].map(|i| forces[3 * node + i]));
    Vector3::from_fn(|i, _| if i < body.element().dimension { held[i] } else { 0.0 })
}

/// Reactions of held nodes, in groups that share cells: the two ends of a beam are two groups. The third
/// direction of a body in two dimensions, which is held everywhere, does not count.
pub(super) fn groups(potential: &Body, displacement: &[f64], forces: &[f64]) -> Vec<Reaction> {
    let cells = potential.cell_nodes();
    let joined = cells
        .map(|nodes| nodes.iter().copied().filter(|&n| held(potential, n)).collect::<Vec<_>>());
    let groups = connected_components(potential.nodes, joined).into_iter();
    let reaction = |nodes: Vec<usize>| {
        let place = |node: usize| Vector3::from(potential.positions[node]);
        let sum = nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + place(node));
        let centre = sum / nodes.len() as f64;
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for &node in &nodes {
            let own = force_on(potential, node, forces);
            let moved = Vector3::from_fn(|i, _| displacement[3 * node + i]);
            force += own;
            moment += (place(node) + moved - centre).cross(&own);
        }
        Reaction { nodes, centre: centre.into(), force: force.into(), moment: moment.into() }
    };
    groups.filter(|nodes| held(potential, nodes[0])).map(reaction).collect()
}
