//! Coordinates in which displacements of a body are learned.

use crate::coordinates::anchors::Anchors;
use crate::coordinates::motions::Motions;
use crate::coordinates::polynomial::expansion;
use crate::coordinates::principal::PrincipalDirections;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Coordinates in which displacements of a body are learned.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// Displacements themselves, in units of an [`OutputScale`](crate::coordinates::OutputScale).
    #[default]
    Components,
    /// Rigid motions of clusters and displacements of nodes within them.
    Motions(Motions),
    /// The directions in which simulations differ.
    Principal(PrincipalDirections),
}

impl Coordinates {
    /// Taylor coefficients of the outputs: per unit of each standardised parameter and of each product of two; empty
    /// without them.
    pub fn slopes(&self) -> &[Vec<f64>] {
        match self {
            Self::Components => &[],
            Self::Motions(motions) => motions.slopes(),
            Self::Principal(directions) => directions.slopes(),
        }
    }

    /// Rates of the logarithm of the amplitude, see [`Motions::with_amplitude`]; empty without an amplitude.
    pub fn rates(&self) -> &[f64] {
        match self {
            Self::Motions(motions) => motions.rates(),
            Self::Components | Self::Principal(_) => &[],
        }
    }

    /// Outputs of the Taylor polynomial at standardised parameters, those of clusters before those of nodes, or their
    /// derivatives along a direction of the parameters; empty without a polynomial.
    pub fn expansion(&self, parameters: &[f64], along: Option<&[f64]>) -> Vec<f64> {
        expansion((self.slopes(), self.rates()), parameters, along)
    }

    /// Further solved states whose displacements are added; none where outputs follow one state.
    pub fn anchors(&self) -> Option<&Arc<Anchors>> {
        match self {
            Self::Motions(motions) => motions.anchors(),
            Self::Components | Self::Principal(_) => None,
        }
    }

    /// Displacements of zero outputs, if they are not those of the scale.
    pub fn origin(&self) -> Option<&[f64]> {
        match self {
            Self::Components => None,
            Self::Motions(motions) => Some(motions.origin()),
            Self::Principal(directions) => Some(directions.origin()),
        }
    }
}
