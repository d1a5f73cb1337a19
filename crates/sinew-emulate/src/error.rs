//! Errors of training, storage and prediction, with numbers and advice.

use crate::RegressionError;
use sinew_energy::Unit;
use std::path::PathBuf;

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Error of training, storing or evaluating an emulator.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum Error {
    /// A range that samples cannot be drawn from.
    #[error(
        "parameter {parameter} ranges from {low} to {high}: give a smaller and a larger finite value, both positive \
         where samples are uniform in the logarithm"
    )]
    Range { parameter: String, low: f64, high: f64 },
    /// More samples or parameters than Sobol's sequence is tabulated for.
    #[error(
        "Sobol's sequence is tabulated for {most} samples of {most_axes} parameters; {count} of {axes} are too many, use a \
         Latin hypercube"
    )]
    Sobol { count: usize, axes: usize, most: usize, most_axes: usize },
    /// The solver cannot solve the body at all, or not where it was asked to.
    #[error(transparent)]
    Solve(#[from] sinew_fem::SolveError),
    /// A network, or another predictor from outside of this crate, that cannot be made, trained or asked.
    #[error("{0}")]
    Network(Box<dyn std::error::Error + Send + Sync>),
    /// Coordinates or scales that do not suit a body.
    #[error(transparent)]
    Coordinates(#[from] crate::coordinates::CoordinateError),
    /// Simulations that no regression can be fitted to.
    #[error(transparent)]
    Regression(#[from] RegressionError),
    /// Too many simulations failed.
    #[error("{solved} of {tried} simulations succeeded, {least} are needed{first}")]
    TooFewSimulations { solved: usize, tried: usize, least: usize, first: String },
    /// Parameters outside the ranges of the body, in training.
    #[error(
        "sample {sample} has {parameter} = {value}, outside its range from {low} to {high}: widen the range of the body's \
         parameter, or leave the sample out"
    )]
    OutsideRange { sample: usize, parameter: String, value: String, low: String, high: String },
    /// θ of the wrong length.
    #[error("theta has {found} entries, the body has {expected} parameters: {names}")]
    ThetaLength { found: usize, expected: usize, names: String },
    /// A count or budget that admits no training.
    #[error("{what} is {}; {advice}", Unit::from("1").format(*value))]
    Setting { what: &'static str, value: f64, advice: &'static str },
    /// A case index beyond those of the prediction.
    #[error("there is no case {case} in a prediction of {cases}")]
    NoSuchCase { case: usize, cases: usize },
    /// Fields that cannot be compared with the true ones.
    #[error(
        "{found} fields for {expected} test cases, or a field that is not {length} finite numbers long"
    )]
    Fields { found: usize, expected: usize, length: usize },
    /// The observer asked to stop.
    #[error(
        "interrupted in the stage `{stage}`; what was found is stored, and resuming goes on from there"
    )]
    Interrupted { stage: String },
    /// A folder with simulations of other parameters or of another body.
    #[error("{} holds simulations of other parameters or of another body; choose another folder, or delete it", folder.display())]
    OtherSamples { folder: PathBuf },
    /// A folder without simulations.
    #[error("{} holds no simulations; name a folder that simulations were stored or merged in", folder.display())]
    NoSimulations { folder: PathBuf },
    /// Shards that were not solved to the end.
    #[error("{} lacks the shards {missing}; solve them, then merge", folder.display())]
    MissingShards { folder: PathBuf, missing: String },
    /// A resumed run with another recipe, other options or another body.
    #[error(
        "the run in {} was started with another recipe, other options or for another body ({differs}); repeat them, or begin \
         it again (--restart)",
        folder.display()
    )]
    OtherRun { folder: PathBuf, differs: &'static str },
    /// A folder with a run, without `resume` or `restart`.
    #[error(
        "{} holds a run that is {state}: --resume {resumed}, --restart replaces it; or choose another folder (--name)",
        folder.display()
    )]
    RunExists { folder: PathBuf, state: &'static str, resumed: &'static str },
    /// A folder in use for something else.
    #[error("{} exists but is not of an earlier training; choose another folder", folder.display())]
    ForeignFolder { folder: PathBuf },
    /// A folder whose networks a training cannot start from.
    #[error(
        "training cannot start from {}: {reason}; name the folder of a finished run of the same recipe and parameters",
        folder.display()
    )]
    Start { folder: PathBuf, reason: String },
    /// A run that would be written over what it learns from.
    #[error(
        "{} lies in {}, which the new run replaces; give the new run another folder", from.display(), folder.display()
    )]
    OwnSource { folder: PathBuf, from: PathBuf },
    /// An emulator whose kind of predictor this build does not load.
    #[error(
        "{} holds an emulator of the kind `{kind}`, which this build does not load; build with the feature `networks`, or load it with \
         the crate that trained it",
        folder.display()
    )]
    UnknownKind { folder: PathBuf, kind: String },
    /// A solved state that an expansion was to go through, and cannot.
    #[error(
        "anchor {number} at {theta} has no solution: {reason}; narrow the ranges of the parameters, or ask for {} anchors at most",
        number - 1
    )]
    Anchor { number: usize, theta: String, reason: String },
    /// Anchors for a recipe that stands about no state.
    #[error(
        "the recipe `{recipe}` has no anchors, and {anchors} were asked for; choose taylor, pi or hybrid, or leave them out"
    )]
    NoAnchors { recipe: String, anchors: usize },
    /// A parameter set that nothing answered.
    #[error("no answer was found; solve it from rest (sinew solve)")]
    Unanswered,
    /// An emulator that is not stored.
    #[error(
        "an emulator of the kind `{kind}` is not stored: it needs another body's stiffness; keep that body and make it again"
    )]
    NotStored { kind: &'static str },
    /// A folder without an emulator.
    #[error("{} holds no emulator; train one first", folder.display())]
    NoEmulator { folder: PathBuf },
    /// An emulator of another body.
    #[error(
        "the emulator in {} was trained for another body: {what} was {stored} and is {found}; load it with the mesh, law, \
         loads and supports that it was trained for",
        folder.display()
    )]
    OtherBody { folder: PathBuf, what: &'static str, stored: String, found: String },
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// A file that holds something else.
    #[error(
        "{} is damaged or of another version ({reason}); delete it, or begin the run again (--restart)", path.display()
    )]
    Content { path: PathBuf, reason: String },
    /// A file that changed since it was stored.
    #[error("{} {how}; take the whole folder from a copy, or make it again", path.display())]
    Damaged { path: PathBuf, how: &'static str },
    /// Simulations that changed since they were stored.
    #[error(
        "{} was changed after it was stored, or an earlier version stored it; delete its folder to solve the simulations again",
        path.display()
    )]
    DamagedSimulations { path: PathBuf },
    /// A body without free parameters.
    #[error(
        "the body has no free parameters ({known}), so there is one equilibrium and nothing to emulate: solve it (sinew solve), \
         or give a parameter a range"
    )]
    NoParameters { known: String },
    /// A prediction that is not finite.
    #[error("the prediction for {theta} is not finite; {reason}")]
    NotFinite { theta: String, reason: String },
}
