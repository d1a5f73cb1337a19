//! Distance of an emulator from the solver, and its cost.

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
