//! All parameters of a model without bounds: where ensembles are drawn.
//!
//! Each parameter is a logistic function of its q, which opens its interval up; the density of q is the posterior's times
//! |dx/dq|, so that its maximum lies inside even where the posterior's is at a bound.

use crate::fit::optimise::maximise;
use crate::{Evaluation, GpError, Model, Result};
use nalgebra::{DMatrix, DVector};
use sinew_sample::{Laplace, LogDensity};

/// Coordinates q of all parameters, with the density that ensembles are drawn from.
pub(crate) struct Space<'a, const D: usize> {
    model: &'a Model<D>,
    /// Ends of each parameter's interval, on its scale.
    bounds: Vec<[f64; 2]>,
    /// Weights of values that are held, on their scales.
    held: Vec<f64>,
}

/// Largest |q|: a share of 3e-7 of an interval from its end.
const MOST: f64 = 15.0;
/// Share of an interval that a fit at its end is moved inwards by.
const INWARDS: f64 = 1e-3;
/// Iterations from the fit to the maximum of the density of q.
const ITERATIONS: usize = 100;
/// Step in q of the difference of gradients; smaller where the density is narrow.
const STEP: f64 = 1e-2;
/// Curvature that the logarithm of the density has at least: about that of |dx/dq| alone.
const LEAST_CURVATURE: f64 = 0.25;
/// Decrease of the logarithm of the density at two deviations below which a direction is wider than that; 2 for a normal one.
const FALL: f64 = 0.7;

/// The logistic function and its slope, of which neither vanishes by rounding.
fn logistic(q: f64) -> (f64, f64) {
    let s = 1.0 / (1.0 + (-q).exp());
    (s, s / (1.0 + q.exp()))
}

impl<'a, const D: usize> Space<'a, D> {
    /// The space of the first `free` parameters, the others as fitted, and the maximum next to `fitted`, on the parameters' scales,
    /// with the inverse of the curvature there.
    ///
    /// # Errors
    /// If the evidence cannot be evaluated there.
    pub(crate) fn new(model: &'a Model<D>, fitted: &[f64], free: usize) -> Result<(Self, Laplace)> {
        let mut bounds = model.scaled_bounds();
        bounds.truncate(free);
        let (fitted, held) = fitted.split_at(free);
        let share = |(x, [lower, upper]): (&f64, &[f64; 2])| {
            let share = ((x - lower) / (upper - lower)).clamp(INWARDS, 1.0 - INWARDS);
            (share / (1.0 - share)).ln()
        };
        let mut centre: Vec<f64> = fitted.iter().zip(&bounds).map(share).collect();
        let space = Self { model, bounds, held: held.to_vec() };
        space.evaluate(&centre)?;
        let (evaluate, within) = (|q: &[f64]| space.evaluate(q).ok(), vec![[-MOST, MOST]; free]);
        if let Some(found) = maximise(evaluate, &centre, &within, ITERATIONS) {
            centre = found.point;
        }
        let covariance = space.covariance(&centre)?;
        Ok((space, Laplace::from_covariance(&centre, covariance).map_err(not_drawn)?))
    }

    /// Covariance from central differences of the gradient at the maximum.
    fn covariance(&self, centre: &[f64]) -> Result<DMatrix<f64>> {
        let count = centre.len();
        let mut curvature = DMatrix::<f64>::zeros(count, count);
        for column in 0..count {
            let mut step = STEP;
            for _ in 0..2 {
                let gradient = |step: f64| {
                    let mut moved = centre.to_vec();
                    moved[column] += step;
                    Ok::<_, GpError>(DVector::from_vec(self.evaluate(&moved)?.gradient))
                };
                let difference = gradient(-step)? - gradient(step)?;
                curvature.set_column(column, &(difference / (2.0 * step)));
                // A tenth of the width that is left to this parameter alone.
                let narrow = 0.1 / curvature[(column, column)].abs().sqrt();
                if narrow >= step {
                    break;
                }
                step = narrow;
            }
        }
        let eigen = (0.5 * (&curvature + curvature.transpose())).symmetric_eigen();
        let top = self.log_density(centre);
        let mut scaled = eigen.eigenvectors;
        for (mut direction, value) in scaled.column_iter_mut().zip(&eigen.eigenvalues) {
            let curved = value.max(LEAST_CURVATURE).sqrt().recip();
            direction *= self.spread(centre, direction.as_slice(), curved, top);
        }
        Ok(&scaled * scaled.transpose())
    }

    /// Width along a direction: that of the curvature at the centre, `curved`, or more where the density falls by less than a
    /// third of what a normal one of that width does at two deviations, on either side: a spike on a broad density.
    fn spread(&self, centre: &[f64], direction: &[f64], curved: f64, top: f64) -> f64 {
        let widest = LEAST_CURVATURE.sqrt().recip();
        let mut spread = curved;
        for side in [1.0, -1.0] {
            let falls = |spread: f64| {
                let at = centre.iter().zip(direction);
                let at: Vec<f64> = at.map(|(q, d)| q + side * 2.0 * spread * d).collect();
                top - self.log_density(&at)
            };
            while spread < widest && falls(spread) < FALL {
                spread = (2.0 * spread).min(widest);
            }
        }
        spread
    }

    /// The parameters at q, on their scales.
    pub(crate) fn parameters(&self, q: &[f64]) -> Vec<f64> {
        let ends = q.iter().zip(&self.bounds);
        let free = ends.map(|(q, [lower, upper])| lower + (upper - lower) * logistic(*q).0);
        free.chain(self.held.iter().copied()).collect()
    }

    /// Logarithm of |dx/dq| up to a constant.
    fn log_slope(q: &[f64]) -> f64 {
        q.iter().map(|q| logistic(*q).1.ln()).sum()
    }

    /// Logarithm of the density at q; −∞ where the evidence has no value.
    pub(crate) fn log_density(&self, q: &[f64]) -> f64 {
        self.model.log_posterior(&self.parameters(q)) + Self::log_slope(q)
    }

    /// Density of q and its gradient.
    fn evaluate(&self, q: &[f64]) -> Result<Evaluation> {
        let mut found = self.model.evaluate_posterior(&self.parameters(q))?;
        found.value += Self::log_slope(q);
        found.gradient.truncate(q.len());
        for ((q, [lower, upper]), g) in q.iter().zip(&self.bounds).zip(&mut found.gradient) {
            let (s, slope) = logistic(*q);
            *g = *g * (upper - lower) * slope + 1.0 - 2.0 * s;
        }
        Ok(found)
    }
}

impl<const D: usize> LogDensity for Space<'_, D> {
    fn dimension(&self) -> usize {
        self.bounds.len()
    }

    fn value_and_gradient(&self, q: &[f64], gradient: &mut [f64]) -> f64 {
        let Ok(found) = self.evaluate(q) else { return f64::NEG_INFINITY };
        gradient.copy_from_slice(&found.gradient);
        found.value
    }
}

/// A density that gives no draws.
pub(crate) fn not_drawn(error: sinew_sample::SampleError) -> GpError {
    GpError::Invalid(format!(
        "the posterior of the parameters gives no draws: {error}; narrow the bounds, or add values"
    ))
}
