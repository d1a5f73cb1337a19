//! Coordinates of a body's displacement, and scales of its parameters: what an emulator of any kind predicts, in plain numbers.
//!
//! Clusters of nodes as rigid bodies, with a Taylor expansion of second order in the parameters about one solution:
//!
//! ```
//! use sinew_emulate::coordinates::{Motions, halves};
//! use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
//!
//! let mesh = sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]);
//! let beam = Scene::new(mesh, NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
//!     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
//!     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
//!     .support(Support::clamped("x_min"))
//!     .lower()?;
//! let rest = vec![0.0; 3 * beam.nodes];
//! // The tip sinks by 1 mm with the first standardised parameter.
//! let sinks: Vec<f64> = beam.positions.iter().flat_map(|x| [0.0, 0.0, -(x[0] / 30.0).powi(2)]).collect();
//! let level = vec![0.0; 3 * beam.nodes];
//! let motions = Motions::about(&rest, &halves(&beam.positions), &beam, &beam.centre())?;
//! let motions = motions.with_expansion(&[sinks.clone(), level], &beam)?;
//! let moved = motions.expansion_at(&[1e-3, 0.0], &beam)?;
//! assert!(moved.iter().zip(&sinks).all(|(u, sink)| (u - 1e-3 * sink).abs() < 1e-6));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Motions`]: outputs at every scale by the stiffness of a body; [`MotionTree`] composes them.
//! - [`PrincipalDirections`]: the directions in which simulations differ.
//! - [`Dirichlet`]: what supports prescribe, written over a prediction.
//! - [`ParameterScaling`], [`OutputScale`]: standardised parameters and displacements.

mod anchors;
mod dirichlet;
mod error;
mod motions;
pub mod packed;
mod principal;
mod scaling;
mod split;
mod tree;

pub use anchors::Anchors;
pub use dirichlet::Dirichlet;
pub use error::{CoordinateError, require_count, require_finite, require_positive};
pub(crate) use error::{Result, ensure};
pub use motions::{Anchor, Motions};
pub(crate) use motions::{matrix, of_eigenvalues, rigid_motions};
pub use principal::{PrincipalDirections, all_terms, check_terms};
pub(crate) use principal::{expansion, terms};
pub use scaling::{OutputScale, ParameterScaling};
pub use tree::{MotionTree, halves};
pub(crate) use tree::{Number, cluster_centres, cluster_counts};

use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Coordinates in which displacements of a body are learned.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// Displacements themselves, in units of an [`OutputScale`].
    #[default]
    Components,
    /// Rigid motions of clusters and displacements of nodes within them.
    Motions(Motions),
    /// The directions in which simulations differ.
    Principal(PrincipalDirections),
}

impl Coordinates {
    /// Taylor coefficients of the outputs, per unit of each standardised parameter and of each product of two, and rates of the logarithm of
    /// their amplitude ([`Motions::with_amplitude`]); empty without them.
    pub fn taylor(&self) -> (&[Vec<f64>], &[f64]) {
        match self {
            Self::Components => (&[], &[]),
            Self::Motions(motions) => (&motions.slopes, &motions.rates),
            Self::Principal(directions) => (directions.slopes(), &[]),
        }
    }

    /// Outputs of the Taylor polynomial at standardised parameters, those of clusters before those of nodes, or their
    /// derivatives along a direction of the parameters; empty without a polynomial.
    pub fn expansion(&self, parameters: &[f64], along: Option<&[f64]>) -> Vec<f64> {
        expansion(self.taylor(), parameters, along)
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
