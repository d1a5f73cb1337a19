//! Supports along the coordinate axes or the axes of a node's own frame.

use crate::elements::{Assembly, turn};
use sinew_energy::{Body, BodyArrays, Frames};
use sinew_num::dot3;

/// Deviation of a node from its prescribed place, in a rotated frame, that is a rounding error \[relative to its
/// displacement\].
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Sets prescribed degrees of freedom to a fraction of the prescribed motion.
pub(crate) fn place(body: &Body, load_factor: f64, displacement: &mut [f64]) {
    let BodyArrays { prescribed, frames, .. } = &**body;
    for (dof, target) in prescribed.iter().enumerate() {
        let Some(target) = target.map(|u| load_factor * u) else { continue };
        if frames.get(dof / 3).is_none() {
            displacement[dof] = target;
            continue;
        }
        let off = target - frames.component(dof, displacement);
        let node = &displacement[dof / 3 * 3..][..3];
        let moved = node.iter().fold(target.abs(), |most, u| most.max(u.abs()));
        if off.abs() > ROUNDING * moved {
            frames.add(dof, off, displacement);
        }
    }
}

/// A node of a pressure's surface that slides along a plane which its support moves, if there is one. Lids may move.
pub(crate) fn is_moved_rim(body: &Body) -> Option<usize> {
    let slides = |node: usize| {
        let held = &body.prescribed[3 * node..3 * node + 3];
        held.contains(&None) && held.iter().flatten().any(|&u| u != 0.0)
    };
    let surfaces = body.pressures.iter().filter(|surface| surface.lids.is_empty());
    surfaces.flat_map(|surface| &surface.nodes).copied().find(|&node| slides(node))
}

/// The part of a node's vector that is along its held directions.
pub(crate) fn held_part(body: &Body, node: usize, vector: [f64; 3]) -> [f64; 3] {
    let held = |i: &usize| body.prescribed[3 * node + i].is_some();
    let mut part = [0.0; 3];
    for axis in (0..3).filter(held).map(|i| body.frames.axis(3 * node + i)) {
        let along = dot3(&axis, &vector);
        (0..3).for_each(|k| part[k] += along * axis[k]);
    }
    part
}

impl Assembly {
    /// Adds a symmetric matrix over the components of some nodes to the stiffness; `lower` gives an entry
    /// of its lower half by row and column, `places` say where they go.
    pub(crate) fn add_matrix(
        &mut self,
        frames: &Frames,
        nodes: &[usize],
        places: &[u32],
        lower: impl Fn(usize, usize) -> f64,
    ) {
        let rows = 0..3 * nodes.len();
        let entries = rows.flat_map(|row| (0..=row).map(move |column| (row, column)));
        let mut half: Vec<f64> = entries.map(|(row, column)| lower(row, column)).collect();
        turn(frames, nodes, &mut half);
        places.iter().zip(half).for_each(|(&place, entry)| self.matrix[place as usize] += entry);
    }
}
