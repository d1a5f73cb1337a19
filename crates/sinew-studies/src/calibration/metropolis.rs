//! Adaptive Metropolis on the solver: H. Haario, E. Saksman and J. Tamminen (Bernoulli, 2001).

use super::reference::{self, weight};
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_calibrate::{Forward, Mode, Problem};
use sinew_sample::{split_seed, standard_normals};

/// Steps between two updates of the proposals' covariance.
const EVERY: usize = 50;
/// Steps that are not kept.
const BURN_IN: usize = 100;
/// Added to variances, so that they stay positive.
const NUGGET: f64 = 1e-6;
const STREAM: u64 = 0x414d;

/// A chain of coordinates that starts at a mode with proposals of its covariance, and the solves that it made.
pub(super) fn chain(
    problem: &Problem,
    model: &dyn Forward,
    mode: &Mode,
    steps: usize,
    seed: u64,
) -> (Vec<Vec<f64>>, usize) {
    let count = problem.unknowns.len();
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(seed, STREAM));
    let density = |y: &[f64]| weight(problem, model, y).unwrap_or(f64::NEG_INFINITY);
    // The best scale of a normal target in so many dimensions (Gelman, Roberts and Gilks, 1996).
    let scale = 2.38 * 2.38 / count as f64;
    let mut covariance = reference::covariance(mode);
    let mut now = mode.y[..count].to_vec();
    let mut height = density(&now);
    let mut all = vec![now.clone()];
    for step in 0..steps {
        if step >= BURN_IN && step % EVERY == 0 {
            covariance = of(&all);
        }
        let Some(factor) = Cholesky::new(scale * &covariance) else { break };
        let z = DVector::from_vec(standard_normals(count, &mut random));
        let moved = factor.l() * z;
        let next: Vec<f64> = now.iter().zip(moved.iter()).map(|(y, d)| y + d).collect();
        let other = density(&next);
        if random.random::<f64>().ln() < other - height {
            (now, height) = (next, other);
        }
        all.push(now.clone());
    }
    (all[BURN_IN.min(all.len() - 1)..].to_vec(), steps + 1)
}

fn of(all: &[Vec<f64>]) -> DMatrix<f64> {
    let (count, draws) = (all[0].len(), all.len() as f64);
    let mean = |at: usize| all.iter().map(|y| y[at]).sum::<f64>() / draws;
    let means: Vec<f64> = (0..count).map(mean).collect();
    DMatrix::from_fn(count, count, |i, j| {
        let sum: f64 = all.iter().map(|y| (y[i] - means[i]) * (y[j] - means[j])).sum();
        sum / (draws - 1.0) + if i == j { NUGGET } else { 0.0 }
    })
}
