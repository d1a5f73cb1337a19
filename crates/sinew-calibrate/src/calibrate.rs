//! Calibration: a posterior by an emulator, checked and corrected by the solver.

use crate::fault::{Result, over_noise};
use crate::likelihood::Target;
use crate::polynomial::Polynomial;
use crate::posterior::{LEAST_SHARE, MOST_K, Verified};
use crate::predictive::UNLIKELY;
use crate::{
    CalibrateError, Correction, Identifiability, Mode, Posterior, Problem, Solves, mode,
    noise_in_words,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_sample::{Chains, Laplace, NutsOptions, nuts_from, split_seed, standard_normals};
use std::ops::ControlFlow;

/// Settings of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CalibrateOptions {
    /// Seed of all random choices.
    pub seed: u64,
    /// Starts of the search for the mode.
    pub starts: usize,
    /// Design points of the emulator beside those that the search visits.
    pub design: usize,
    /// Highest degree of the emulator's polynomial.
    pub degree: usize,
    /// Draws that the solver checks in each round.
    pub checks: usize,
    /// Draws of the result.
    pub draws: usize,
    /// Rounds at most.
    pub rounds: usize,
    /// Steps of each chain that adapt.
    pub warmup: usize,
    /// Draws of each chain on the emulator.
    pub steps: usize,
}

impl Default for CalibrateOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            starts: 4,
            design: 60,
            degree: 4,
            checks: 100,
            draws: 560,
            rounds: 5,
            warmup: 400,
            steps: 3600,
        }
    }
}

/// Chains.
const CHAINS: usize = 4;
/// Share of the design that is drawn from the prior.
const PRIOR_SHARE: f64 = 0.3;
/// Standard deviations of the rest of the design over those of the Laplace approximation.
const INFLATION: f64 = 1.5;
/// Design points that the states of others are predicted from, beside the mode.
const AMONG: usize = 24;
/// Power of the emulator's likelihood in the first round. Below 1, the weights of the solver's likelihood fall with the misfit, which bounds them:
/// their tail is light although the emulator errs most in the tails.
const WIDE: f64 = 0.95;
/// Factor of the power after a round whose weights have a heavy tail all the same.
const WIDER: f64 = 0.85;
/// R̂ above which the chains on the emulator disagree.
const DISAGREE: f64 = 1.05;
/// Misfit \[standard deviations\] above which a datum is out of reach, if no solve comes nearer.
const OUT_OF_REACH: f64 = 5.0;
/// Bounds of the lengths that scale derivatives in the fit of the emulator \[prior standard deviations\].
const LENGTHS: [f64; 2] = [0.05, 1.0];
/// Seed streams.
const STARTS: u64 = 0x5354;
const DESIGN: u64 = 0x4445;
const CHAIN: u64 = 0x4348;

