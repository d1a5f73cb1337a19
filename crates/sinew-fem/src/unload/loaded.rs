//! Other loaded states of a body at rest, and how their places move with θ and with the body at rest.

use super::error::UnloadError;
use super::image::Image;
use super::state::{Level, Trial};
use crate::elements::check::check_displacement;
use crate::elements::system::Unknowns;
use crate::solve::path::Path;
use crate::solve::watch::Log;
use crate::{Options, Solution, SolveError};
use sinew_energy::Body;
use std::time::Instant;

impl Image<'_> {
    /// The equilibrium of a body at rest for θ, from a displacement near it.
    pub(super) fn loaded(
        &self,
        rest: &Body,
        near: &[f64],
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution, SolveError> {
        let start = Instant::now();
        let mut system = self.system_of(rest)?;
        system.body.check_theta(theta)?;
        check_displacement(system.body, near)?;
        let mut history = Log::default();
        let path = Path::to_load(&mut system, theta, options);
        let found = path.run(Unknowns::of(near), &mut history)?;
        Ok(Solution::new(&system, found, theta, history.take(), start))
    }

    /// Changes of the places of a state along directions in θ and in the positions at rest; see [`super::Unload::loaded_slopes`].
    pub(super) fn loaded_slopes(
        &self,
        rest: &Body,
        state: &Solution,
        theta_directions: &[Vec<f64>],
        rest_directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, UnloadError> {
        let Solution { displacement, theta, .. } = state;
        let mut system = self.system_of(rest)?;
        system.body.check_theta(theta).map_err(SolveError::from)?;
        check_displacement(system.body, displacement)?;
        let moved = self.forces_by_rest(rest, state, rest_directions)?;
        let shift = system.factorise_at(&Unknowns::of(displacement), theta, 1.0)?;
        let slope = |(index, direction): (usize, &Vec<f64>)| {
            let mut right = system.rate_by_theta(displacement, theta, 1.0, direction);
            if let Some(moved) = moved.get(index) {
                right.iter_mut().zip(moved).for_each(|(r, m)| *r += m);
            }
            Ok(system.slope(right, shift)?)
        };
        theta_directions.iter().enumerate().map(slope).collect()
    }

    /// Changes of the unbalanced forces of a state, whose places are held, along directions of the positions at rest: the state is
    /// an image of its own.
    fn forces_by_rest(
        &self,
        rest: &Body,
        state: &Solution,
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, UnloadError> {
        if directions.is_empty() {
            return Ok(Vec::new());
        }
        directions.iter().try_for_each(|along| check_displacement(rest, along))?;
        let singular = || UnloadError::from(SolveError::Singular);
        let displacement = state.displacement.clone();
        let seen = rest.moved(&displacement, self.fibres).ok_or_else(singular)?;
        let seen = self.of_state(&seen)?;
        let motion = displacement.iter().map(|u| -u).collect();
        let trial = Trial { motion, displacement, ..Trial::balanced(rest.clone()) };
        let level = Level { factor: 1.0, theta: state.theta.clone() };
        let tangent = seen.tangent(&trial, &level, None).ok_or_else(singular)?;
        let sparsity = &seen.system.sparsity;
        let product = |along: &Vec<f64>| {
            let along: Vec<f64> = sparsity.gather(along).collect();
            let mut forces = vec![0.0; along.len()];
            tangent.entries.multiply(sparsity, &along, &mut forces);
            forces
        };
        Ok(directions.iter().map(product).collect())
    }
}
