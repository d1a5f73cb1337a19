//! States, checks of arguments, and the cells that explain a refusal.

use crate::{CellValue, Result, SolveError};
use sinew_energy::Body;
use sinew_energy::metrics::volume_ratios;

/// Checks the lengths of a displacement and θ, in this order; swapped arguments have an error of their own.
pub(crate) fn check_state(body: &Body, displacement: &[f64], theta: &[f64]) -> Result<()> {
    let (entries, parameters) = (body.prescribed.len(), body.theta_len());
    if entries != parameters && displacement.len() == parameters && theta.len() == entries {
        return Err(SolveError::Swapped { entries, parameters });
    }
    body.check_theta(theta)?;
    check_length(body.prescribed.len(), displacement)
}

/// Checks that there is one finite pressure per unknown of the field, none without one.
pub(crate) fn check_pressure(body: &Body, pressure: &[f64]) -> Result<()> {
    check_length(body.pressure_field.as_ref().map_or(0, |field| field.unknowns), pressure)
}

/// Checks a displacement, the pressures of the field and θ.
pub(crate) fn check_fields(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<()> {
    check_state(body, displacement, theta)?;
    check_pressure(body, pressure)
}

/// Checks that there are as many entries as needed, all finite.
pub(crate) fn check_length(needed: usize, values: &[f64]) -> Result<()> {
    let (given, finite) = (values.len(), values.iter().filter(|u| u.is_finite()).count());
    if given == needed && finite == needed {
        return Ok(());
    }
    Err(SolveError::Initial { given, finite, needed })
}

/// Checks that a body has a potential, and that a displacement and θ are of it.
pub(crate) fn check_potential(body: &Body, displacement: &[f64], theta: &[f64]) -> Result<()> {
    if !body.has_potential() {
        return Err(SolveError::NoPotential);
    }
    check_state(body, displacement, theta)
}

/// Number of the worst cells that are named.
const MOST_WORST: usize = 5;

/// The cells whose quadrature points, `count` in each, have the least values: worst first.
pub(crate) fn worst_cells(points: &[f64], count: usize) -> Vec<CellValue> {
    let least = |of_cell: &[f64]| of_cell.iter().copied().fold(f64::NAN, f64::min);
    let cells = points.chunks(count).map(least).enumerate();
    // A J that overflows is no number.
    let cells = cells.filter(|(_, value)| !value.is_nan());
    let mut cells: Vec<_> = cells.map(|(cell, value)| CellValue { cell, value }).collect();
    cells.sort_by(|a, b| a.value.total_cmp(&b.value));
    cells.truncate(MOST_WORST);
    cells
}

/// Error of a displacement whose energy is not finite, with the cell of least J.
pub(crate) fn inadmissible(body: &Body, displacement: &[f64]) -> SolveError {
    let worst = worst_cells(&volume_ratios(body, displacement), body.points_per_cell);
    SolveError::Inadmissible { cell: worst.first().map_or(0, |worst| worst.cell) }
}

/// State at which a potential is evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<'a> {
    /// Nodal displacements \[length\].
    pub displacement: &'a [f64],
    /// Parameters of law and loads.
    pub theta: &'a [f64],
    /// Fraction of all loads.
    pub load_factor: f64,
    /// Pressure at each quadrature point \[stress\], where it is an unknown; else empty.
    pub pressure: &'a [f64],
}

impl<'a> State<'a> {
    /// A state under the whole load, without a field of pressure.
    pub(crate) fn whole(displacement: &'a [f64], theta: &'a [f64]) -> Self {
        Self { displacement, theta, load_factor: 1.0, pressure: &[] }
    }

    /// Π \[stress·length³\]; +∞ as soon as a cell is inverted.
    pub(crate) fn energy(&self, body: &Body) -> f64 {
        self.load_factor * body.load_value(self.displacement, self.theta)
            + body.inner_value(self.displacement, self.theta)
    }
}

/// Derivative of the loads' potential under the whole load: minus the forces on the body.
pub(crate) fn load_gradient(body: &Body, displacement: &[f64], theta: &[f64]) -> Vec<f64> {
    let mut gradient: Vec<_> = body.nodal_force.iter().map(|f| -f).collect();
    for pressure in &body.pressures {
        pressure.value_and_add_gradient(displacement, theta, &mut gradient);
    }
    gradient
}
