//! Potentials on a tetrahedral mesh: `−∇·(k ∇φ) = source` with prescribed values at some nodes.

use super::{FibreError, Result};
use crate::linear::{End, conjugate_gradients};
use nalgebra::{Matrix3, Vector3};
use sinew_mesh::TetMesh;

/// Residual of conjugate gradients \[relative to the right-hand side\]: rounding errors of a factor leave as much.
const ACCURACY: f64 = 1e-14;
/// Most iterations, or the number of unknowns if that is larger: some 170 reach the accuracy with 289 000 nodes.
const MOST: usize = 3_000;
/// Factor of over-relaxation. Iterations with 1, 1.5, 1.7 and 1.8: 154, 99, 92 and 98 with 28 000 nodes, 339, 205, 169 and 165 with 289 000.
const RELAXATION: f64 = 1.7;

/// The Laplace operator on linear tetrahedra.
pub(super) struct Laplacian<'m> {
    mesh: &'m TetMesh,
    /// Gradients of the four shape functions of each cell [1/length].
    shape_gradients: Vec<[Vector3<f64>; 4]>,
    /// Volume of each cell \[length³\].
    pub volumes: Vec<f64>,
}

impl<'m> Laplacian<'m> {
    /// # Errors
    /// A cell without volume.
    pub(super) fn new(mesh: &'m TetMesh) -> Result<Self> {
        let (mut shape_gradients, mut volumes) = (Vec::new(), Vec::new());
        for cell in 0..mesh.cells.len() {
            let volume = mesh.cell_volume(cell);
            let [o, a, b, c] = mesh.corners(cell);
            let edges = Matrix3::from_columns(&[a - o, b - o, c - o]);
            let inverse = edges.try_inverse().filter(|_| volume > 0.0);
            let inverse = inverse.ok_or_else(|| FibreError::Unfit(format!("cell {cell} has the volume {volume:e}; turn inverted cells over, and remove flat ones")))?;
            let [a, b, c] = [0, 1, 2].map(|i| inverse.row(i).transpose());
            shape_gradients.push([-(a + b + c), a, b, c]);
            volumes.push(volume);
        }
        Ok(Self { mesh, shape_gradients, volumes })
    }

    /// Nodal values of the potential. The conductivity, one per cell, is 1 unless given.
    ///
    /// # Errors
    /// Cells too flat. Each connected part of the mesh needs a prescribed node.
    pub(super) fn solve(
        &self,
        prescribed: &[Option<f64>],
        source: f64,
        conductivity: Option<&[f64]>,
    ) -> Result<Vec<f64>> {
        let free: Vec<_> = (0..prescribed.len()).filter(|&i| prescribed[i].is_none()).collect();
        let mut unknown = vec![usize::MAX; prescribed.len()];
        free.iter().enumerate().for_each(|(at, &node)| unknown[node] = at);
        let mut right = vec![0.0; free.len()];
        // Entries of each column from the diagonal up.
        let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); free.len()];
        for (cell, nodes) in self.mesh.cells.iter().enumerate() {
            let (shape, volume) = (&self.shape_gradients[cell], self.volumes[cell]);
            let weight = volume * conductivity.map_or(1.0, |k| k[cell]);
            for (a, &first) in nodes.iter().enumerate() {
                if prescribed[first].is_some() {
                    continue;
                }
                right[unknown[first]] += source * volume / 4.0;
                for (b, &second) in nodes.iter().enumerate() {
                    let entry = weight * shape[a].dot(&shape[b]);
                    match prescribed[second] {
                        Some(value) => right[unknown[first]] -= entry * value,
                        None if unknown[first] <= unknown[second] => {
                            let column = &mut columns[unknown[second]];
                            match column.iter_mut().find(|(row, _)| *row == unknown[first]) {
                                Some((_, sum)) => *sum += entry,
                                None => column.push((unknown[first], entry)),
                            }
                        }
                        None => {}
                    }
                }
            }
        }
        let solution = solved(columns, &right).ok_or_else(|| {
            FibreError::Unfit(format!(
                "no potential of {} unknowns was found, as cells are too flat; repair the mesh",
                free.len()
            ))
        })?;
        let mut values: Vec<_> = prescribed.iter().map(|value| value.unwrap_or(0.0)).collect();
        free.iter().zip(solution).for_each(|(&node, value)| values[node] = value);
        Ok(values)
    }

    /// Gradient in each cell [1/length].
    pub(super) fn gradients(&self, values: &[f64]) -> Vec<Vector3<f64>> {
        let gradient = |(nodes, shape): (&[usize; 4], &[Vector3<f64>; 4])| {
            (0..4).map(|a| shape[a] * values[nodes[a]]).sum()
        };
        self.mesh.cells.iter().zip(&self.shape_gradients).map(gradient).collect()
    }

    /// Mean of a field of the cells around each node, weighted by their volumes.
    pub(super) fn around_nodes(&self, of_cells: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut sums = vec![(Vector3::zeros(), 0.0); self.mesh.points.len()];
        for (cell, nodes) in self.mesh.cells.iter().enumerate() {
            for &node in nodes {
                sums[node].0 += of_cells[cell] * self.volumes[cell];
                sums[node].1 += self.volumes[cell];
            }
        }
        sums.into_iter().map(|(sum, volume)| sum / volume).collect()
    }
}

