//! Errors and warnings of training, storage and prediction, with numbers and advice.

pub(crate) use crate::coordinates::ensure;

use serde::{Deserialize, Serialize};
use sinew_energy::Unit;
use std::path::{Path, PathBuf};

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Requires that a setting makes sense.
pub(crate) fn require(
    makes_sense: bool,
    what: &'static str,
    value: f64,
    advice: &'static str,
) -> Result<()> {
    ensure(makes_sense, Error::Setting { what, value, advice })
}

/// Requires that something can be used; `reason` says why it cannot.
pub(crate) fn require_usable(usable: bool, reason: impl FnOnce() -> String) -> Result<()> {
    if usable { Ok(()) } else { Err(Error::Refused(reason())) }
}

/// Error at a file or folder.
pub(crate) fn at(path: &Path) -> impl Fn(std::io::Error) -> Error {
    move |source| Error::File { path: path.into(), source }
}

/// Error of training, storing or evaluating an emulator.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum Error {
    /// A number, name or folder of a request that makes no sense, to be corrected without a computation.
    #[error("{0}")]
    Request(String),
    /// A range or a number of samples that a design cannot draw.
    #[error("{0}")]
    Samples(String),
    /// A body, prediction, anchor, folder or file that cannot be used, simulations that are too few, samples that no regression can be fitted to.
    #[error("{0}")]
    Refused(String),
    /// The solver cannot solve the body at all, or not where it was asked to.
    #[error(transparent)]
    Solve(#[from] sinew_fem::SolveError),
    /// A network, or another predictor from outside of this crate, that cannot be made, trained or asked.
    #[error("{0}")]
    Network(Box<dyn std::error::Error + Send + Sync>),
    /// Coordinates or scales that do not suit a body.
    #[error(transparent)]
    Coordinates(#[from] crate::coordinates::CoordinateError),
    /// θ of the wrong length.
    #[error("theta has {found} entries, the body has {expected} parameters: {names}")]
    ThetaLength { found: usize, expected: usize, names: String },
    /// A count or budget that admits no training.
    #[error("{what} is {}; {advice}", Unit::from("1").format(*value))]
    Setting { what: &'static str, value: f64, advice: &'static str },
    /// The observer asked to stop.
    #[error(
        "interrupted in the stage `{stage}`; what was found is stored, and resuming goes on from there"
    )]
    Interrupted { stage: String },
    /// A folder with simulations of other parameters or of another body.
    #[error("{} holds simulations of other parameters or of another body; choose another folder, or delete it", folder.display())]
    OtherSamples { folder: PathBuf },
    /// A folder without an emulator.
    #[error("{} holds no emulator; train one first", folder.display())]
    NoEmulator { folder: PathBuf },
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
}

/// A reason not to trust an emulator, a prediction or a correction. Printed it says what to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Warning {
    /// A training that went wrong though it did not diverge.
    #[error("training `{stage}`: {concern}")]
    Training { stage: String, concern: String },
    /// The prediction for the centre of the parameter range is no equilibrium.
    #[error(
        "predictions are far from equilibrium: at the centre of the parameter range a Newton step would gain {:.1} % of \
         the loads' work; train for longer",
        100.0 * excess
    )]
    FarFromEquilibrium { excess: f64 },
    /// A prediction that no body can have.
    #[error(
        "the prediction {of} inverts a cell; narrow the ranges of the parameters, or allow more anchors (a Taylor expansion), simulations (a \
         regression) or steps (a network)"
    )]
    Inverted { of: String },
    /// Simulations without a solution.
    #[error(
        "{failed} of {tried} simulations of `{stage}` failed and were left out; the first at {theta}: {reason}"
    )]
    FailedSimulations { stage: String, failed: usize, tried: usize, theta: String, reason: String },
    /// Simulations beside which a rising load leads to another stable equilibrium.
    #[error(
        "{count} solutions of `{stage}` are not those that a rising load leads to, the first at {theta}: the body has several stable \
         equilibria, and neighbours may be on different branches; narrow the ranges, or look at them with \
         `sinew solve --load-steps`"
    )]
    SeveralEquilibria { stage: String, count: usize, theta: String },
    /// A solve that met an indefinite stiffness.
    #[error(
        "jumped: the solver passed states that are not stable, and the body may have other stable equilibria; `sinew solve --load-steps` \
         finds that of a rising load"
    )]
    Jumped,
    /// A solution that the least disturbance ends.
    #[error(
        "unstable: the stiffness at the equilibrium has negative eigenvalues, or is too near to singular to tell, and the least disturbance may end it; add one, such as a small load \
         aside, and the body buckles to a stable one"
    )]
    Unstable,
    /// An error larger than was asked for.
    #[error(
        "the root mean square error over the held-out cases is {:.2e} of the displacements where {:.2e} was asked for; simulate more, or allow more time",
        error,
        target
    )]
    TargetMissed { error: f64, target: f64 },
    /// Parameters outside the trained ranges.
    #[error(
        "{parameter} = {value}{unit} is outside the trained range from {low} to {high}{unit}: the prediction extrapolates",
        unit = Unit::from(unit.as_str()).suffix()
    )]
    OutsideRange { parameter: String, value: f64, low: f64, high: f64, unit: String },
    /// Error estimates of this emulator hold less often than they should.
    #[error(
        "error estimates were within a factor of two on {:.0} % of {cases} held-out cases only: some have other equilibria nearby \
         than that of a rising load; check answers with `sinew solve`",
        100.0 * share
    )]
    PoorEstimates { share: f64, cases: usize },
    /// Held-out cases without an error estimate.
    #[error(
        "{refused} of {cases} held-out predictions are not near an equilibrium and have no error estimate; narrow the ranges of the \
         parameters, or allow more anchors (a Taylor expansion), simulations (a regression) or steps (a network)"
    )]
    RefusedEstimates { refused: usize, cases: usize },
    /// A displacement that no equilibrium is near to.
    #[error("{reason}; refine or correct it, or solve it from rest")]
    NotNearEquilibrium { reason: String },
    /// Refined displacements that are not in balance.
    #[error(
        "the residual after the refinement is {:.1} % of the forces; take more steps, or solve: there may be no equilibrium nearby",
        100.0 * residual
    )]
    Unbalanced { residual: f64 },
    /// A correction from too far away.
    #[error(
        "the first Newton step moves the nodes by {:.1} % of their displacement: above {:.0} % a correction may hurt; check \
         the residual, or solve from rest",
        100.0 * relative, 100.0 * limit
    )]
    FarForCorrection { relative: f64, limit: f64 },
    /// A step that left the forces less balanced.
    #[error(
        "Newton step {step} raised the residual from {before:.2e} to {after:.2e} while it lowered the energy; correct more \
         often, or solve from rest"
    )]
    ResidualRose { step: usize, before: f64, after: f64 },
    /// A step that had to be shortened.
    #[error(
        "Newton step {step} was shortened to {length:.3} of its length, because the full step inverts a cell or raises the energy"
    )]
    ShortStep { step: usize, length: f64 },
}
