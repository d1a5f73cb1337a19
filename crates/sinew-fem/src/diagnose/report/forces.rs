//! Nodal forces and energies of a solution.

use crate::elements::followers::Followers;
use crate::elements::state::{State, load_gradient};
use sinew_energy::Body;
use sinew_num::Mat3;

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
    /// Forces at a state, with loose followers and the field of pressure, which is given at its nodes.
    pub(super) fn of(body: &Body, state: State<'_>) -> Self {
        let State { displacement, theta, load_factor, .. } = state;
        let zeros = vec![0.0; displacement.len()];
        let (mut total, mut springs, mut followers) = (zeros.clone(), zeros.clone(), zeros);
        let whole = body.value_and_gradient(displacement, theta, &mut total);
        let loads = load_gradient(body, displacement, theta);
        for spring in &body.springs {
            spring.value_and_add_gradient(displacement, &mut springs);
        }
        Followers::new(&body.followers).add_forces(displacement, theta, &mut followers);
        for (total, (load, follower)) in total.iter_mut().zip(loads.iter().zip(&mut followers)) {
            *follower *= load_factor;
            *total += (load_factor - 1.0) * load;
            *total += *follower;
        }
        add_pressure_field(body, state, &mut total);
        let load_value = body.load_value(displacement, theta);
        let [with_potential, without] = [&loads, &followers].map(|forces| resultant(forces));
        Self {
            total,
            energy: whole + (load_factor - 1.0) * load_value,
            external_work: -load_factor * load_value,
            loads: [0, 1, 2].map(|i| -load_factor * with_potential[i] - without[i]),
            elastic_supports: resultant(&springs).map(|f| -f),
        }
    }
}

/// Adds the nodal forces `∫ p cof F ∇N dV` of the field of pressure.
fn add_pressure_field(body: &Body, state: State<'_>, forces: &mut [f64]) {
    let Some(field) = &body.pressure_field else { return };
    let law = |point: usize, h: &Mat3<f64>| {
        let (pressure, cofactor) = (field.at(point, state.pressure), h.plus_identity().cofactors());
        Some((0.0, Mat3::from_fn(|i, j| pressure * cofactor[i][j])))
    };
    body.add_stress_forces(state.displacement, law, forces);
}

fn resultant(forces: &[f64]) -> [f64; 3] {
    let (rows, _) = forces.as_chunks::<3>();
    rows.iter().fold([0.0; 3], |sum, row| std::array::from_fn(|i| sum[i] + row[i]))
}
