//! Kernels of one tetrahedron.

use crate::sparsity::CELL_ENTRIES;
use sinew_energy::Response;
use sinew_num::Mat3;

/// Lower half of the 12×12 stiffness `V g_aj A_ijkl g_bl` of a tetrahedron, row by row.
///
/// The four shape gradients add up to zero, so the blocks of the first node follow from the others.
pub(crate) fn cell_stiffness(
    tangent: &[[f64; 9]; 9],
    shape: &[[f64; 3]; 4],
    volume: f64,
) -> [f64; CELL_ENTRIES] {
    let mut full = [[0.0; 12]; 12];
    for a in 1..4 {
        let g = shape[a].map(|x| volume * x);
        for i in 0..3 {
            let mut left = [0.0; 9];
            for kl in 0..9 {
                left[kl] = g[0] * tangent[3 * i][kl]
                    + g[1] * tangent[3 * i + 1][kl]
                    + g[2] * tangent[3 * i + 2][kl];
            }
            for b in 1..4 {
                for k in 0..3 {
                    let entry = left[3 * k] * shape[b][0]
                        + left[3 * k + 1] * shape[b][1]
                        + left[3 * k + 2] * shape[b][2];
                    full[3 * a + i][3 * b + k] = entry;
                    full[3 * a + i][k] -= entry;
                }
            }
            for k in 0..3 {
                full[i][k] -= full[3 * a + i][k];
            }
        }
    }
    let mut lower = [0.0; CELL_ENTRIES];
    let mut at = 0;
    for row in 0..12 {
        for column in 0..=row {
            lower[at] = full[row][column];
            at += 1;
        }
    }
    lower
}

/// `(I + H)⁻¹`.
pub(crate) fn inverse(h: &Mat3<f64>) -> Mat3<f64> {
    let f = Mat3::from_fn(|i, j| h[i][j] + if i == j { 1.0 } else { 0.0 });
    let scale = (1.0 + h.volume_change()).recip();
    Mat3::from_fn(|i, j| f.cofactor(j, i) * scale)
}

/// `A B`.
pub(crate) fn product(a: &Mat3<f64>, b: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
}

/// Rounding errors count this many times in the energy: its terms go through a dozen roundings.
const ENERGY_ROUNDINGS: f64 = 16.0;

/// Sums up how large rounding errors in energy and nodal forces can be.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rounding {
    /// Sum of the magnitudes of the terms of the energy.
    pub energy: f64,
    squared_force: f64,
}

impl Rounding {
    /// Adds one cell whose nodes move by `motion`: H carries the rounding errors of its terms `u g`, the
    /// stress those of 1 + H times the tangent.
    pub fn add_cell(
        &mut self,
        shape: &[[f64; 3]; 4],
        volume: f64,
        motion: f64,
        h: &Mat3<f64>,
        response: &Response,
    ) {
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let (slope, strain) = (largest(shape.as_flattened()), largest(h.0.as_flattened()));
        let stiffness = (0..9).map(|i| response.tangent[i][i].abs()).fold(0.0, f64::max);
        let force = volume * slope * stiffness * (1.0 + slope * motion);
        self.squared_force += force * force;
        self.energy += volume * stiffness * strain * (1.0 + strain);
    }

    /// Estimated norm of the error in the nodal forces.
    pub fn force_noise(&self) -> f64 {
        f64::EPSILON * self.squared_force.sqrt()
    }

    /// Bound on the error in the energy.
    pub fn energy_noise(&self) -> f64 {
        ENERGY_ROUNDINGS * f64::EPSILON * self.energy
    }
}
