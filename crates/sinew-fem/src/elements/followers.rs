//! Pressures that follow surfaces with a loose rim: forces without a potential, whose derivative is not symmetric.

use crate::elements::{Assembly, State, add_product};
use crate::linear::{Sparsity, facets_of};
use sinew_energy::{PressureSurface, SurfaceResponse};

/// The loose followers of a body.
pub(crate) struct Followers<'p> {
    surfaces: &'p [PressureSurface],
    /// Forces of each facet, and the skew part of their derivative, where assembled last.
    responses: Vec<SurfaceResponse>,
}

impl<'p> Followers<'p> {
    pub(crate) fn new(surfaces: &'p [PressureSurface]) -> Self {
        Self { surfaces, responses: Vec::new() }
    }

    /// Adds the forces to the gradient, and the symmetric part of their derivative to the matrix; facets are counted from
    /// `first` on.
    pub(crate) fn assemble(
        &mut self,
        assembly: &mut Assembly,
        sparsity: &Sparsity,
        first: usize,
        state: State<'_>,
    ) {
        self.responses.clear();
        for (place, (surface, facet, nodes)) in (first..).zip(facets_of(self.surfaces)) {
            let magnitude = state.load_factor * surface.magnitude.value(state.theta);
            let mut response = SurfaceResponse::default();
            surface.facet_force(facet, state.displacement, &mut response);
            let (size, mut symmetric) = (response.gradient.len(), response.clone());
            for (at, entry) in symmetric.hessian.iter_mut().enumerate() {
                *entry = 0.5 * (*entry + response.hessian[at % size * size + at / size]);
            }
            let force = assembly.add_facet(nodes, sparsity, place, magnitude, &symmetric);
            assembly.force_scale = assembly.force_scale.hypot(force);
            for (entry, symmetric) in response.hessian.iter_mut().zip(&symmetric.hessian) {
                *entry = magnitude * (*entry - symmetric);
            }
            self.responses.push(response);
        }
    }

    /// Adds the skew part of the derivative times `direction` to `forces`.
    pub(crate) fn add_skew(&self, direction: &[f64], forces: &mut [f64]) {
        for ((_, _, nodes), response) in facets_of(self.surfaces).zip(&self.responses) {
            add_product(nodes, 1.0, &response.hessian, direction, forces);
        }
    }

    /// Adds the forces under the whole load to `forces`.
    pub(crate) fn add_forces(&self, displacement: &[f64], theta: &[f64], forces: &mut [f64]) {
        let mut response = SurfaceResponse::default();
        for (surface, facet, nodes) in facets_of(self.surfaces) {
            let magnitude = surface.magnitude.value(theta);
            surface.facet_force(facet, displacement, &mut response);
            for (slot, force) in response.gradient.iter().enumerate() {
                forces[3 * nodes[slot / 3] + slot % 3] += magnitude * force;
            }
        }
    }
}
