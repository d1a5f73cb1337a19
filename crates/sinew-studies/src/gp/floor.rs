//! Least squares for θ with the exact solutions of the equation: what noise alone leaves.
//!
//! No method that only knows equation and conditions can be expected to do better on average, however many
//! collocation points it takes; what does owes it to a prior that prefers the solution at hand.

use crate::gp::experiment::{Case, Scale, Task};
use crate::gp::inference::Sampling;
use crate::gp::problems::{Function, Setting};
use crate::gp::row::{Method, Run};
use anyhow::{Result, bail};
use nalgebra::{DMatrix, DVector};
use sinew_energy::listed;
use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

/// The solution of a problem for each θ.
pub(crate) type Family<const D: usize> = fn(&[f64]) -> Function<D>;

/// The case of least squares on the data of the other methods.
pub(crate) fn case<const D: usize>(
    setting: &Setting<D>,
    family: Family<D>,
    sampling: Sampling,
    scale: Scale,
) -> Case {
    let own = setting.clone();
    let run = move |task: &Task| {
        let observed = own.observe(sampling, task)?;
        let start = Instant::now();
        // Not the truth, which a search does not know.
        let begin = own.truth.iter().map(|truth| 1.3 * truth.value).collect();
        let theta = least_squares(family, begin, &observed.places, &observed.values)?;
        let seconds = start.elapsed().as_secs_f64();
        let grid = own.grid(scale);
        let solution = family(&theta);
        let mean: Vec<f64> = grid.iter().map(|x| solution(*x)).collect();
        Ok(Run { err_u: own.error(&grid, &mean), seconds, theta, ..Run::default() })
    };
    Case::new(setting.named(), Method::LeastSquares, run)
}

/// Derivatives of the solution in θ, a column for each.
fn slopes<const D: usize>(family: Family<D>, theta: &[f64], places: &[[f64; D]]) -> DMatrix<f64> {
    let column = |parameter: usize| {
        let step = STEP * theta[parameter];
        let moved = |sign: f64| {
            let mut moved = theta.to_vec();
            moved[parameter] += sign * step;
            values(family, &moved, places)
        };
        (moved(1.0) - moved(-1.0)) / (2.0 * step)
    };
    DMatrix::from_columns(&(0..theta.len()).map(column).collect::<Vec<_>>())
}

fn values<const D: usize>(family: Family<D>, theta: &[f64], places: &[[f64; D]]) -> DVector<f64> {
    let solution = family(theta);
    DVector::from_iterator(places.len(), places.iter().map(|x| solution(*x)))
}

/// Relative step of differences, and of θ where the search ends.
const STEP: f64 = 1e-5;
const CONVERGED: f64 = 1e-9;
const MOST_STEPS: usize = 50;

/// θ by the method of Gauss and Newton from `theta`.
fn least_squares<const D: usize>(
    family: Family<D>,
    theta: Vec<f64>,
    places: &[[f64; D]],
    measured: &[f64],
) -> Result<Vec<f64>> {
    let mut theta = DVector::from_vec(theta);
    let measured = DVector::from_column_slice(measured);
    for _ in 0..MOST_STEPS {
        let slopes = slopes(family, theta.as_slice(), places);
        let residual = &measured - values(family, theta.as_slice(), places);
        let Some(factor) = (slopes.transpose() * &slopes).cholesky() else { break };
        let change = factor.solve(&(slopes.transpose() * &residual));
        theta += &change;
        if change.component_div(&theta).amax() < CONVERGED {
            return Ok(theta.as_slice().to_vec());
        }
    }
    bail!(
        "least squares did not converge in {MOST_STEPS} steps: θ = ({})",
        listed(theta.as_slice())
    )
}

/// Heat-BVP-2: one mode that decays.
pub(crate) fn heat_2(theta: &[f64]) -> Function<3> {
    let rate = 2.0 * theta[0];
    Arc::new(move |[x, y, t]| x.sin() * y.sin() * (-rate * t).exp())
}

/// Wave-BVP-1: two standing waves and a drift.
pub(crate) fn wave_1(theta: &[f64]) -> Function<2> {
    let speed = theta[0];
    Arc::new(move |[x, t]| {
        let second = (2.0 * speed * t).sin() / (4.0 * speed);
        0.5 * t + (speed * t).cos() * x.cos() + second * (2.0 * x).cos()
    })
}

/// Modes of [`advection_diffusion`]: the last one is 1e-5 of the first at the start and decays at once.
const MODES: usize = 60;

/// Advection and diffusion by separation: u = e^{ax − a θ₁ t/2} Σ cₙ e^{−θ₂ n² π² t} sin nπx, a = θ₁/2θ₂.
pub(crate) fn advection_diffusion(theta: &[f64]) -> Function<2> {
    let (advection, diffusion) = (theta[0], theta[1]);
    let a = advection / (2.0 * diffusion);
    let growth = 1.0 - a;
    // ∫ e^{gx} cos kπx over [0, 1]
    let cosine = |k: i32| {
        let wave = f64::from(k) * PI;
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        match growth * growth + wave * wave {
            0.0 => 1.0,
            _ if k == 0 => growth.exp_m1() / growth,
            square => growth * (sign * growth.exp() - 1.0) / square,
        }
    };
    // 2 ∫ e^{gx} sin 2πx sin nπx
    let coefficient = |n: i32| cosine(n - 2) - cosine(n + 2);
    let coefficients: Vec<f64> = (1..=MODES as i32).map(coefficient).collect();
    Arc::new(move |[x, t]| {
        let modes = coefficients.iter().enumerate().map(|(index, c)| {
            let wave = (index + 1) as f64 * PI;
            c * (-diffusion * wave * wave * t).exp() * (wave * x).sin()
        });
        (a * x - 0.5 * a * advection * t).exp() * modes.sum::<f64>()
    })
}
