//! Data of a patient file as a model.

use super::{Response, product, refuse};
use crate::patient::Prepared;
use sinew_calibrate::{Forward, Patient, Problem};
use std::ops::RangeInclusive;

/// Values whose squares neither vanish nor overflow.
const MEANT: RangeInclusive<f64> = 1e-100..=1e100;

/// Data as functions of the unknown parameters, evaluated as a calibration does.
pub(super) struct Measured<'b> {
    problem: &'b Problem,
    patient: Patient<'b>,
}

impl<'b> Measured<'b> {
    pub(super) fn of(prepared: &'b Prepared) -> Result<Self, String> {
        Ok(Self { problem: &prepared.problem, patient: prepared.patient()? })
    }

    /// Names of unknown parameters, and of data, with their units.
    pub(super) fn heads(&self) -> [Vec<String>; 2] {
        let head = |name: &str, unit: &str| match unit {
            "" => name.to_string(),
            unit => format!("{name} [{unit}]"),
        };
        let Problem { unknowns, data, .. } = self.problem;
        [
            unknowns.iter().map(|unknown| head(&unknown.name, &unknown.unit)).collect(),
            data.iter().map(|datum| head(&datum.name, &datum.unit)).collect(),
        ]
    }

    /// Data, or products of their derivatives with `by`, in the units of the file.
    pub(super) fn answer(
        &self,
        path: &str,
        values: &[f64],
        by: &[f64],
    ) -> Result<Vec<f64>, Response> {
        let Problem { unknowns, data, .. } = self.problem;
        let wrong = unknowns.iter().zip(values).find(|(_, value)| !MEANT.contains(*value));
        if let Some((unknown, value)) = wrong {
            let name = &unknown.name;
            return refuse(format!(
                "{name} = {value:e}: give a positive value, within 1e-100 to 1e100"
            ));
        }
        let theta: Vec<f64> =
            unknowns.iter().zip(values).map(|(u, value)| u.size * value).collect();
        let seen = self.patient.observe(&theta, matches!(path, "/Gradient" | "/ApplyJacobian"));
        let seen = seen.map_err(|error| Response::failed(500, "InvalidOutput", &error.reason))?;
        let slope = |datum: usize, unknown: usize| {
            let sizes = unknowns[unknown].size / data[datum].size;
            seen.jacobian[data[datum].observable][unknown] * sizes
        };
        let values = data.iter().map(|d| seen.values[d.observable] / d.size).collect();
        Ok(product(path, by, values, unknowns.len(), slope))
    }
}
