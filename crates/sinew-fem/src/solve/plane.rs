//! Constraint of equilibria whose place on a line in loads and parameters is unknown.

use crate::elements::system::System;
use crate::linear::vector::dot;

/// A plane across a curve of equilibria.
pub(crate) struct Plane {
    /// Derivatives of the distance along the curve in the free displacements [1/length] and in the place.
    pub normal: (Vec<f64>, f64),
    /// Distance of the plane along them.
    pub distance: f64,
}

impl Plane {
    /// Distance from a displacement and a place to the plane.
    pub(crate) fn gap(&self, system: &System<'_>, displacement: &[f64], place: f64) -> f64 {
        let (slope, by_place) = &self.normal;
        let free: Vec<f64> = system.sparsity.gather(displacement).collect();
        self.distance - dot(slope, &free) - by_place * place
    }
}
