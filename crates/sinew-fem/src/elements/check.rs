//! Checks of arguments.

use crate::SolveError;
use sinew_energy::Body;

/// Checks that a displacement has one finite entry per degree of freedom.
pub(crate) fn check_displacement(body: &Body, displacement: &[f64]) -> Result<(), SolveError> {
    check_length(body.prescribed.len(), displacement)
}

/// Checks the lengths of a displacement and θ, in this order; swapped arguments have an error of their own.
pub(crate) fn check_state(
    body: &Body,
    displacement: &[f64],
    theta: &[f64],
) -> Result<(), SolveError> {
    let (entries, parameters) = (body.prescribed.len(), body.theta_len());
    if entries != parameters && displacement.len() == parameters && theta.len() == entries {
        return Err(SolveError::Swapped { entries, parameters });
    }
    body.check_theta(theta)?;
    check_displacement(body, displacement)
}

/// Checks that there is one finite pressure per unknown of the field, none without one.
pub(crate) fn check_pressure(body: &Body, pressure: &[f64]) -> Result<(), SolveError> {
    check_length(body.pressure_field.as_ref().map_or(0, |field| field.unknowns), pressure)
}

/// Checks a displacement, the pressures of the field and θ.
pub(crate) fn check_fields(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<(), SolveError> {
    check_state(body, displacement, theta)?;
    check_pressure(body, pressure)
}

/// Checks that there are as many entries as needed, all finite.
pub(crate) fn check_length(needed: usize, values: &[f64]) -> Result<(), SolveError> {
    let (given, finite) = (values.len(), values.iter().filter(|u| u.is_finite()).count());
    if given == needed && finite == needed {
        return Ok(());
    }
    Err(SolveError::Initial { given, finite, needed })
}

/// Checks that a body has a potential, and that a displacement and θ are of it.
pub(crate) fn check_potential(
    body: &Body,
    displacement: &[f64],
    theta: &[f64],
) -> Result<(), SolveError> {
    if !body.has_potential() {
        return Err(SolveError::NoPotential);
    }
    check_state(body, displacement, theta)
}
