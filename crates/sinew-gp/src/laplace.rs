//! Draws about the fit, weighed by the posterior.

use crate::ensemble::{Ensemble, TRUSTED};
use crate::error::GpError;
use crate::fit::Fit;
use crate::nuts::{NutsOptions, nuts};
use crate::posterior::standard_normal;
use crate::space::Space;
use faer::{Mat, Side as Triangle};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Proposals for each draw that is kept.
const PROPOSALS: usize = 2;
/// Degrees of freedom of the proposals: tails heavier than any that the posterior is likely to have.
const FREEDOM: i32 = 5;

/// Draws parameters by importance: proposals from Student's t distribution with the curvature at the maximum of the
/// posterior (Laplace's approximation, with heavier tails; wider where the density falls more slowly than that), of which `draws`
/// are kept with the weight that the posterior has there over the proposals' (Kass & Raftery 1995, §4.2; weights cut off as by
/// Ionides 2008). Where weights are heavy-tailed, the proposals move to the mean and covariance of what they found and are drawn
/// again, three times at most (population Monte Carlo, Cappé et al. 2004); [`Ensemble::k_hat`] says how heavy they stay.
///
/// Weights of values ([`crate::Noise::StudentT`]) stay as fitted.
///
/// # Errors
/// If the evidence cannot be evaluated next to the fit.
#[doc(alias = "importance sampling")]
pub fn laplace<const D: usize>(
    fit: &Fit<D>,
    draws: usize,
    seed: u64,
) -> Result<Ensemble<D>, GpError> {
    let space = Space::new(fit.model(), &fit.outcome().parameters, false)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut proposals = Proposals::standard(space.dimension());
    for round in 0.. {
        let drawn: Vec<(Vec<f64>, f64)> =
            (0..PROPOSALS * draws).map(|_| proposals.draw(&mut random)).collect();
        let weigh = |(z, own): &(Vec<f64>, f64)| space.log_density(z) - own;
        let logarithms: Vec<f64> = drawn.par_iter().map(weigh).collect();
        let k_hat = pareto_k(&logarithms);
        if k_hat <= LIGHT || round == ROUNDS {
            let chosen = resample(&logarithms, draws, random.random());
            let draws = chosen.into_iter().map(|number| space.parameters(&drawn[number].0));
            return Ensemble::checked(fit, draws.collect(), Some(k_hat));
        }
        proposals = proposals.moved(&drawn, &truncated(&logarithms));
    }
    unreachable!("the last round returns")
}

/// Draws by [`laplace`] where its weights can be trusted, else as many by [`crate::nuts`].
///
/// # Errors
/// As these two.
pub fn ensemble<const D: usize>(
    fit: &Fit<D>,
    draws: usize,
    seed: u64,
) -> Result<Ensemble<D>, GpError> {
    let weighed = laplace(fit, draws, seed)?;
    match weighed.k_hat {
        Some(k_hat) if k_hat > TRUSTED => {
            nuts(fit, &NutsOptions { draws, seed, ..NutsOptions::default() })
        }
        _ => Ok(weighed),
    }
}

/// Pareto k̂ up to which proposals stay unchanged.
const LIGHT: f64 = 0.4;
/// Factor of the covariance that proposals move to: that of weights that were cut off is too small.
const INFLATION: f64 = 1.3;
/// Times that proposals are moved at most.
const ROUNDS: usize = 3;

/// A multivariate t distribution about `centre`.
struct Proposals {
    centre: Vec<f64>,
    /// Lower triangular.
    factor: Mat<f64>,
}

impl Proposals {
    fn standard(dimension: usize) -> Self {
        let factor = Mat::identity(dimension, dimension);
        Self { centre: vec![0.0; dimension], factor }
    }

    /// A variate and the logarithm of its density, up to a constant.
    fn draw(&self, random: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
        let dimension = self.centre.len();
        let square: f64 = (0..FREEDOM).map(|_| standard_normal(random).powi(2)).sum();
        let stretch = (f64::from(FREEDOM) / square).sqrt();
        let t: Vec<f64> = (0..dimension).map(|_| stretch * standard_normal(random)).collect();
        let mut z = self.centre.clone();
        for (column, t) in t.iter().enumerate() {
            z.iter_mut().zip(self.factor.col(column).iter()).for_each(|(z, f)| *z += f * t);
        }
        let square: f64 = t.iter().map(|t| t * t).sum();
        let power = 0.5 * (f64::from(FREEDOM) + dimension as f64);
        (z, -power * (square / f64::from(FREEDOM)).ln_1p())
    }

