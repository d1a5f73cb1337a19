//! Draws about the fit, weighed by the posterior.

use crate::ensemble::Ensemble;
use crate::error::GpError;
use crate::fit::Fit;
use crate::posterior::standard_normal;
use crate::space::Space;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Proposals for each draw that is kept.
const PROPOSALS: usize = 2;
/// Degrees of freedom of the proposals: tails heavier than any that the posterior is likely to have.
const FREEDOM: i32 = 5;

/// Draws parameters by importance: proposals from Student's t distribution with the curvature at the maximum of the
/// posterior (Laplace's approximation, with heavier tails), of which `draws` are kept with the weight that the posterior has
/// there over the proposals' (Kass & Raftery 1995, §4.2; weights cut off as by Ionides 2008).
///
/// # Errors
/// If the evidence cannot be evaluated next to the fit.
#[doc(alias = "importance sampling")]
pub fn laplace<const D: usize>(
    fit: &Fit<D>,
    draws: usize,
    seed: u64,
) -> Result<Ensemble<D>, GpError> {
    let model = fit.model();
    let space = Space::new(model, &fit.outcome().parameters)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let proposals: Vec<Vec<f64>> =
        (0..PROPOSALS * draws).map(|_| proposal(space.dimension(), &mut random)).collect();
    let weigh = |z: &Vec<f64>| space.log_density(z) - log_density(z);
    let logarithms: Vec<f64> = proposals.par_iter().map(weigh).collect();
    let chosen = resample(&logarithms, draws, random.random());
    let draws = chosen.into_iter().map(|number| space.parameters(&proposals[number]));
    Ok(Ensemble::new(model.clone(), draws.collect()))
}

/// A multivariate t variate.
fn proposal(dimension: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let square: f64 = (0..FREEDOM).map(|_| standard_normal(random).powi(2)).sum();
    let stretch = (f64::from(FREEDOM) / square).sqrt();
    (0..dimension).map(|_| stretch * standard_normal(random)).collect()
}

/// Logarithm of its density, up to a constant.
fn log_density(z: &[f64]) -> f64 {
    let square: f64 = z.iter().map(|z| z * z).sum();
    -0.5 * (f64::from(FREEDOM) + z.len() as f64) * (square / f64::from(FREEDOM)).ln_1p()
}

/// Positions drawn with weights of these logarithms, ascending: systematic resampling, from one uniform number.
fn resample(logarithms: &[f64], count: usize, uniform: f64) -> Vec<usize> {
    let most = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = logarithms.iter().map(|l| (l - most).exp()).collect();
    let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
    let cut = mean * (weights.len() as f64).sqrt();
    weights.iter_mut().for_each(|weight| *weight = weight.min(cut));
    let total: f64 = weights.iter().sum();
    let (mut chosen, mut sum) = (Vec::with_capacity(count), 0.0);
    for (number, weight) in weights.iter().enumerate() {
        sum += weight / total * count as f64;
        while chosen.len() < count && chosen.len() as f64 + uniform < sum {
            chosen.push(number);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_chosen_as_often_as_it_weighs() {
        let weights = [1.0, 1.0, 3.0, 1.0, 2.0_f64];
        let chosen = resample(&weights.map(f64::ln), 8, 0.5);
        assert_eq!(chosen, [0, 1, 2, 2, 2, 3, 4, 4]);
    }
}
