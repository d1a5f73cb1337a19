//! What an equilibrium meets whose place on a line in loads and parameters is unknown.

use crate::newton::Search;
use crate::system::System;
use crate::vector::dot;
use sinew_energy::{PressureLoad, PressureSurface};

/// What is met.
pub(crate) enum Control {
    /// A surface has swept a volume \[length³\].
    Volume(Surface, f64),
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

/// What is missing, and its derivatives.
pub(crate) struct Missing {
    pub gap: f64,
    /// The gap relative to what counts as one.
    pub relative: f64,
    /// Derivatives of what is controlled in the free displacements and in the place.
    pub slope: Vec<f64>,
    pub by_place: f64,
}

/// The surface whose volume is prescribed.
#[derive(Clone)]
pub(crate) enum Surface {
    Flat(PressureLoad),
    Curved(PressureSurface),
}

impl Surface {
    /// Swept volume; its gradient is written to `gradient`.
    fn swept(&self, displacement: &[f64], gradient: &mut [f64]) -> f64 {
        let against = match self {
            Self::Flat(load) => load.value_and_add_gradient(displacement, &[], gradient),
            Self::Curved(load) => load.value_and_add_gradient(displacement, &[], gradient),
        };
        gradient.iter_mut().for_each(|g| *g = -*g);
        -against
    }
}

impl Control {
    pub(crate) fn missing(&self, system: &System<'_>, search: &Search<'_>) -> Missing {
        let displacement = &search.at.displacement;
        match self {
            Self::Volume(surface, volume) => {
                let mut slope = vec![0.0; displacement.len()];
                let gap = volume - surface.swept(displacement, &mut slope);
                let slope = system.sparsity.gather(&slope).collect();
                Missing { gap, relative: gap.abs() / system.volume(), slope, by_place: 0.0 }
            }
            Self::Plane(Plane { normal: (slope, by_place), distance }) => {
                let free: Vec<f64> = system.sparsity.gather(displacement).collect();
                let gap = distance - dot(slope, &free) - by_place * search.place;
                let (slope, by_place) = (slope.clone(), *by_place);
                Missing { gap, relative: gap.abs(), slope, by_place }
            }
        }
    }
}
