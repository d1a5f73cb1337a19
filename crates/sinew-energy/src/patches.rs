//! Averaged volume ratios over patches of quadrature points (F-bar), against volumetric locking.
//!
//! The energy of a point is that of `F̄ = (J̄/J)^(1/3) F` with the mean J̄ of J over its patch, after
//! E. A. de Souza Neto et al., Int. J. Solids Struct. 33 (1996) and Int. J. Numer. Meth. Engng 62 (2005).
//! Unlike theirs this is the derivative of an energy, so the tangent is symmetric.

use crate::Body;
use sinew_mesh::Mesh;
use sinew_num::{Mat3, cells_of_nodes};

/// Quadrature points of each patch: of a cell with several of them, or of about `cells` with one each.
pub(crate) fn patches<const N: usize>(
    mesh: &Mesh<N>,
    points: usize,
    cells: usize,
) -> Vec<Vec<usize>> {
    let groups = if points > 1 {
        (0..mesh.cells.len()).map(|cell| vec![cell]).collect()
    } else {
        compact_groups(mesh, cells.max(1))
    };
    let of_cell = |&cell: &usize| cell * points..(cell + 1) * points;
    groups.iter().map(|group| group.iter().flat_map(of_cell).collect()).collect()
}

/// Partition of the cells into connected groups of about `size`, each grown from the cell of least index by
/// the neighbour that shares most nodes with it. Groups that stay small join the smallest neighbouring group.
fn compact_groups<const N: usize>(mesh: &Mesh<N>, size: usize) -> Vec<Vec<usize>> {
    let cells_of = cells_of_nodes(mesh.points.len(), &mesh.cells);
    const FREE: usize = usize::MAX;
    let mut group_of = vec![FREE; mesh.cells.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for seed in 0..mesh.cells.len() {
        if group_of[seed] != FREE {
            continue;
        }
        let mut group = vec![seed];
        group_of[seed] = groups.len();
        while group.len() < size {
            let member_nodes: std::collections::BTreeSet<_> =
                group.iter().flat_map(|&cell| mesh.cells[cell]).collect();
            let near = member_nodes.iter().flat_map(|&node| &cells_of[node]);
            let shared =
                |cell: usize| mesh.cells[cell].iter().filter(|n| member_nodes.contains(n)).count();
            let best = near.filter(|&&cell| group_of[cell] == FREE);
            // Of equal ones the least index, so that the partition is the same everywhere.
            let best = best.map(|&cell| (shared(cell), std::cmp::Reverse(cell))).max();
            let Some((shared, std::cmp::Reverse(cell))) = best else { break };
            if shared + 1 < N {
                break;
            }
            group_of[cell] = groups.len();
            group.push(cell);
        }
        groups.push(group);
    }
    join_small_groups(mesh, &cells_of, size, &mut group_of, groups)
}

/// Merges groups below half the size with the smallest one that shares a facet.
fn join_small_groups<const N: usize>(
    mesh: &Mesh<N>,
    cells_of: &[Vec<usize>],
    size: usize,
    group_of: &mut [usize],
    mut groups: Vec<Vec<usize>>,
) -> Vec<Vec<usize>> {
    for index in 0..groups.len() {
        if 2 * groups[index].len() > size {
            continue;
        }
        let across = groups[index].iter().flat_map(|&cell| {
            let nodes = mesh.cells[cell];
            let near = nodes.into_iter().flat_map(|node| &cells_of[node]);
            near.filter(move |&&other| {
                mesh.cells[other].iter().filter(|n| nodes.contains(n)).count() + 1 == N
            })
        });
        let others = across.map(|&cell| group_of[cell]).filter(|&other| other != index);
        let Some(target) = others.min_by_key(|&other| (groups[other].len(), other)) else {
            continue;
        };
        let moved = std::mem::take(&mut groups[index]);
        moved.iter().for_each(|&cell| group_of[cell] = target);
        groups[target].extend(moved);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// Kinematics of a patch: its mean volume ratio and the scaled F of its points.
#[derive(Clone, Debug)]
pub struct PatchKinematics {
    /// Reference volume \[length³\].
    pub volume: f64,
    /// Mean volume ratio J̄.
    pub mean: f64,
    /// Displacement gradient H at each point.
    pub gradients: Vec<Mat3<f64>>,
    /// `F̄ − I` at each point.
    pub scaled: Vec<Mat3<f64>>,
    /// `(J̄/J)^(1/3)` at each point.
    pub scales: Vec<f64>,
}

impl Body {
    /// Kinematics of a patch of points; `None` where a cell is inverted.
    pub fn patch_kinematics(
        &self,
        patch: &[usize],
        displacement: &[f64],
    ) -> Option<PatchKinematics> {
        let gradients: Vec<_> =
            patch.iter().map(|&point| self.displacement_gradient(point, displacement)).collect();
        let volume: f64 = patch.iter().map(|&point| self.volumes[point]).sum();
        let change = |h: &Mat3<f64>| h.volume_change();
        let weighted =
            patch.iter().zip(&gradients).map(|(&point, h)| self.volumes[point] * change(h));
        let mean_change = weighted.sum::<f64>() / volume;
        // Written so that a NaN is inadmissible.
        let admissible = gradients.iter().all(|h| change(h) > -1.0);
        if !admissible {
            return None;
        }
        let logarithm = |h: &Mat3<f64>| (mean_change.ln_1p() - change(h).ln_1p()) / 3.0;
        let scales: Vec<f64> = gradients.iter().map(|h| logarithm(h).exp()).collect();
        let scaled = gradients.iter().map(|h| {
            let excess = logarithm(h).exp_m1();
            Mat3::from_fn(|i, j| {
                let identity = if i == j { excess } else { 0.0 };
                h[i][j] + excess * h[i][j] + identity
            })
        });
        let scaled = scaled.collect();
        Some(PatchKinematics { volume, mean: 1.0 + mean_change, gradients, scaled, scales })
    }

    /// Displacement gradient that the law reads at each quadrature point: H, or F̄ − I in a patch. `None` where a cell of a patch is inverted.
    pub fn law_gradients(&self, displacement: &[f64]) -> Option<Vec<Mat3<f64>>> {
        let own = |point| self.displacement_gradient(point, displacement);
        let mut gradients: Vec<_> = (0..self.volumes.len()).map(own).collect();
        for patch in &self.patches {
            let kinematics = self.patch_kinematics(patch, displacement)?;
            patch.iter().zip(kinematics.scaled).for_each(|(&point, h)| gradients[point] = h);
        }
        Some(gradients)
    }

    /// Adds the nodal forces of a first Piola–Kirchhoff stress at a point.
    pub fn add_forces(&self, point: usize, stress: &Mat3<f64>, forces: &mut [f64]) {
        let nodes = self.nodes_of_point(point);
        for (&node, g) in nodes.iter().zip(self.shape_of_point(point)) {
            let force = stress.apply(g);
            (0..3).for_each(|i| forces[3 * node + i] += self.volumes[point] * force[i]);
        }
    }
}

impl PatchKinematics {
    /// `P : F̄ / 3` of the stresses at F̄ at each point, and its integral over the current volume of the patch.
    pub fn thirds(&self, volumes: &[f64], stresses: &[Mat3<f64>]) -> (Vec<f64>, f64) {
        let third = |(stress, scaled): (&Mat3<f64>, &Mat3<f64>)| {
            let product: f64 = (0..9).map(|k| stress[k / 3][k % 3] * scaled[k / 3][k % 3]).sum();
            (product + stress.trace()) / 3.0
        };
        let thirds: Vec<_> = stresses.iter().zip(&self.scaled).map(third).collect();
        let sum = volumes.iter().zip(&thirds).map(|(v, t)| v * t).sum::<f64>();
        (thirds, sum / (self.volume * self.mean))
    }

    /// Turns the stresses at F̄ into those that are conjugate to F, point by point.
    pub fn work_conjugate(&self, volumes: &[f64], stresses: &mut [Mat3<f64>]) {
        let (thirds, mean) = self.thirds(volumes, stresses);
        for (((stress, h), scale), own) in
            stresses.iter_mut().zip(&self.gradients).zip(&self.scales).zip(&thirds)
        {
            let cofactor = h.plus_identity().cofactors();
            let weight = mean - own / (1.0 + h.volume_change());
            *stress = Mat3::from_fn(|i, j| scale * stress[i][j] + weight * cofactor[i][j]);
        }
    }
}
