//! Other loaded states of a body at rest, and how their places move with θ and with the body at rest.

use super::state::{Level, Trial};
use crate::elements::{State, Unknowns, check_length, check_state};
use crate::unload::{Image, Result, Unload, UnloadError, check_directions};
use crate::{Options, Solution, SolveError, Solver};
use sinew_energy::Body;

impl Unload<'_> {
    /// Another loaded state of a body at rest: the equilibrium for other loads and tensions in θ, from a displacement near it \[length\],
    /// counted from rest.
    ///
    /// # Errors
    /// As for [`crate::Solver::solve_from`].
    pub fn loaded(
        &self,
        rest: &Body,
        near: &[f64],
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution, SolveError> {
        Solver::of(self.image.system.like(rest)?).solve_from(near, theta, options)
    }

    /// Directional derivatives δx of a loaded state's positions in θ \[length\], `3 × nodes` for each direction. The body at rest changes along
    /// `rest_directions`, one for each direction in θ, or is held where there are none:
    /// `K δx = −(∂r/∂θ δθ + ∂r/∂X δX + ∂r/∂d ∂d/∂X δX)`, with exact derivatives throughout and one factorisation.
    ///
    /// # Errors
    /// A state or directions that do not fit the body, a stiffness that is singular, and derivatives that overflow.
    pub fn loaded_slopes(
        &self,
        rest: &Body,
        state: &Solution,
        theta_directions: &[Vec<f64>],
        rest_directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        let Solution { displacement, theta, .. } = state;
        check_directions(theta, theta_directions)?;
        let mut system = self.image.system.like(rest)?;
        check_state(system.body, displacement, theta)?;
        let moved = self.image.forces_by_rest(rest, state, rest_directions)?;
        let shift = system.factorise_at(&Unknowns::of(displacement), theta, 1.0)?;
        let slope = |(index, direction): (usize, &Vec<f64>)| {
            let mut right = system.rate_by_theta(State::whole(displacement, theta), direction);
            if let Some(moved) = moved.get(index) {
                right.iter_mut().zip(moved).for_each(|(r, m)| *r += m);
            }
            Ok(system.slope(right, shift)?)
        };
        theta_directions.iter().enumerate().map(slope).collect()
    }
}

impl Image<'_> {
    /// Changes of the unbalanced forces of a state, whose places are held, along directions of the positions at rest: the state is
    /// an image of its own.
    fn forces_by_rest(
        &self,
        rest: &Body,
        state: &Solution,
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        if directions.is_empty() {
            return Ok(Vec::new());
        }
        directions.iter().try_for_each(|along| check_length(rest.prescribed.len(), along))?;
        let singular = || UnloadError::from(SolveError::Singular);
        let displacement = state.displacement.clone();
        let seen = rest.moved(&displacement, self.fibres).ok_or_else(singular)?;
        let seen = Image { system: self.system.like(&seen)?, fibres: self.fibres };
        let motion = displacement.iter().map(|u| -u).collect();
        let trial = Trial { motion, displacement, ..Trial::balanced(rest.clone()) };
        let tangent =
            seen.tangent(&trial, &Level::whole(&state.theta), None).ok_or_else(singular)?;
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
