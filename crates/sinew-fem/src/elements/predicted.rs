//! Predicted stress: second Piola–Kirchhoff stress after a step by the linear model.
//!
//! The stress at the end of a step contains errors of second order in the step: stretching by a linear rotation, and a change of volume. The
//! stiffness is therefore built from the predicted stress (the mixed-integration-point method of D. Magisano, L. Leonetti, G. Garcea, Int. J.
//! Numer. Meth. Engng 109, 2017). Both agree at the solution, so that convergence stays quadratic.
//!
//! Nearly incompressible bodies keep their pressure; the ratio of their moduli at rest tells them.

use crate::elements::{Assembly, at_points, inverse, product, tangent_times};
use sinew_energy::Body;
use sinew_num::Mat3;

/// Second Piola–Kirchhoff stress at each quadrature point as Newton's linear model foresees it.
pub(crate) type PredictedStress = Vec<Mat3<f64>>;

impl Assembly {
    /// The second Piola–Kirchhoff stress at each point.
    pub(crate) fn stress(&self) -> PredictedStress {
        self.points.iter().map(|point| product(&inverse(&point.h), &point.stress)).collect()
    }

    /// The stress at each point after a step along `direction` by the linear model of the stress,
    /// `S + C : sym(Fᵀ ∇direction)`.
    pub(crate) fn predict_stress(&self, body: &Body, direction: &[f64]) -> PredictedStress {
        let averaged = if self.patches.is_empty() { 0 } else { body.volumes.len() };
        let mut common = vec![Mat3::ZERO; averaged];
        for (points, patch) in body.patches.iter().zip(&self.patches) {
            let at_points = points.iter().zip(patch.common_stress(direction));
            at_points.for_each(|(&point, stress)| common[point] = stress);
        }
        let predict = |point: usize| {
            let at_point = &self.points[point];
            let dh = body.displacement_gradient(point, direction);
            let inverse = inverse(&at_point.h);
            let stress = product(&inverse, &at_point.stress);
            let linear = tangent_times(&at_point.tangent(), &dh);
            let change = Mat3::from_fn(|i, j| {
                at_point.stress[i][j]
                    + linear[i][j]
                    + common.get(point).map_or(0.0, |stress| stress[i][j])
                    - (0..3).map(|k| dh[i][k] * stress[k][j]).sum::<f64>()
            });
            product(&inverse, &change)
        };
        at_points(body.volumes.len(), predict)
    }

    /// Nodal forces of the difference between actual and predicted pressure, in the assembled configuration.
    pub(crate) fn pressure_defect(
        &self,
        body: &Body,
        (displacement, theta): (&[f64], &[f64]),
        predicted: &PredictedStress,
    ) -> Option<Vec<f64>> {
        let reached = stress_at(body, displacement, theta)?;
        let mut forces = vec![0.0; displacement.len()];
        for (point, h) in self.displacement_gradients().enumerate() {
            let f = h.plus_identity();
            let third = third(&f, |j, l| reached[point][j][l] - predicted[point][j][l]);
            let inverse = inverse(h);
            let stress = Mat3::from_fn(|i, j| third * inverse[j][i]);
            body.add_forces(point, &stress, &mut forces);
        }
        Some(forces)
    }
}

/// The stress at each point at a displacement; `None` where a cell is inverted or an energy overflows.
fn stress_at(body: &Body, displacement: &[f64], theta: &[f64]) -> Option<PredictedStress> {
    let parameters = body.law_parameters(theta);
    let law = |point: usize, h: &Mat3<f64>| {
        let found = body.material.stress(point, parameters, h, None);
        found.0.is_finite().then_some(found)
    };
    let (mut first, (_, stresses)) =
        (vec![Mat3::ZERO; body.volumes.len()], body.stresses(displacement, law)?);
    stresses.for_each(|(point, stress)| first[point] = stress);
    let second = |point: usize| {
        product(&inverse(&body.displacement_gradient(point, displacement)), &first[point])
    };
    Some(at_points(first.len(), second))
}

/// Points of a body at which K/μ is evaluated: one cell may be a scar.
const POINTS: usize = 9;

/// Median of K/μ of the material at rest over points spread over the body; `None` without resistance to changes of volume.
pub(crate) fn bulk_to_shear(body: &Body, theta: &[f64]) -> Option<f64> {
    let count = body.volumes.len();
    let points = (0..count).step_by(count.div_ceil(POINTS).max(1));
    let ratios = points.map(|point| bulk_to_shear_at(body, theta, point));
    let mut ratios: Vec<f64> = ratios.collect::<Option<_>>()?;
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

fn bulk_to_shear_at(body: &Body, theta: &[f64], point: usize) -> Option<f64> {
    // A rotation of the directions changes neither K nor the trace.
    let response = body.material.response(point, body.law_parameters(theta), &Mat3::ZERO);
    let (tangent, prestress) = (&response.tangent, response.stress.trace());
    let bulk = [0, 4, 8].map(|i| tangent[i][0] + tangent[i][4] + tangent[i][8]);
    // Active stress S adds δ_ik S_jl to the tangent, which is no stiffness of the material.
    let bulk = (bulk.iter().sum::<f64>() - prestress) / 9.0;
    let trace = (0..9).map(|i| tangent[i][i]).sum::<f64>() - 3.0 * prestress;
    let shear = (trace - 3.0 * bulk) / 10.0;
    // Below rounding there is no shear modulus: an ideal fluid.
    let fluid = shear <= f64::EPSILON * bulk;
    (bulk > 0.0 && trace.is_finite()).then_some(if fluid { f64::INFINITY } else { bulk / shear })
}

/// Least K/μ at rest of a nearly incompressible body. Measured from rest: bodies above 90 take 0.1 to 0.9 of the iterations, those below 40 up to
/// a third more.
const NEARLY_INCOMPRESSIBLE: f64 = 60.0;

/// Whether K/μ at rest is so large that the bulk modulus acts as a constraint on J.
pub(crate) fn is_nearly_incompressible(body: &Body, theta: &[f64]) -> bool {
    bulk_to_shear(body, theta).is_some_and(|ratio| ratio > NEARLY_INCOMPRESSIBLE)
}

/// `S : C / 3`: pJ for the stress `p J C⁻¹` of a pressure p.
fn third(f: &Mat3<f64>, stress: impl Fn(usize, usize) -> f64) -> f64 {
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
