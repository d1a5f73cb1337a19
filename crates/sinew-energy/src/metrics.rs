//! Errors of an emulated displacement û against the true one u: thesis eqs. (3.22) and (3.24).
//!
//! Displacements are flat, `[u_x, u_y, u_z]` node by node. Relative errors are in percent; they are
//! +∞ or NaN where the true value is zero.

use crate::Body;
use sinew_num::{Mat3, norm, sub3};

/// `‖u − û‖₂` of each node \[length\].
pub fn displacement_error(truth: &[f64], estimate: &[f64]) -> Vec<f64> {
    let (truth, estimate) = (truth.as_chunks::<3>().0, estimate.as_chunks::<3>().0);
    truth.iter().zip(estimate).map(|(u, v)| norm(&sub3(u, v))).collect()
}

/// Mean and largest length of the nodal vectors of a displacement, or of a difference of two \[length\]; zeros without nodes.
pub fn mean_and_largest(displacement: &[f64]) -> [f64; 2] {
    let nodes = displacement.as_chunks::<3>().0;
    let lengths: Vec<_> = nodes.iter().map(|u| norm(u)).collect();
    let largest = lengths.iter().copied().fold(0.0, f64::max);
    let sum = lengths.iter().fold(0.0, |sum, length| sum + length);
    [sum / nodes.len().max(1) as f64, largest]
}

/// Volume ratio J at each quadrature point.
pub fn volume_ratios(body: &Body, displacement: &[f64]) -> Vec<f64> {
    let ratio = |point| 1.0 + body.displacement_gradient(point, displacement).volume_change();
    (0..body.volumes.len()).map(ratio).collect()
}

/// `‖F − F̂‖_F / ‖F‖_F` at each quadrature point; for linear tetrahedra, of each cell [%].
pub fn deformation_gradient_error(body: &Body, truth: &[f64], estimate: &[f64]) -> Vec<f64> {
    per_point(body, truth, estimate, |h, other| {
        let difference = Mat3::from_fn(|i, j| h[i][j] - other[i][j]);
        let size = h.first_invariant_minus_three() + 3.0;
        100.0 * (difference.squared_norm() / size).sqrt()
    })
}

/// `|I₁ − Î₁| / I₁` at each quadrature point; for linear tetrahedra, of each cell [%].
pub fn first_invariant_error(body: &Body, truth: &[f64], estimate: &[f64]) -> Vec<f64> {
    let invariant = |h: &Mat3<f64>| h.first_invariant_minus_three() + 3.0;
    let relative = |truth: f64, estimate: f64| 100.0 * ((truth - estimate) / truth).abs();
    per_point(body, truth, estimate, |h, other| relative(invariant(h), invariant(other)))
}

fn per_point(
    body: &Body,
    truth: &[f64],
    estimate: &[f64],
    error: impl Fn(&Mat3<f64>, &Mat3<f64>) -> f64,
) -> Vec<f64> {
    let gradient = |point, u| body.displacement_gradient(point, u);
    (0..body.volumes.len())
        .map(|point| error(&gradient(point, truth), &gradient(point, estimate)))
        .collect()
}
