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
pub(crate) const MOST_WORST: usize = 5;

/// The cells of least value, at most `count`, worst first.
pub(crate) fn least(values: &[f64], count: usize) -> Vec<CellValue> {
    // A J that overflows is no number.
    let mut order: Vec<_> = (0..values.len()).filter(|&cell| !values[cell].is_nan()).collect();
    let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]).then(a.cmp(b));
    if count < order.len() {
        order.select_nth_unstable_by(count, by_value);
        order.truncate(count);
    }
    order.sort_unstable_by(by_value);
    order.into_iter().map(|cell| CellValue { cell, value: values[cell] }).collect()
}

/// The cell of largest value.
pub(crate) fn largest(values: &[f64]) -> CellValue {
    let best = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    CellValue { cell: best, value: values.get(best).copied().unwrap_or(f64::NAN) }
}

/// The least (largest) of the values at the quadrature points of each cell, which are `count` of them.
pub(crate) fn per_cell(points: &[f64], count: usize, pick: fn(f64, f64) -> f64) -> Vec<f64> {
    let of_cell = |values: &[f64]| values.iter().copied().reduce(pick).unwrap_or(f64::NAN);
    points.chunks(count).map(of_cell).collect()
}

/// Error of a displacement whose energy is not finite, with the cell of least J.
pub(crate) fn inadmissible(body: &Body, displacement: &[f64]) -> SolveError {
    let ratios = per_cell(&volume_ratios(body, displacement), body.points_per_cell, f64::min);
    SolveError::Inadmissible { cell: least(&ratios, 1).first().map_or(0, |worst| worst.cell) }
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
