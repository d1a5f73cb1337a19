//! State at which a potential is evaluated.

use sinew_energy::Body;

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
    pub(crate) fn energy(&self, potential: &Body) -> f64 {
        self.load_factor * potential.load_value(self.displacement, self.theta)
            + potential.inner_value(self.displacement, self.theta)
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
