//! Supports that leave a body free to move.

use crate::diagnose::hinges::free_piece;
use crate::{RigidMode, SolveError};
use nalgebra::{Matrix6, SymmetricEigen, Vector3, Vector6};
use sinew_energy::{Body, BodyArrays};
use sinew_num::connected_components;
use std::collections::HashMap;

/// A motion counts as free when the supports resist it by less than this, relative to what they
/// resist most; a support that grips a millionth of the body's size still holds.
const FREE: f64 = 1e-12;
/// Checks that each connected part of the body, and each piece of it that is only hinged to the others, is held
/// against all rigid motions.
pub(crate) fn check_supports(potential: &Body) -> Result<(), SolveError> {
    let parts = parts(potential);
    for part in &parts {
        let modes = free_modes(part, potential);
        if !modes.is_empty() {
            let (node, nodes) = (part[0].0, part.len());
            return Err(SolveError::FreeToMove { node, nodes, modes });
        }
    }
    match free_piece(potential, parts.len()) {
        None => Ok(()),
        Some((node, nodes, modes)) => Err(SolveError::FreeToMove { node, nodes, modes }),
    }
}

/// A connected part: its nodes with their positions relative to the first of them.
type Part = Vec<(usize, Vector3<f64>)>;

/// Connected parts.
fn parts(potential: &Body) -> Vec<Part> {
    let position = |node: usize| Vector3::from(potential.positions[node]);
    // A node in no cell is held: lowering refuses others.
    let parts = connected_components(potential.nodes, potential.cell_nodes()).into_iter();
    let relative = |part: Vec<usize>| {
        part.iter().map(|&node| (node, position(node) - position(part[0]))).collect()
    };
    parts.filter(|part| part.len() > 1).map(relative).collect()
}

/// Rigid motions of a part that neither prescribed displacements nor springs resist.
fn free_modes(part: &Part, potential: &Body) -> Vec<RigidMode> {
    let BodyArrays { prescribed, frames, springs, .. } = &**potential;
    let sprung: HashMap<_, _> = springs.iter().map(|s| (s.node, &s.stiffness)).collect();
    let stiffest = springs.iter().flat_map(|s| s.stiffness.as_flattened());
    let stiffest = stiffest.fold(f64::MIN_POSITIVE, |m: f64, k| m.max(k.abs()));
    let fixed = |n: &usize| (0..3).any(|i| prescribed[3 * n + i].is_some());
    let held = || part.iter().filter(|(n, _)| fixed(n) || sprung.contains_key(n));
    let (count, sum) = held().fold((0, Vector3::zeros()), |(n, sum), (_, x)| (n + 1, sum + x));
    let all: Vector3<f64> = part.iter().map(|(_, x)| x).sum();
    let centre = if count > 0 { sum / count as f64 } else { all / part.len() as f64 };
    // The unit of rotation is a turn that moves the farthest node by a unit.
    let size = part.iter().map(|(_, x)| (x - centre).norm()).fold(0.0, f64::max);

    let mut resistance = Matrix6::zeros();
    for (node, position) in held() {
        let arm = (position - centre) / size;
        let rows: [Vector6<f64>; 3] = std::array::from_fn(|i| {
            let axis = Vector3::ith(i, 1.0);
            let turn = arm.cross(&axis);
            Vector6::new(axis.x, axis.y, axis.z, turn.x, turn.y, turn.z)
        });
        for dof in (3 * node..3 * node + 3).filter(|&dof| prescribed[dof].is_some()) {
            let axis = frames.axis(dof);
            let row = rows[0] * axis[0] + rows[1] * axis[1] + rows[2] * axis[2];
            resistance += row * row.transpose();
        }
        let Some(stiffness) = sprung.get(node) else { continue };
        for i in 0..3 {
            for j in 0..3 {
                resistance += rows[i] * rows[j].transpose() * (stiffness[i][j] / stiffest);
            }
        }
    }
    let eigen = SymmetricEigen::new(resistance);
    let strongest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
    let free = (0..6).filter(|&i| eigen.eigenvalues[i] <= FREE * strongest);
    free.map(|i| {
        let mode = eigen.eigenvectors.column(i);
        RigidMode {
            translation: std::array::from_fn(|k| mode[k]),
            rotation: std::array::from_fn(|k| mode[3 + k]),
        }
    })
    .collect()
}