/// The posterior of the solver. Draws of an emulator's posterior are checked by the solver. Its solves are added to the
/// emulator's design until the importance weights are good. One sweep of independence Metropolis then corrects the draws.
///
/// # Errors
/// No answer of the solver at any start; a datum out of reach; chains that disagree; a posterior that the solver does not confirm,
/// with what was reached.
pub fn calibrate(
    problem: &Problem,
    solves: &mut Solves,
    options: &CalibrateOptions,
) -> Result<Posterior> {
    let modes = mode::modes(problem, solves, starts(problem, options))?;
    check_reach(problem, solves, &modes[0])?;
    let about = Laplace::from_precision(&modes[0].y, modes[0].precision.clone())?;
    let design = design(problem, &modes, options)?;
    let design: Vec<_> = design.iter().map(|y| problem.theta(y)).collect();
    let among: Vec<_> =
        std::iter::once(&modes[0].theta).chain(design.iter().take(AMONG)).cloned().collect();
    solves.forward.expect_among(&among);
    solves.at("design points", &design, true)?;
    check_reach(problem, solves, &modes[0])?;
    let starts: Vec<Vec<f64>> = modes.iter().map(|mode| mode.y.clone()).collect();
    let (mut reached, mut power) = (Correction::default(), WIDE);
    for round in 1..=options.rounds {
        let Some(emulator) = fit(problem, solves, &modes[0], &about, options.degree) else { break };
        let target = Target::new(problem, &emulator, power);
        let seed = split_seed(options.seed, CHAIN + round as u64);
        let (warmup, draws) = (options.warmup, options.steps);
        let nuts = NutsOptions { chains: CHAINS, warmup, draws, seed };
        let chains = nuts_from(&target, &about, &starts, &nuts, &|| ControlFlow::Continue(()))?;
        agree(problem, &chains, &modes)?;
        let kept = chains.thinned(options.draws.div_ceil(CHAINS));
        let few = kept.thinned(options.checks.div_ceil(CHAINS));
        let stage = format!("check by the solver, round {round}");
        let mut verified = Verified::new(&target, solves, &stage, few)?;
        let promising = verified.is_promising(round == options.rounds);
        if promising {
            verified = Verified::new(&target, solves, "correction by the solver", kept)?;
        }
        let correction = Correction {
            rounds: round,
            solves: solves.count(),
            failed: solves.failed(),
            seconds: solves.seconds(),
            ..verified.correction.clone()
        };
        // Then importance sampling gives the solver's posterior from these draws.
        let confirmed = correction.k_hat <= MOST_K && correction.share >= LEAST_SHARE;
        if promising && confirmed {
            return Ok(Posterior::new(problem, &modes[0], &verified, correction, options.seed));
        }
        // Ratios whose tail alone is too heavy are those of proposals that are too narrow.
        if correction.k_hat > MOST_K && correction.share >= LEAST_SHARE {
            power *= WIDER;
        }
        reached = correction;
    }
    let over_noise = over_noise(&modes[0].misfits);
    Err(CalibrateError::Unconfirmed(Box::new(Correction { over_noise, ..reached })))
}

/// Mode and the parameters that the data determine there, before sampling: from one start, from several if the misfits are larger than
/// the stated noise.
///
/// # Errors
/// No answer of the solver near the middle of the prior, or a datum out of reach.
pub fn check_identifiability(
    problem: &Problem,
    solves: &mut Solves,
) -> Result<(Mode, Identifiability)> {
    let middle = vec![0.0; problem.unknowns.len()];
    let mut mode = mode::modes(problem, solves, vec![middle])?.remove(0);
    if Identifiability::fit(problem, &mode)[0] < UNLIKELY {
        let starts = starts(problem, &CalibrateOptions::default());
        mode = mode::modes(problem, solves, starts)?.remove(0);
    }
    let seen = Identifiability::new(problem, &mode);
    Ok((mode, seen))
}

/// The middle of the prior, and draws of it.
fn starts(problem: &Problem, options: &CalibrateOptions) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(options.seed, STARTS));
    let count = problem.unknowns.len();
    let others = (1..options.starts).map(|_| standard_normals(count, &mut random));
    std::iter::once(vec![0.0; count]).chain(others).collect()
}

/// Coordinates from inflated Laplace approximations of all modes, and from the prior.
fn design(problem: &Problem, modes: &[Mode], options: &CalibrateOptions) -> Result<Vec<Vec<f64>>> {
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(options.seed, DESIGN));
    let from_prior = (PRIOR_SHARE * options.design as f64).round() as usize;
    let near = options.design - from_prior.min(options.design);
    let mut points = Vec::with_capacity(options.design);
    for (number, mode) in modes.iter().enumerate() {
        let about = Laplace::from_precision(&mode.y, mode.precision.clone())?;
        let share = near / modes.len() + usize::from(number < near % modes.len());
        points.extend(about.draws(share, INFLATION, &mut random));
    }
    let dimension = problem.dimension();
    points.extend((0..from_prior).map(|_| standard_normals(dimension, &mut random)));
    Ok(points)
}

