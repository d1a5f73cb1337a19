//! Compressible neo-Hookean solid.

use crate::law::{named, stress_by_slopes};
use crate::{Guard, Law, Response};
use sinew_num::{Mat3, Scalar};

/// Compressible neo-Hookean solid, thesis eq. (3.1):
/// `Ψ = ½λ(ln J)² − μ ln J + ½μ(I₁ − 3)`.
///
/// First Piola–Kirchhoff stress `P = μF + (λ ln J − μ)F⁻ᵀ`, tangent
/// `∂P_ij/∂F_kl = μ δ_ik δ_jl + λ G_ij G_kl + (μ − λ ln J) G_il G_kj` with `G = F⁻ᵀ`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookean;

impl NeoHookean {
    /// Lamé parameters `[μ, λ]` from Young's modulus `E` and Poisson's ratio `ν`.
    pub fn from_young_poisson(young: f64, poisson: f64) -> [f64; 2] {
        let shear = young / (2.0 * (1.0 + poisson));
        [shear, young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))]
    }
}

impl Law<0> for NeoHookean {
    const NAME: &'static str = "neo-Hookean, thesis (3.1)";
    const PARAMETERS: &'static [&'static str] = &["mu", "lambda"];

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        displacement_gradient: &Mat3<S>,
        _directions: &[[S; 3]; 0],
        guard: &G,
    ) -> S {
        let [shear, lame] = named(parameters);
        let log_j = guard.volume_change(displacement_gradient.volume_change()).ln_1p();
        let stretch = guard.first_invariant(displacement_gradient.first_invariant_minus_three());
        lame.clone() * log_j.clone().squared() * 0.5 + shear.clone() * (stretch * 0.5 - log_j)
    }

    fn stress<G: Guard>(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &[[f64; 3]; 0],
        guard: &G,
    ) -> (f64, Mat3<f64>) {
        let [shear, lame] = *named(parameters);
        let h = displacement_gradient;
        let (volume_change, stretch) = (h.volume_change(), h.first_invariant_minus_three());
        // The closed form holds where the guard is the identity, which is nearly everywhere.
        let guarded = guard.volume_change(volume_change);
        if guarded <= -1.0 {
            return (f64::INFINITY, Mat3::ZERO);
        }
        if guarded != volume_change || guard.first_invariant(stretch) != stretch {
            return stress_by_slopes(self, parameters, h, directions, guard);
        }
        let log_j = volume_change.ln_1p();
        let energy = 0.5 * lame * log_j * log_j + shear * (0.5 * stretch - log_j);
        let inverse = inverse_transpose(h, volume_change);
        let factor = lame * log_j - shear;
        (energy, Mat3::from_fn(|i, j| shear * (h[i][j] + unit(i, j)) + factor * inverse[i][j]))
    }

    fn response(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &[[f64; 3]; 0],
    ) -> Response {
        let [shear, lame] = *named(parameters);
        let h = displacement_gradient;
        let volume_change = h.volume_change();
        let (energy, stress) = self.stress(parameters, h, directions, &crate::Exact);
        if energy == f64::INFINITY {
            return Response::INADMISSIBLE;
        }
        let g = inverse_transpose(h, volume_change);
        let factor = shear - lame * volume_change.ln_1p();
        let mut tangent = [[0.0; 9]; 9];
        for (row, entries) in tangent.iter_mut().enumerate() {
            let (i, j) = (row / 3, row % 3);
            for (column, entry) in entries.iter_mut().enumerate() {
                let (k, l) = (column / 3, column % 3);
                *entry = lame * g[i][j] * g[k][l] + factor * g[i][l] * g[k][j];
            }
            entries[row] += shear;
        }
        Response { energy, stress, tangent }
    }
}

fn unit(i: usize, j: usize) -> f64 {
    if i == j { 1.0 } else { 0.0 }
}

/// `F⁻ᵀ = cof(F)/J` with `F = I + H`.
fn inverse_transpose(h: &Mat3<f64>, volume_change: f64) -> Mat3<f64> {
    let f = Mat3::from_fn(|i, j| h[i][j] + unit(i, j));
    let scale = (1.0 + volume_change).recip();
    Mat3::from_fn(|i, j| f.cofactor(i, j) * scale)
}
