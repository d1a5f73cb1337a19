//! Errors in a scene or in θ, with numbers and advice.

use crate::law::POSITIVE;
use sinew_mesh::Refusal;
use std::ops::RangeInclusive;
use thiserror::Error;

/// Names or numbers for people: `mu, lambda`.
pub fn listed<T: ToString>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

/// A scene that cannot be lowered to a potential, by the part that is to be changed. Messages hold names, numbers and advice.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SceneError {
    /// The mesh violates a rule of [`sinew_mesh::Mesh::check`].
    #[error(transparent)]
    Mesh(#[from] Refusal),
    /// Cells, quadrature, material, factors or known parameters of a body.
    #[error("{0}")]
    Body(String),
    /// Material directions.
    #[error("{0}")]
    Fibres(String),
    /// Supports that contradict each other, act on nothing, or leave the body free to move.
    #[error("{0}")]
    Supports(String),
    /// Loads that act on nothing, on inner facets, or across a plane body.
    #[error("{0}")]
    Loads(String),
    /// A follower pressure without a potential, on a surface whose rim is loose or uneven.
    #[error("{0}")]
    LooseRim(String),
    /// Parameters that law and loads do not read.
    #[error("{0}")]
    Parameters(String),
    /// A law of other bodies, or with a constant that is not positive and finite.
    #[error("{0}")]
    Law(String),
    /// A number of a load or a support that is not finite.
    #[error("{what} is {value}; give a finite number")]
    NotFinite { what: String, value: f64 },
    /// A known value that makes no sense.
    #[error("the known value of `{name}` is {value}; it must be {}", requirement(&(*least..=*most), *value))]
    KnownValue { name: String, value: f64, least: f64, most: f64 },
    /// A range that is empty or not finite, or not positive for log sampling.
    #[error(
        "parameter `{name}` ranges from {} to {}; give finite ends in ascending order, positive for log sampling",
        range[0], range[1]
    )]
    Range { name: String, range: [f64; 2] },
}

/// Parameters that make no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ThetaError {
    /// θ has the wrong length.
    #[error(
        "theta has {given} entries, but {needed} are read: {}, then those of the loads",
        listed(names)
    )]
    Length { given: usize, needed: usize, names: Vec<&'static str> },
    /// A parameter outside the values that make sense.
    #[error("theta[{index}] ({name}) is {value}; it must be {}", requirement(&(*least..=*most), *value))]
    OutOfBounds { index: usize, name: &'static str, value: f64, least: f64, most: f64 },
}

/// Text of the bounds that a value violates, to follow "it must be": `positive`, `at least 0 and less than 0.5`.
pub fn requirement(bounds: &RangeInclusive<f64>, value: f64) -> String {
    let (least, most) = (*bounds.start(), *bounds.end());
    let (tiny, huge) = (*POSITIVE.start(), *POSITIVE.end());
    if (value > 0.0 && value < tiny) || value > huge {
        return format!("between {tiny:e} and {huge:e}, beyond which squares vanish or overflow");
    }
    let below = (most < huge).then(|| match rounded_up(most) {
        open if open > most => format!("less than {open}"),
        closed => format!("at most {closed}"),
    });
    match (least, below) {
        (least, None) if least == tiny => "positive".into(),
        (least, None) if least <= -huge => "finite".into(),
        (least, None) => format!("at least {least}"),
        (least, Some(below)) if least == tiny => format!("positive and {below}"),
        (least, Some(below)) if least <= -huge => below,
        (least, Some(below)) => format!("at least {least} and {below}"),
    }
}

/// A bound rounded to twelve digits: 0.5 − ε gives 0.5.
fn rounded_up(bound: f64) -> f64 {
    format!("{bound:.12}").parse().unwrap_or(bound)
}

/// A name among `known` ones that no parameter has.
pub(crate) fn unknown_parameter<T: ToString>(name: &str, known: &[T]) -> SceneError {
    let known = listed(known);
    SceneError::Body(format!("there is no parameter `{name}`; law and loads read {known}"))
}