    /// Moves to the mean and the covariance of weighted draws; unchanged where these have no covariance.
    fn moved(self, drawn: &[(Vec<f64>, f64)], weights: &[f64]) -> Self {
        let (dimension, total) = (self.centre.len(), weights.iter().sum::<f64>());
        let weighted = || drawn.iter().map(|(z, _)| z).zip(weights);
        let average = |of: &dyn Fn(&[f64]) -> f64| -> f64 {
            weighted().map(|(z, weight)| weight * of(z)).sum::<f64>() / total
        };
        let centre: Vec<f64> = (0..dimension).map(|k| average(&|z| z[k])).collect();
        let covariance = Mat::from_fn(dimension, dimension, |i, j| {
            let product = average(&|z| (z[i] - centre[i]) * (z[j] - centre[j]));
            INFLATION * product + if i == j { 1e-4 } else { 0.0 }
        });
        match covariance.llt(Triangle::Lower) {
            Ok(factor) => Self { centre, factor: factor.L().to_owned() },
            Err(_) => self,
        }
    }
}

/// Shape k̂ of the generalised Pareto distribution of the largest weights of these logarithms (Zhang & Stephens 2009, with the
/// prior and the number of weights of Vehtari et al. 2024); above 0.7 averages over the weights cannot be trusted.
fn pareto_k(logarithms: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = logarithms.iter().copied().filter(|l| l.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let size = logarithms.len() as f64;
    let tail = (0.2 * size).min(3.0 * size.sqrt()).ceil() as usize;
    if tail < 5 || sorted.len() <= tail {
        return f64::INFINITY;
    }
    let most = sorted[sorted.len() - 1];
    let cut = (sorted[sorted.len() - tail - 1] - most).exp();
    let x: Vec<f64> = sorted[sorted.len() - tail..]
        .iter()
        .map(|l| ((l - most).exp() - cut).max(1e-300))
        .collect();
    let (count, largest, quartile) = (tail as f64, x[tail - 1], x[(tail / 4).max(1) - 1]);
    let shape = |b: f64| x.iter().map(|x| (-b * x).ln_1p()).sum::<f64>() / count;
    let candidates = 30 + count.sqrt() as usize;
    let candidate = |i: usize| {
        let b = 1.0 / largest
            + (1.0 - (candidates as f64 / (i as f64 + 0.5)).sqrt()) / (3.0 * quartile);
        let k = shape(b);
        (b, count * ((-b / k).ln() - k - 1.0))
    };
    let all: Vec<(f64, f64)> =
        (0..candidates).map(candidate).filter(|(_, l)| l.is_finite()).collect();
    let best = all.iter().map(|(_, l)| *l).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = all.iter().map(|(_, l)| (l - best).exp()).sum();
    let b = all.iter().map(|(b, l)| b * (l - best).exp()).sum::<f64>() / total;
    let k = (count * shape(b) + 5.0) / (count + 10.0);
    if k.is_finite() { k } else { f64::INFINITY }
}

/// Weights of these logarithms, cut off at √n times their mean.
fn truncated(logarithms: &[f64]) -> Vec<f64> {
    let most = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = logarithms.iter().map(|l| (l - most).exp()).collect();
    let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
    let cut = mean * (weights.len() as f64).sqrt();
    weights.iter_mut().for_each(|weight| *weight = weight.min(cut));
    weights
}

/// Positions drawn with weights of these logarithms, ascending: systematic resampling, from one uniform number.
fn resample(logarithms: &[f64], count: usize, uniform: f64) -> Vec<usize> {
    let weights = truncated(logarithms);
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
    fn tails_of_weights_have_the_shape_they_were_drawn_with() {
        // Quantiles of Pareto distributions of weights, u^−k, and of weights of a normal target under wider proposals.
        for k in [0.2, 0.5, 0.9, 1.5] {
            let logarithms: Vec<f64> =
                (0..4000).map(|n| -k * ((f64::from(n) + 0.5) / 4000.0_f64).ln()).collect();
            let found = pareto_k(&logarithms);
            assert!((found - k).abs() < 0.12, "{found} for {k}");
        }
        let bounded: Vec<f64> = (0..800).map(|n| -0.5 * (f64::from(n) / 400.0).powi(2)).collect();
        assert!(pareto_k(&bounded) < 0.3);
        assert_eq!(pareto_k(&[0.0; 3]), f64::INFINITY);
    }

    #[test]
    fn each_is_chosen_as_often_as_it_weighs() {
        let weights = [1.0, 1.0, 3.0, 1.0, 2.0_f64];
        let chosen = resample(&weights.map(f64::ln), 8, 0.5);
        assert_eq!(chosen, [0, 1, 2, 2, 2, 3, 4, 4]);
    }
}
