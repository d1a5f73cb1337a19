//! Pressures that follow surfaces with a loose rim: forces without a potential, whose derivative is not symmetric.

use crate::elements::{Assembly, State, add_product};
use crate::linear::{Norm, Sparsity};
use sinew_energy::{PressureSurface, SurfaceResponse};

/// The loose followers of a body.
pub(crate) struct Followers<'p> {
    pub surfaces: &'p [PressureSurface],
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
        if self.surfaces.is_empty() {
            return;
        }
        self.responses.clear();
        let mut place = first;
        let mut loads = Norm::default();
        for surface in self.surfaces {
            let magnitude = state.load_factor * surface.magnitude.value(state.theta);
            for facet in 0..surface.facets() {
                let mut response = SurfaceResponse::default();
                surface.facet_force(facet, state.displacement, &mut response);
                let size = response.gradient.len();
                let mut symmetric = response.clone();
                for row in 0..size {
                    for column in 0..size {
                        let [entry, mirrored] =
                            [row * size + column, column * size + row].map(|i| response.hessian[i]);
                        symmetric.hessian[row * size + column] = 0.5 * (entry + mirrored);
                    }
                }
                let nodes = surface.facet_nodes(facet);
                let derivatives = (&symmetric.gradient[..], &symmetric.hessian[..]);
                loads.add(assembly.add_facet(nodes, sparsity, place, magnitude, derivatives));
                for (entry, symmetric) in response.hessian.iter_mut().zip(&symmetric.hessian) {
                    *entry = magnitude * (*entry - symmetric);
                }
                self.responses.push(response);
                place += 1;
            }
        }
        assembly.force_scale = assembly.force_scale.hypot(loads.value());
    }

    /// Adds the skew part of the derivative times `direction` to `forces`.
    pub(crate) fn add_skew(&self, direction: &[f64], forces: &mut [f64]) {
        let mut responses = self.responses.iter();
        for surface in self.surfaces {
            for (facet, response) in (0..surface.facets()).zip(&mut responses) {
                add_product(surface.facet_nodes(facet), 1.0, &response.hessian, direction, forces);
            }
        }
    }

    /// Adds the forces under the whole load to `forces`.
    pub(crate) fn add_forces(&self, displacement: &[f64], theta: &[f64], forces: &mut [f64]) {
        let mut response = SurfaceResponse::default();
        for surface in self.surfaces {
            let magnitude = surface.magnitude.value(theta);
            for facet in 0..surface.facets() {
                surface.facet_force(facet, displacement, &mut response);
                for (slot, force) in response.gradient.iter().enumerate() {
                    forces[3 * surface.facet_nodes(facet)[slot / 3] + slot % 3] +=
                        magnitude * force;
                }
            }
        }
    }
}
