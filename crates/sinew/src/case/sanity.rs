//! Probable mistakes in a case that can be solved: sizes, stiffnesses and supports outside those of soft tissue.

use super::Case;
use super::units::length_within;
use sinew_energy::{Body, Mat3};

/// Smallest and largest size of a body [mm]: a millimetre of tissue and a metre, the length of a leg.
const SIZES: [f64; 2] = [1.0, 1e3];

/// Smallest and largest shear modulus [kPa]: an embryo's tissue has 0.1, a tendon 1e5 at most.
const STIFFNESSES: [f64; 2] = [0.01, 1e5];

/// Largest displacement \[relative to the size of the body\] below which the body counts as at rest.
const LEAST_MOTION: f64 = 1e-6;

impl Case {
    /// Warnings about units and supports.
    pub(super) fn doubts(&self, body: &Body) -> Vec<String> {
        let size = size(body);
        let key = |keys: &[&str], reason: String| self.source.error(keys, reason).to_string();
        let mut warnings = Vec::new();
        if !(SIZES[0]..=SIZES[1]).contains(&size) {
            let reason = format!(
                "the body is {} mm in size, and tissue is between {} and {} mm; {}",
                rounded(size),
                SIZES[0],
                SIZES[1],
                self.fitting_unit(size)
            );
            warnings.push(key(&["mesh"], reason));
        }
        if let Some(stiffness) = unlikely_stiffness(body) {
            let reason = format!(
                "the shear modulus at rest is {} kPa within the ranges, and tissue is between {} and {} kPa; if they are in \
                 another unit, say so: {{ range = […], unit = \"Pa\" }}",
                rounded(stiffness),
                STIFFNESSES[0],
                STIFFNESSES[1]
            );
            warnings.push(key(&["parameters"], reason));
        }
        if body.free_nodes().is_empty() {
            let reason = "they hold every node in every direction, so that nothing can move; hold fewer nodes";
            warnings.push(key(&["supports"], reason.into()));
        }
        warnings
    }

    /// Advice about the unit of a mesh that makes a body of a size \[mm\] that no tissue has.
    fn fitting_unit(&self, size: f64) -> String {
        let bare = size / self.mesh.scale(&self.source).unwrap_or(1.0);
        let fits = (SIZES[0]..=SIZES[1]).contains(&bare);
        match (length_within(bare, SIZES), &self.mesh.unit) {
            (_, Some(unit)) if fits => {
                format!("if its lengths are in mm, leave out unit = \"{unit}\" under [mesh]")
            }
            (Some(unit), _) => format!(
                "if its lengths are in another unit, say so: unit = \"{unit}\" under [mesh]"
            ),
            (None, _) => {
                "no unit of length makes it one, so look at the numbers of the mesh".into()
            }
        }
    }
}

/// Warning about a displacement that is almost zero; `None` where everything is held.
pub fn negligible_displacement(body: &Body, displacement: &[f64]) -> Option<String> {
    let largest = displacement.iter().fold(0.0f64, |largest, u| largest.max(u.abs()));
    let size = size(body);
    let hardly = largest < LEAST_MOTION * size && !body.free_nodes().is_empty();
    let unit = &body.units.length;
    hardly.then(|| {
        format!(
            "the largest displacement is {largest:.1e} {unit}, less than a millionth of the body's size of {} {unit}; look at \
             the loads and at their units: kPa, and kPa/mm for forces per volume",
            rounded(size)
        )
    })
}

/// Longest edge of the box around a body \[length\].
fn size(body: &Body) -> f64 {
    sinew_mesh::extents(&body.positions).into_iter().fold(0.0, f64::max)
}

/// The shear modulus at the lower or upper ends of all ranges, where no tissue has it.
fn unlikely_stiffness(body: &Body) -> Option<f64> {
    let modulus = |end: usize| {
        let theta: Vec<f64> = body.parameters.iter().map(|p| p.range[end]).collect();
        let response = body.material.response(0, body.law_parameters(&theta), &Mat3::ZERO);
        // Mean of ∂P_ij/∂H_ij over i ≠ j.
        let shear = (0..9).filter(|row| row % 4 != 0).map(|row| response.tangent[row][row]);
        shear.sum::<f64>() / 6.0
    };
    let [low, high] = [modulus(0), modulus(1)];
    let unlikely = |value: &f64| value.is_finite() && *value > 0.0;
    [(low < STIFFNESSES[0]).then_some(low), (high > STIFFNESSES[1]).then_some(high)]
        .into_iter()
        .flatten()
        .find(unlikely)
}

fn rounded(value: f64) -> String {
    sinew_report::format::trimmed(value, 3)
}
