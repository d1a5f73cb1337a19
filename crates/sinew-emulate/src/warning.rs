//! Reasons not to trust a result, carried in it.

use serde::{Deserialize, Serialize};
use sinew_energy::Unit;

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
    #[error("the prediction {of} inverts a cell; train for longer")]
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
    OutsideRange {
        parameter: String,
        value: f64,
        low: f64,
        high: f64,
        #[serde(default = "unitless")]
        unit: String,
    },
    /// Error estimates of this emulator hold less often than they should.
    #[error(
        "error estimates were within a factor of two on {:.0} % of {cases} held-out cases only: some have other equilibria nearby \
         than that of a rising load; check answers with `sinew solve`",
        100.0 * share
    )]
    PoorEstimates { share: f64, cases: usize },
    /// Held-out cases without an error estimate.
    #[error(
        "{refused} of {cases} held-out predictions are not near an equilibrium and have no error estimate; train for longer, \
         simulate more, or narrow the ranges of the parameters"
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

fn unitless() -> String {
    "1".into()
}
