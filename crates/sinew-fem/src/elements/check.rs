//! Checks of arguments.

use crate::SolveError;
use crate::solve::balance::Balance;
use sinew_energy::{Body, PressureField, PressureSurface};

/// Checks that a displacement has one finite entry per degree of freedom.
pub(crate) fn check_displacement(body: &Body, displacement: &[f64]) -> Result<(), SolveError> {
    check_length(body.prescribed.len(), displacement)
}

/// Checks the lengths of a displacement and θ, in this order; swapped arguments have an error of their own.
pub(crate) fn check_state(
    balance: Balance<'_>,
    displacement: &[f64],
    theta: &[f64],
) -> Result<(), SolveError> {
    let body = balance.body;
    let (entries, parameters) = (body.prescribed.len(), body.theta_len());
    if entries != parameters && displacement.len() == parameters && theta.len() == entries {
        return Err(SolveError::Swapped { entries, parameters });
    }
    balance.check_theta(theta)?;
    check_displacement(body, displacement)
}

/// Checks that there are as many entries as needed, all finite.
pub(crate) fn check_length(needed: usize, values: &[f64]) -> Result<(), SolveError> {
    let (given, finite) = (values.len(), values.iter().filter(|u| u.is_finite()).count());
    if given == needed && finite == needed {
        return Ok(());
    }
    Err(SolveError::Initial { given, finite, needed })
}

/// The fields of a body and of its balance are public: checks that they fit each other.
pub(crate) fn check_arrays(balance: Balance<'_>) -> Result<(), SolveError> {
    let Balance { body: potential, whole: balance } = balance;
    let (cells, nodes) = (potential.cell_count(), potential.nodes);
    if cells == 0 {
        return Err(SolveError::EmptyMesh);
    }
    let known = |nodes_of: &[usize]| nodes_of.iter().all(|&node| node < nodes);
    let finite = |values: &[f64]| values.iter().all(|x| x.is_finite());
    let pressures =
        || potential.pressures.iter().chain(balance.into_iter().flat_map(|b| &b.followers));
    let places = |p: &PressureSurface| p.positions.len() == p.nodes.len();
    let whole =
        |p: &PressureSurface| p.rule.nodes > 0 && p.nodes.len().is_multiple_of(p.rule.nodes);
    let closed = |p: &PressureSurface| p.triangles.is_none() || p.rule.nodes == 3;
    let springs = || potential.springs.iter();
    let points = cells * potential.points_per_cell;
    let gradients = points * potential.nodes_per_cell;
    let frames = || potential.frames.nodes();
    let material = potential.material.points();
    let held = || potential.prescribed.iter().flatten();
    let positive = |&volume: &f64| volume > 0.0 && volume.is_finite();
    let patched = || potential.patches.iter().flatten();
    let field = balance.and_then(|balance| balance.pressure_field.as_ref());
    let fits = |field: &PressureField| {
        field.cells.len() == cells * field.corners
            && field.cells.iter().all(|&unknown| unknown < field.unknowns)
            && field.shape.len() == potential.points_per_cell
            && field.shape.iter().all(|row| row.len() == field.corners)
    };
    let gives = |field: &PressureField| field.compliance >= 0.0 && field.compliance.is_finite();
    let checks = [
        ("cells", "name nodes that do not exist", known(&potential.cells)),
        ("pressures", "name nodes that do not exist", pressures().all(|p| known(&p.nodes))),
        ("pressures", "have no position for each node", pressures().all(places)),
        ("pressures", "end within a facet", pressures().all(whole)),
        (
            "pressures",
            "are in closed form on facets that are no triangles",
            pressures().all(closed),
        ),
        (
            "pressures",
            "have positions that are not finite",
            pressures().all(|p| finite(p.positions.as_flattened())),
        ),
        ("springs", "name nodes that do not exist", springs().all(|s| s.node < nodes)),
        ("patches", "name points that do not exist", patched().all(|&point| point < points)),
        ("positions", "are not one per node", potential.positions.len() == nodes),
        ("positions", "are not finite", finite(potential.positions.as_flattened())),
        ("shape gradients", "are not one per point", potential.shape_gradients.len() == gradients),
        ("volumes", "are not one per point", potential.volumes.len() == points),
        ("directions", "are not one row per point", material.is_none_or(|rows| rows == points)),
        ("nodal forces", "are not three per node", potential.nodal_force.len() == 3 * nodes),
        ("supports", "are not three per node", potential.prescribed.len() == 3 * nodes),
        ("shape gradients", "are not finite", finite(potential.shape_gradients.as_flattened())),
        ("volumes", "are not positive", potential.volumes.iter().all(positive)),
        ("nodal forces", "are not finite", finite(&potential.nodal_force)),
        ("supports", "are not finite", held().all(|u| u.is_finite())),
        ("frames", "name nodes that do not exist", frames().all(|node| node < nodes)),
        ("unknown pressures", "are not those of its cells and points", field.is_none_or(fits)),
        ("compliance", "is below zero or not finite", field.is_none_or(gives)),
    ];
    match checks.iter().find(|(_, _, passed)| !passed) {
        Some(&(what, problem, _)) => Err(SolveError::Malformed { what, problem }),
        None => Ok(()),
    }
}
