//! Products of a stiffness.

use sinew_energy::Stiffness;

/// Forces `K u`.
pub(crate) fn product(stiffness: &Stiffness, displacement: &[f64]) -> Vec<f64> {
    let mut forces = vec![0.0; displacement.len()];
    for (node, force) in forces.chunks_exact_mut(3).enumerate() {
        for (neighbour, block) in stiffness.row(node) {
            let v = &displacement[3 * neighbour..];
            for (force, row) in force.iter_mut().zip(block) {
                *force += row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
            }
        }
    }
    forces
}
