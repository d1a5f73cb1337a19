//! Nodal forces and energies of a solution.

use crate::SolveError;
use crate::elements::check::{check_displacement, check_pressure};
use crate::elements::followers::Followers;
use crate::elements::state::{State, load_gradient};
use sinew_energy::Body;
use sinew_num::Mat3;

/// Requires arrays of the lengths of a body's.
pub(super) fn check(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<(), SolveError> {
    body.check_theta(theta)?;
    check_displacement(body, displacement)?;
    check_pressure(body, pressure)
}

/// Forces on a body.
pub(super) struct Forces {
    /// Derivative of the energy in every degree of freedom; at prescribed ones it is the reaction.
    pub total: Vec<f64>,
    /// Π.
    pub energy: f64,
    /// Minus the potential of the loads.
    pub external_work: f64,
    /// Resultant of the loads on the body.
    pub loads: [f64; 3],
    /// Resultant of the elastic supports on the body.
    pub elastic_supports: [f64; 3],
}

impl Forces {
    /// Forces with a potential, at a fraction of the loads.
    fn of_potential(
        potential: &Body,
        displacement: &[f64],
        theta: &[f64],
        load_factor: f64,
    ) -> Self {
        let mut total = vec![0.0; displacement.len()];
        let whole = potential.value_and_gradient(displacement, theta, &mut total);
        let loads = load_gradient(potential, displacement, theta);
        total.iter_mut().zip(&loads).for_each(|(t, l)| *t += (load_factor - 1.0) * l);
        let mut springs = vec![0.0; displacement.len()];
        for spring in &potential.springs {
            spring.value_and_add_gradient(displacement, &mut springs);
        }
        let load_value = potential.load_value(displacement, theta);
        Self {
            total,
            energy: whole + (load_factor - 1.0) * load_value,
            external_work: -load_factor * load_value,
            loads: resultant(&loads).map(|f| -load_factor * f),
            elastic_supports: resultant(&springs).map(|f| -f),
        }
    }

    /// Forces at a state, with loose followers and the field of pressure, which is given at its nodes.
    pub(super) fn of(body: &Body, state: State<'_>) -> Self {
        let State { displacement, theta, load_factor, .. } = state;
        let mut forces = Self::of_potential(body, displacement, theta, load_factor);
        let mut followers = vec![0.0; displacement.len()];
        Followers::new(&body.followers).add_forces(displacement, theta, &mut followers);
        followers.iter_mut().for_each(|force| *force *= load_factor);
        let on_body = resultant(&followers);
        (0..3).for_each(|i| forces.loads[i] -= on_body[i]);
        forces.total.iter_mut().zip(&followers).for_each(|(t, f)| *t += f);
        add_pressure_field(body, state, &mut forces.total);
        forces
    }
}

/// Adds the nodal forces `∫ p cof F ∇N dV` of the field of pressure.
fn add_pressure_field(body: &Body, state: State<'_>, forces: &mut [f64]) {
    let Some(field) = &body.pressure_field else { return };
    let law = |point: usize, h: &Mat3<f64>| {
        let (_, corners, shape) = field.of_point(point);
        let terms = shape.iter().zip(corners).map(|(n, &c)| n * state.pressure[c]);
        let (pressure, cofactor): (f64, _) = (terms.sum(), h.plus_identity().cofactors());
        Some((0.0, Mat3::from_fn(|i, j| pressure * cofactor[i][j])))
    };
    body.add_stress_forces(state.displacement, law, forces);
}

fn resultant(forces: &[f64]) -> [f64; 3] {
    let (rows, _) = forces.as_chunks::<3>();
    rows.iter().fold([0.0; 3], |sum, row| std::array::from_fn(|i| sum[i] + row[i]))
}
