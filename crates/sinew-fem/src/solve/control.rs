//! Constraints of equilibria whose place on a line in loads and parameters is unknown.

use crate::elements::system::System;
use crate::linear::vector::dot;
use sinew_energy::PressureSurface;

/// Constraint that closes the equations of a continuation.
pub(crate) enum Control {
    /// The surface of a unit pressure has swept a volume \[length³\].
    Volume(PressureSurface, f64),
    /// Displacement and place are on a plane.
    Plane(Plane),
}

/// A plane across a curve of equilibria.
pub(crate) struct Plane {
    /// Derivatives of the distance along the curve in the free displacements [1/length] and in the place.
    pub normal: (Vec<f64>, f64),
    /// Distance of the plane along them.
    pub distance: f64,
}

/// Residual of the constraint, and its derivatives.
pub(crate) struct Missing {
    pub gap: f64,
    /// Relative gap: a volume over that of the body, or the arc length itself.
    pub relative: f64,
    /// Derivatives of the controlled quantity in the free displacements and in the place.
    pub slope: Vec<f64>,
    pub by_place: f64,
}

impl Control {
    pub(crate) fn missing(&self, system: &System<'_>, displacement: &[f64], place: f64) -> Missing {
        match self {
            Self::Volume(surface, volume) => {
                let mut slope = vec![0.0; displacement.len()];
                let gap = volume + surface.value_and_add_gradient(displacement, &[], &mut slope);
                let slope = system.sparsity.gather(&slope).map(|s| -s).collect();
                Missing { gap, relative: gap.abs() / system.volume(), slope, by_place: 0.0 }
            }
            Self::Plane(Plane { normal: (slope, by_place), distance }) => {
                let free: Vec<f64> = system.sparsity.gather(displacement).collect();
                let gap = distance - dot(slope, &free) - by_place * place;
                let (slope, by_place) = (slope.clone(), *by_place);
                Missing { gap, relative: gap.abs(), slope, by_place }
            }
        }
    }
}
