//! Reasons why there is no posterior, and distance of an emulator from the solver.

use sinew_sample::quantile;

/// Misfits over the stated noise from which on that is named as the cause of a failure: four times its variance.
const TOO_LARGE: f64 = 2.0;
/// Median of the absolute value of a standard normal variable.
const MEDIAN: f64 = 0.674_489_750_196_082;

/// Reason why there is no posterior, with what was reached.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum CalibrateError {
    /// Data, priors or settings that make no sense, and a datum that no parameters come near.
    #[error("{0}")]
    Input(String),
    /// No body at rest or no equilibrium at any start.
    #[error(
        "the solver has no answer at any of {starts} starts within the ranges; the last reason: {reason}; try `sinew unload` at one θ, and look at \
         pressure, units and ranges"
    )]
    NoStart { starts: usize, reason: String },
    /// Chains that disagree, time that is over, or a run that was stopped.
    #[error("{0}")]
    NoPosterior(String),
    /// The solver does not confirm the emulator's posterior.
    #[error(
        "the solver does not confirm this posterior after {} rounds: k̂ {:.2} (at most 0.5), effective share {:.2} (at least 0.5), \
         largest error {:.2} standard deviations of {}, {} solves, {} of them without an answer; {}",
        .0.rounds, .0.k_hat, .0.share, .0.largest_error, .0.worst_datum, .0.solves, .0.failed, cause(.0)
    )]
    Unconfirmed(Box<Correction>),
    /// A file of solves that cannot be used.
    #[error("{0}")]
    Store(String),
    /// The sampler gave up.
    #[error(transparent)]
    Sample(#[from] sinew_sample::SampleError),
}

pub(crate) type Result<T, E = CalibrateError> = std::result::Result<T, E>;

/// Distance of the emulator's posterior from the solver's, and course of the correction.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Correction {
    /// Rounds of adding design points and sampling.
    pub rounds: usize,
    /// Pareto k̂ of the importance weights, solver's over emulator's posterior.
    pub k_hat: f64,
    /// Effective share of the draws under these ratios.
    pub share: f64,
    /// Largest error of the emulator: 95 % quantile over draws, largest over data \[standard deviations of the datum\].
    pub largest_error: f64,
    /// The datum that has it.
    pub worst_datum: String,
    /// Misfits at the mode over the stated noise, by their median.
    pub over_noise: f64,
    /// Share of proposals of the sweep that were accepted.
    pub acceptance: f64,
    /// Degree of the emulator's polynomial.
    pub degree: usize,
    /// Solves in all.
    pub solves: usize,
    /// Solves that have no answer.
    pub failed: usize,
    /// Wall time \[s\].
    pub seconds: f64,
}

/// Misfits over the stated noise, by their median: about 1 where it is right, and hardly more for one datum that is wrong.
pub(crate) fn over_noise(misfits: &[f64]) -> f64 {
    quantile(&misfits.iter().map(|misfit| misfit.abs()).collect::<Vec<_>>(), 0.5) / MEDIAN
}

/// Sentence about misfits \[standard deviations\] that are too large for the stated noise; `None` where they are not.
pub fn noise_in_words(misfits: &[f64]) -> Option<String> {
    too_large(over_noise(misfits))
}

fn too_large(times: f64) -> Option<String> {
    (times > TOO_LARGE).then(|| {
        format!("the misfits are {times:.1} times the stated noise: the standard deviations are too small, or the model is wrong")
    })
}

fn cause(reached: &Correction) -> String {
    too_large(reached.over_noise).unwrap_or_else(|| {
        format!(
            "allow more rounds or design points, narrow the ranges, or see whether the standard deviation of {} is too small",
            reached.worst_datum
        )
    })
}
