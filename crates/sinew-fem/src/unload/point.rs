//! Kirchhoff stress at a quadrature point, and how it changes with the body at rest while the image is held.

use crate::elements::product;
use sinew_energy::Body;
use sinew_num::{Mat3, cross};

/// A quadrature point of the image. With E = ∂δX/∂x the unloaded body changes by δF = −F D and δV = V tr D, where D = E F; directions that
/// are carried turn by a spin W of the reference. The law does not see that spin, so `P(F, Q d) = P(F Q, d) Qᵀ` gives what it
/// does to the stress from the tangent A alone: `δP = A : F(W − D) − P W`.
pub(super) struct PointRate {
    /// Kirchhoff stress τ = P Fᵀ \[stress\].
    pub kirchhoff: Mat3<f64>,
    /// `∂τ_ij/∂E_kl` in row `3i + j` and column `3k + l`.
    pub rate: [[f64; 9]; 9],
    /// `∂τ/∂s` where F is scaled by eˢ.
    pub by_scale: Mat3<f64>,
    /// `∂ tr D/∂E_kl`.
    pub trace: [f64; 9],
}

/// `A Bᵀ`.
fn product_transposed(a: &Mat3<f64>, b: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| a[i][0] * b[j][0] + a[i][1] * b[j][1] + a[i][2] * b[j][2])
}

/// `T : G`.
fn contract(tensor: &[[f64; 9]; 9], g: &Mat3<f64>) -> Mat3<f64> {
    let flat = g.0.as_flattened();
    Mat3::from_fn(|i, j| (0..9).fold(0.0, |sum, kl| sum + tensor[3 * i + j][kl] * flat[kl]))
}

impl PointRate {
    /// The rate of a law at `scaled` = F̄ − I, which is `h` = F − I but for a scale. `None` outside the law's domain.
    pub(super) fn new(
        rest: &Body,
        point: usize,
        parameters: &[f64],
        [h, scaled]: [&Mat3<f64>; 2],
        carried: bool,
    ) -> Option<Self> {
        let response = rest.material.response(point, parameters, scaled);
        if !response.energy.is_finite() {
            return None;
        }
        let (f, f_bar, stress) = (h.plus_identity(), scaled.plus_identity(), &response.stress);
        let spatial = pushed(&response.tangent, &f_bar);
        let along = product_transposed(&contract(&response.tangent, &f_bar), &f_bar);
        let kirchhoff = product_transposed(stress, &f_bar);
        let (first, mut rate) = (product_transposed(stress, &f), [[0.0; 9]; 9]);
        for (row, entries) in rate.iter_mut().enumerate() {
            let (i, j) = (row / 3, row % 3);
            for k in 0..3 {
                let along = &spatial[row][3 * k..3 * k + 3];
                for l in 0..3 {
                    let stretched = along[0] * f[l][0] + along[1] * f[l][1] + along[2] * f[l][2];
                    entries[3 * k + l] = -stretched - first[i][l] * f_bar[j][k];
                }
            }
        }
        if carried {
            add_spins(&mut rate, rest.material.directions(point), [&f, &f_bar], stress, &spatial);
        }
        let trace = std::array::from_fn(|kl| f[kl % 3][kl / 3]);
        let by_scale = Mat3::from_fn(|i, j| along[i][j] + kirchhoff[i][j]);
        Some(Self { kirchhoff, rate, by_scale, trace })
    }

    /// The rate with `by_scale ⊗ trace` times a weight and `τ ⊗ trace` added.
    pub(super) fn with_volume(&self, by_scale: f64) -> [[f64; 9]; 9] {
        let mut rate = self.rate;
        for (row, entries) in rate.iter_mut().enumerate() {
            let (i, j) = (row / 3, row % 3);
            let weight = self.kirchhoff[i][j] + by_scale * self.by_scale[i][j];
            entries.iter_mut().zip(&self.trace).for_each(|(entry, t)| *entry += weight * t);
        }
        rate
    }
}

/// `∂(A : F̄ G) F̄ᵀ/∂G`.
fn pushed(tangent: &[[f64; 9]; 9], f: &Mat3<f64>) -> [[f64; 9]; 9] {
    let mut right = [[0.0; 9]; 9];
    for (to, from) in right.iter_mut().zip(tangent) {
        for m in 0..3 {
            for k in 0..3 {
                let weight = f[k][m];
                (0..3).for_each(|n| to[3 * m + n] += weight * from[3 * k + n]);
            }
        }
    }
    let mut both = [[0.0; 9]; 9];
    for (row, to) in both.iter_mut().enumerate() {
        for m in 0..3 {
            let (weight, from) = (f[row % 3][m], &right[3 * (row / 3) + m]);
            (0..9).for_each(|column| to[column] += weight * from[column]);
        }
    }
    both
}

/// Adds what the spin of carried directions does: that of the frame Q of `f M = Q R` with R upper triangular is
/// `W = Σ_{i>j} (q_i · D q_j) (q_i q_jᵀ − q_j q_iᵀ)`.
fn add_spins(
    rate: &mut [[f64; 9]; 9],
    directions: &[[f64; 3]],
    [f, f_bar]: [&Mat3<f64>; 2],
    stress: &Mat3<f64>,
    spatial: &[[f64; 9]; 9],
) {
    let Some(q) = completed(directions) else { return };
    for (i, j) in [(1, 0), (2, 0), (2, 1)] {
        let spin = Mat3::from_fn(|a, b| q[i][a] * q[j][b] - q[j][a] * q[i][b]);
        let direct = product_transposed(&product(stress, &spin), f_bar);
        let change = contract(spatial, &spin);
        let moved = f.apply(&q[j]);
        for (row, entries) in rate.iter_mut().enumerate() {
            let weight = change[row / 3][row % 3] - direct[row / 3][row % 3];
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry += weight * q[i][column / 3] * moved[column % 3];
            }
        }
    }
}

/// Orthonormal axes, of which the first are given; a law of one direction does not see spins about it.
fn completed(directions: &[[f64; 3]]) -> Option<[[f64; 3]; 3]> {
    let first = directions.first()?;
    let unit = |v: [f64; 3]| v.map(|x| x / v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let least = (0..3).min_by(|&i, &j| first[i].abs().total_cmp(&first[j].abs()))?;
    let second = directions.get(1).copied().unwrap_or_else(|| {
        unit(cross(first, &std::array::from_fn(|i| f64::from(u8::from(i == least)))))
    });
    Some([*first, second, cross(first, &second)])
}
