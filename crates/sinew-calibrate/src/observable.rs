//! Quantities that are seen of a patient, and models that compute them.

use std::fmt;

/// Direction of a segment's strain, a line of the tissue in the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Around the long axis, in the layer of equal depth.
    Circumferential,
    /// Towards the base, in the layer of equal depth.
    Longitudinal,
    /// Across the wall.
    Radial,
    /// The first direction of the law.
    Fibre,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(["circumferential", "longitudinal", "radial", "fibre"][*self as usize])
    }
}

/// A scalar observable of a patient. States are `image`, which it shows, `rest`, the unloaded body, and phases, by their names.
#[derive(Clone, Debug, PartialEq)]
pub enum Observable {
    /// Volume of a cavity \[length³\], as [`sinew_energy::Cavity`] defines it.
    Volume {
        /// Facet set of the pressure that fills the cavity.
        cavity: String,
        /// State.
        at: String,
    },
    /// Strain ½(|F e|² − 1) of lines of tissue from one state to another, averaged over the volume of a segment in the image.
    Strain {
        /// Name of the segment.
        segment: String,
        /// Direction e of the lines.
        direction: Direction,
        /// State that it is counted from.
        from: String,
        /// State.
        to: String,
    },
    /// Displacement of a point of the wall along a direction \[length\].
    Displacement {
        /// Place in the image \[length\].
        point: [f64; 3],
        /// Direction of any length.
        direction: [f64; 3],
        /// State that it is counted from.
        from: String,
        /// State.
        to: String,
    },
}

impl Observable {
    /// Volume of a cavity in a state.
    pub fn volume(cavity: impl Into<String>, at: impl Into<String>) -> Self {
        Self::Volume { cavity: cavity.into(), at: at.into() }
    }

    /// Strain of a segment from one state to another.
    pub fn strain(
        segment: impl Into<String>,
        direction: Direction,
        from: impl Into<String>,
        to: impl Into<String>,
    ) -> Self {
        Self::Strain { segment: segment.into(), direction, from: from.into(), to: to.into() }
    }

    /// Displacement of a point along a direction from one state to another.
    pub fn displacement(
        point: [f64; 3],
        direction: [f64; 3],
        from: impl Into<String>,
        to: impl Into<String>,
    ) -> Self {
        Self::Displacement { point, direction, from: from.into(), to: to.into() }
    }
}

impl fmt::Display for Observable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Volume { cavity, at } => write!(f, "volume of {cavity} at {at}"),
            Self::Strain { segment, direction, from, to } => {
                write!(f, "{direction} strain of segment {segment} from {from} to {to}")
            }
            Self::Displacement { point: [x, y, z], direction: [a, b, c], from, to } => {
                write!(
                    f,
                    "displacement of ({x}, {y}, {z}) along ({a}, {b}, {c}) from {from} to {to}"
                )
            }
        }
    }
}

/// Observables of a patient as functions of the parameters.
///
/// The physics (unloading, phases, volumes, strains) implements this; the statistics read nothing else.
pub trait Forward: Sync {
    /// Number of parameters.
    fn parameters(&self) -> usize;

    /// Number of observables.
    fn observables(&self) -> usize;

    /// Observables at θ, and their derivatives if `derivatives`.
    ///
    /// # Errors
    /// No unloaded body at θ, or no equilibrium at a phase.
    fn observe(&self, theta: &[f64], derivatives: bool) -> Result<Observed, ForwardError>;

    /// Announces θ, the centre first, among which most later ones lie. The default does nothing; a model may prepare for them.
    fn expect_among(&self, _thetas: &[Vec<f64>]) {}
}

/// Observables at one θ.
#[derive(Debug, Clone)]
pub struct Observed {
    /// One value per observable, in its own unit.
    pub values: Vec<f64>,
    /// One row per observable, one column per parameter; empty if not asked for.
    pub jacobian: Vec<Vec<f64>>,
}

/// A θ at which a body has no observables, with the reason.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{reason}")]
pub struct ForwardError {
    /// Reason in words, with numbers.
    pub reason: String,
}
