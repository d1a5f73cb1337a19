//! Ratio of bulk and shear modulus.

use sinew_energy::Body;
use sinew_num::Mat3;

/// Points of a body at which K/μ is evaluated: one cell may be a scar.
const POINTS: usize = 9;

/// Median of K/μ of the material at rest over points spread over the body; `None` without resistance to changes of volume.
pub(crate) fn bulk_to_shear(potential: &Body, theta: &[f64]) -> Option<f64> {
    let count = potential.volumes.len();
    let points = (0..count).step_by(count.div_ceil(POINTS).max(1));
    let ratios: Option<Vec<f64>> =
        points.map(|point| bulk_to_shear_at(potential, theta, point)).collect();
    let mut ratios = ratios?;
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

fn bulk_to_shear_at(potential: &Body, theta: &[f64], point: usize) -> Option<f64> {
    // A rotation of the directions changes neither K nor the trace.
    let response = potential.material.response(point, potential.law_parameters(theta), &Mat3::ZERO);
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
