//! Errors of a patient, with numbers and advice.

use sinew_energy::{ThetaError, listed};
use sinew_fem::fibres::FibreError;
use sinew_fem::{SolveError, UnloadError};
use thiserror::Error;

/// A patient that makes no sense.
#[derive(Debug, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PatientError {
    /// The body cannot be unloaded.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// The body cannot be solved.
    #[error(transparent)]
    Body(#[from] SolveError),
    /// Values of law and loads that make no sense.
    #[error("at {state}: {source}")]
    Theta { state: String, source: ThetaError },
    /// The wall has no coordinates.
    #[error(transparent)]
    Wall(#[from] FibreError),
    /// A name that no parameter of the body has.
    #[error("{state} sets `{name}`, but the body's parameters are {}", listed(known))]
    UnknownEntry { state: String, name: String, known: Vec<String> },
    /// An entry of θ of the body without a value.
    #[error(
        "`{name}` has no value in {state}: give one, or list `{name}` among the parameters of the patient"
    )]
    Unset { state: String, name: String },
    /// A setting that multiplies by a parameter that the patient does not have.
    #[error(
        "{state} multiplies by `{name}`, but the parameters of the patient are {}",
        listed(known)
    )]
    UnknownParameter { state: String, name: String, known: Vec<String> },
    /// A parameter or a phase that is there twice, or a phase with the name of another state.
    #[error(
        "`{name}` is there twice; `image` and `rest` are names of states that each patient has"
    )]
    Twice { name: String },
    /// A value that is not finite.
    #[error("`{name}` is {value} in {state}; give a finite value")]
    NotFinite { state: String, name: String, value: f64 },
    /// A start of another length, or one that is not positive and finite.
    #[error(
        "the start for `{name}` is {value}; give a positive value near the middle of its range"
    )]
    Start { name: String, value: f64 },
    /// A parameter that nothing reads.
    #[error("nothing reads the parameter `{name}`; the body's are {}", listed(known))]
    UnusedParameter { name: String, known: Vec<String> },
    /// A phase that an observable names and the patient has not.
    #[error(
        "{observable}: there is no phase `{name}`; the states are image, rest, {}",
        listed(known)
    )]
    UnknownPhase { observable: String, name: String, known: Vec<String> },
    /// A patient without observables.
    #[error("there is nothing to observe; add volumes, strains or displacements")]
    NoObservables,
    /// A cavity that no pressure acts in, or that symmetry planes do not close.
    #[error("no pressure acts in a cavity `{name}`; those with a pressure are {}", listed(known))]
    UnknownCavity { name: String, known: Vec<String> },
    /// A segment that is not there.
    #[error("there is no segment `{name}`; there are {}", listed(known))]
    UnknownSegment { name: String, known: Vec<String> },
    /// Strains without segments.
    #[error("strains are averaged over segments; give the patient some")]
    NoSegments,
    /// A direction of the wall without coordinates of the wall.
    #[error("a {direction} direction needs coordinates of the wall; give the patient those")]
    NoCoordinates { direction: String },
    /// Fibre strains of a law without fibres.
    #[error("the law has no fibres, so there is no fibre strain; ask for a direction of the wall")]
    NoFibres,
    /// Coordinates or segments of another mesh.
    #[error(
        "the {what} are of {given} cells, the body has {cells}; make them of the mesh that was lowered"
    )]
    OtherMesh { what: &'static str, given: usize, cells: usize },
    /// A segment without cells.
    #[error(
        "segment {segment} has no cells of {cells}: the mesh is too coarse for this division, or the wall does not reach there; take fewer \
         segments"
    )]
    EmptySegment { segment: String, cells: usize },
    /// Angles around the axis without a direction to count from.
    #[error(
        "the division in segments counts angles from the septum, but its direction is not given: give a vector from the left cavity to the middle of \
         the septum"
    )]
    NoSeptum,
    /// A septum along the axis.
    #[error(
        "the direction of the septum is {degrees:.2} degrees off the long axis, so it marks no angle; give a vector across the axis"
    )]
    SeptumAlongAxis { degrees: f64 },
    /// A field that is not there, or holds no integers.
    #[error("the cell field `{name}` {problem}; the mesh has {}", listed(known))]
    Field { name: String, problem: String, known: Vec<String> },
    /// A point outside of the wall \[length\].
    #[error(
        "({}, {}, {}) is in no cell of the image; the nearest node is {node}, {distance:.4} away: check units and frame of the coordinates",
        point[0], point[1], point[2]
    )]
    OutsideWall { point: [f64; 3], distance: f64, node: usize },
    /// A direction without length.
    #[error("({}, {}, {}) is no direction; give a vector of finite length", direction[0], direction[1], direction[2])]
    NoDirection { direction: [f64; 3] },
    /// Points in other cells than tetrahedra.
    #[error(
        "points are found in linear tetrahedra, not in {cells} cells; give the displacement of a body of those"
    )]
    NotTetrahedra { cells: &'static str },
}