/// Emulator fitted to all solves. Solves with a higher posterior density have a larger weight.
fn fit(
    problem: &Problem,
    solves: &Solves,
    mode: &Mode,
    about: &Laplace,
    degree: usize,
) -> Option<Polynomial> {
    let answers = solves.answers();
    let factors = &mode.y[problem.unknowns.len()..];
    let log_posterior = |theta: &[f64], observed| {
        let coordinates = problem.unknowns.iter().zip(theta);
        let mut y: Vec<f64> = coordinates.map(|(u, t)| u.prior.coordinate(*t)).collect();
        y.extend(factors);
        problem.log_posterior(&y, observed)
    };
    let heights: Vec<f64> = answers.iter().map(|(t, o)| log_posterior(t, o)).collect();
    let best = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let unit = 2.0 * (problem.unknowns.len() as f64 + 4.0);
    let weight = |height: &f64| 1.0 / (1.0 + 2.0 * (best - height) / unit);
    let samples = answers.iter().zip(&heights);
    let samples: Vec<_> =
        samples.map(|((t, o), height)| problem.sample(t, o, weight(height))).collect();
    Polynomial::fit(&samples, &lengths(problem, about), degree)
}

/// Posterior standard deviations of the standardised logarithms, within [`LENGTHS`].
fn lengths(problem: &Problem, about: &Laplace) -> Vec<f64> {
    let covariance: DMatrix<f64> = about.covariance();
    let length = |(at, unknown): (usize, &crate::Unknown)| {
        let slope = unknown.prior.logarithm(about.mode()[at])[1] / unknown.prior.moments()[1];
        (covariance[(at, at)].sqrt() * slope).clamp(LENGTHS[0], LENGTHS[1])
    };
    problem.unknowns.iter().enumerate().map(length).collect()
}

/// Refuses chains that disagree about a parameter.
fn agree(problem: &Problem, chains: &Chains, modes: &[Mode]) -> Result<()> {
    let found = (0..problem.unknowns.len()).map(|at| (chains.summary(at).r_hat, at));
    let (r_hat, at) = found.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((1.0, 0));
    if r_hat < DISAGREE {
        return Ok(());
    }
    let places = modes.iter().map(|mode| {
        let pairs = problem.unknowns.iter().zip(&mode.theta);
        let named = pairs.map(|(u, t)| format!("{} = {:.3}", u.head(), u.shown(*t)));
        named.collect::<Vec<_>>().join(", ")
    });
    Err(CalibrateError::NoPosterior(format!(
        "the chains disagree (R̂ {r_hat:.2} for {}); {} modes were found: {}; there is no one answer to these data: \
         add a datum, narrow a range so that one mode is left, or see whether standard deviations are too small",
        problem.unknowns[at].name,
        modes.len(),
        places.collect::<Vec<_>>().join("; ")
    )))
}

/// Refuses a datum that no solve came near.
fn check_reach(problem: &Problem, solves: &Solves, mode: &Mode) -> Result<()> {
    let answers = solves.answers();
    for (datum, misfit) in problem.data.iter().zip(&mode.misfits) {
        let values = answers.iter().map(|(_, observed)| observed.values[datum.observable]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        let below = datum.value + OUT_OF_REACH * datum.error() < low;
        let above = datum.value - OUT_OF_REACH * datum.error() > high;
        if misfit.abs() < OUT_OF_REACH || !(below || above) {
            continue;
        }
        let said =
            |value: f64| format!("{:.4} {}", value / datum.size, datum.unit).trim_end().to_string();
        let (side, extreme, reached) = match below {
            true => ("below", "smallest", low),
            false => ("above", "largest", high),
        };
        let noise =
            noise_in_words(&mode.misfits).map_or(String::new(), |noise| format!("; {noise}"));
        return Err(CalibrateError::Input(format!(
            "{} is {}, {side} every value that the ranges reach: the {extreme} that was found is {}; look at unit, phase and surface of \
             this datum, at its standard deviation, and at the pressures{noise}",
            datum.name,
            said(datum.value),
            said(reached)
        )));
    }
    Ok(())
}
