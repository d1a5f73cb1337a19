//! Tangents with a predicted in place of the present stress.

use crate::elements::{inverse, product};
use sinew_num::Mat3;

/// Second Piola–Kirchhoff stress at each quadrature point as Newton's linear model foresees it.
pub(crate) type PredictedStress = Vec<Mat3<f64>>;

/// `S : C / 3`: pJ for the stress `p J C⁻¹` of a pressure p.
pub(crate) fn third(f: &Mat3<f64>, stress: impl Fn(usize, usize) -> f64) -> f64 {
    let strain = |j: usize, l: usize| (0..3).map(|k| f[k][j] * f[k][l]).sum::<f64>();
    (0..9).map(|at| stress(at / 3, at % 3) * strain(at / 3, at % 3)).sum::<f64>() / 3.0
}

/// Puts the predicted stress into the geometric part `δ_ik S_jl` of a tangent. In a nearly incompressible body its pressure enters as `p ∂²J/∂F²`,
/// because the actual pressure contains the error in J times the bulk modulus.
pub(crate) fn replace_stress(
    tangent: &mut [[f64; 9]; 9],
    h: &Mat3<f64>,
    stress: &Mat3<f64>,
    with: &Mat3<f64>,
    nearly_incompressible: bool,
) {
    let (f, inverse) = (h.plus_identity(), inverse(h));
    let present = product(&inverse, stress);
    let change = Mat3::from_fn(|j, l| {
        0.5 * (with[j][l] + with[l][j]) - 0.5 * (present[j][l] + present[l][j])
    });
    let mut pressure = 0.0;
    if nearly_incompressible {
        pressure = third(&f, |j, l| change[j][l]);
        f.add_second_of_determinant(pressure / (1.0 + h.volume_change()), tangent);
    }
    for j in 0..3 {
        for l in 0..3 {
            let of_pressure = (0..3).map(|k| inverse[j][k] * inverse[l][k]).sum::<f64>();
            for i in 0..3 {
                tangent[3 * i + j][3 * i + l] += change[j][l] - pressure * of_pressure;
            }
        }
    }
}
