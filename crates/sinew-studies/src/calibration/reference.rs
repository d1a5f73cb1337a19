//! Posteriors by brute force.

use anyhow::Result;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew_calibrate::{Forward, Mode, Posterior, Problem};
use sinew_sample::{Summary, effective_share, split_seed, standard_normals};
use std::time::Instant;

/// Bins of equal probability for the total variation: 2400 exact draws leave about .03.
const BINS: usize = 12;
/// Degrees of freedom of the proposals of importance sampling, and their standard deviations over those of the Laplace approximation.
const FREEDOM: usize = 5;
const INFLATION: f64 = 1.2;
const STREAM: u64 = 0x494d;

/// Marginals of the logarithms of the parameters.
#[derive(Serialize, Deserialize)]
pub(super) struct Reference {
    /// Inner ends of bins of equal probability, by parameter.
    edges: Vec<Vec<f64>>,
    means: Vec<f64>,
    deviations: Vec<f64>,
    pub solves: usize,
    /// Solves without an answer, which have no weight.
    pub failed: usize,
    /// Effective share of the draws of importance sampling.
    pub share: f64,
    pub seconds: f64,
}

impl Reference {
    /// Importance sampling with draws of Student's t about a mode.
    pub(super) fn importance(
        problem: &Problem,
        model: &dyn Forward,
        mode: &Mode,
        draws: usize,
        seed: u64,
    ) -> Result<Self> {
        let clock = Instant::now();
        let count = problem.unknowns.len();
        let factor = Cholesky::new(INFLATION * INFLATION * covariance(mode))
            .ok_or_else(|| anyhow::anyhow!("the mode has no covariance"))?;
        let mut random = ChaCha8Rng::seed_from_u64(split_seed(seed, STREAM));
        let draw = |_| {
            let z = DVector::from_vec(standard_normals(count, &mut random));
            let squares: f64 = standard_normals(FREEDOM, &mut random).iter().map(|z| z * z).sum();
            z * (FREEDOM as f64 / squares).sqrt()
        };
        let all: Vec<DVector<f64>> = (0..draws).map(draw).collect();
        let solve = |t: &DVector<f64>| {
            let moved = factor.l() * t;
            let y: Vec<f64> = moved.iter().zip(&mode.y).map(|(d, y)| y + d).collect();
            let freedom = FREEDOM as f64;
            let proposal = -0.5 * (freedom + count as f64) * (t.norm_squared() / freedom).ln_1p();
            let height = weight(problem, model, &y).map(|height| height - proposal);
            (problem.theta(&y).iter().map(|t| t.ln()).collect(), height)
        };
        let found: Vec<(Vec<f64>, Option<f64>)> = all.par_iter().map(solve).collect();
        let failed = found.iter().filter(|(_, height)| height.is_none()).count();
        let weighed =
            |(at, height): (Vec<f64>, Option<f64>)| (at, height.unwrap_or(f64::NEG_INFINITY));
        Ok(Self::new(found.into_iter().map(weighed).collect(), (draws, failed), clock))
    }

    fn new(
        samples: Vec<(Vec<f64>, f64)>,
        (solves, failed): (usize, usize),
        clock: Instant,
    ) -> Self {
        let heights: Vec<f64> = samples.iter().map(|(_, height)| *height).collect();
        let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = heights.iter().map(|height| (height - most).exp()).sum();
        let mut found = Self {
            edges: Vec::new(),
            means: Vec::new(),
            deviations: Vec::new(),
            solves,
            failed,
            share: effective_share(&heights),
            seconds: clock.elapsed().as_secs_f64(),
        };
        for parameter in 0..samples.first().map_or(0, |(at, _)| at.len()) {
            let weighed = samples.iter().map(|(at, h)| (at[parameter], (h - most).exp() / total));
            let mut weighed: Vec<_> = weighed.filter(|(_, weight)| *weight > 0.0).collect();
            weighed.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mean: f64 = weighed.iter().map(|(x, w)| x * w).sum();
            let square: f64 = weighed.iter().map(|(x, w)| (x - mean).powi(2) * w).sum();
            let (mut below, mut edges) = (0.0, Vec::new());
            for (x, w) in &weighed {
                below += w;
                if edges.len() + 1 < BINS && below * BINS as f64 >= edges.len() as f64 + 1.0 {
                    edges.push(*x);
                }
            }
            found.edges.push(edges);
            found.means.push(mean);
            found.deviations.push(square.sqrt());
        }
        found
    }

    /// Largest distance over the parameters: total variation over bins of equal probability, and the errors of means \[sd\] and of
    /// standard deviations.
    pub(super) fn distance(&self, posterior: &Posterior) -> [f64; 3] {
        let of = |parameter: usize| {
            let draws = posterior.draws.parameter(parameter).concat();
            let logs: Vec<f64> = draws.iter().map(|theta| theta.ln()).collect();
            let count = logs.len() as f64;
            let mut bins = [0.0; BINS];
            for x in &logs {
                bins[self.edges[parameter].partition_point(|edge| edge < x)] += 1.0 / count;
            }
            let variation = bins.iter().map(|share| (share - 1.0 / BINS as f64).abs()).sum::<f64>();
            let found = Summary::of(&[logs]);
            let deviation = self.deviations[parameter];
            let of_mean = (found.mean - self.means[parameter]).abs() / deviation;
            [0.5 * variation, of_mean, (found.deviation / deviation - 1.0).abs()]
        };
        let all = (0..self.means.len()).map(of);
        all.fold([0.0; 3], |most, found| std::array::from_fn(|i| f64::max(most[i], found[i])))
    }
}

/// Logarithm of the posterior of the solver at coordinates.
fn weight(problem: &Problem, model: &dyn Forward, y: &[f64]) -> Option<f64> {
    let seen = model.observe(&problem.theta(y), false).ok()?;
    Some(problem.log_posterior(y, &seen))
}

/// Covariance of the Laplace approximation about a mode.
fn covariance(mode: &Mode) -> DMatrix<f64> {
    let count = mode.information.nrows();
    let precision = &mode.information + DMatrix::identity(count, count);
    precision.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count))
}