/// Solution by conjugate gradients preconditioned by symmetric successive over-relaxation, at the cost of a diagonal one (S. C. Eisenstat, SIAM J. Sci.
/// Stat. Comput. 2, 1981); `None` where they do not converge. The columns hold the entries of the upper half.
fn solved(columns: Vec<Vec<(usize, f64)>>, right: &[f64]) -> Option<Vec<f64>> {
    let diagonal = |(at, column): (usize, &Vec<(usize, f64)>)| {
        column.iter().find(|(row, _)| *row == at).map(|(_, entry)| entry.sqrt().recip())
    };
    let scale: Vec<f64> = columns.iter().enumerate().map(diagonal).collect::<Option<_>>()?;
    // The scaled matrix is L + I + Lᵀ, with rows of L one after the other: the sweeps wait for memory.
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for (at, column) in columns.into_iter().enumerate() {
        for (row, entry) in column.into_iter().filter(|(row, _)| *row != at) {
            rows.push(row as u32);
            values.push(entry * (scale[row] * scale[at]));
        }
        starts.push(rows.len());
    }
    let row_of = |at: usize| {
        let range = starts[at]..starts[at + 1];
        rows[range.clone()].iter().map(|&row| row as usize).zip(&values[range])
    };
    // (I/ω + L)⁻¹ and (I/ω + Lᵀ)⁻¹.
    let forward = |x: &mut [f64]| {
        for at in 0..x.len() {
            let known = row_of(at).map(|(row, entry)| entry * x[row]).sum::<f64>();
            x[at] = RELAXATION * (x[at] - known);
        }
    };
    let backward = |x: &mut [f64]| {
        for at in (0..x.len()).rev() {
            x[at] *= RELAXATION;
            let own = x[at];
            row_of(at).for_each(|(row, entry)| x[row] -= entry * own);
        }
    };
    let apply = |from: &[f64], to: &mut [f64]| {
        let mut inner = from.to_vec();
        backward(&mut inner);
        to.iter_mut()
            .zip(from)
            .zip(&inner)
            .for_each(|((to, x), y)| *to = x - (2.0 / RELAXATION - 1.0) * y);
        forward(to);
        to.iter_mut().zip(&inner).for_each(|(to, y)| *to += y);
    };
    let mut right: Vec<f64> = right.iter().zip(&scale).map(|(b, s)| b * s).collect();
    forward(&mut right);
    let copy = |from: &[f64], to: &mut [f64]| to.copy_from_slice(from);
    let most = MOST.max(right.len());
    let (mut solution, _, end) = conjugate_gradients(apply, copy, &right, ACCURACY, most);
    backward(&mut solution);
    solution.iter_mut().zip(&scale).for_each(|(x, s)| *x *= s);
    (end == End::Converged).then_some(solution)
}
