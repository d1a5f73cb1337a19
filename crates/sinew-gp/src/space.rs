//! All parameters of a model without bounds: where ensembles are drawn.
//!
//! Each parameter is a logistic function of its q, which opens its interval up; the density of q is the posterior's times
//! |dx/dq|, so that its maximum lies inside even where the posterior's is at a bound.

use crate::error::GpError;
use crate::model::Model;
use crate::optimise::{Evaluated, minimise};
use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side as Triangle};

/// Whitened coordinates z about the maximum: q = q̂ + S z.
pub(crate) struct Space<'a, const D: usize> {
    model: &'a Model<D>,
    /// Ends of each parameter's interval, on its scale.
    bounds: Vec<[f64; 2]>,
    centre: Vec<f64>,
    /// Weights of values that are held, on their scales.
    held: Vec<f64>,
    /// S, of which S Sᵀ is the inverse of the curvature at q̂, one column for each direction.
    pub factor: Mat<f64>,
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
    /// About the maximum next to `fitted`, on the parameters' scales; with `free_weights`, weights of values are among the
    /// coordinates, else they stay as fitted.
    ///
    /// # Errors
    /// If the evidence cannot be evaluated there.
    pub(crate) fn new(
        model: &'a Model<D>,
        fitted: &[f64],
        free_weights: bool,
    ) -> Result<Self, GpError> {
        let mut bounds = model.scaled_bounds();
        let count = if free_weights { fitted.len() } else { model.without_weights() };
        bounds.truncate(count);
        let (fitted, held) = fitted.split_at(count);
        let held = held.to_vec();
        let share = |(x, [lower, upper]): (&f64, &[f64; 2])| {
            let share = ((x - lower) / (upper - lower)).clamp(INWARDS, 1.0 - INWARDS);
            (share / (1.0 - share)).ln()
        };
        let start: Vec<f64> = fitted.iter().zip(&bounds).map(share).collect();
        let factor = Mat::zeros(count, count);
        let mut space = Self { model, bounds, centre: start, held, factor };
        space.evaluate(&space.centre)?;
        let negative = |q: &[f64]| -> Evaluated {
            let (value, gradient) = space.evaluate(q).ok()?;
            Some((-value, gradient.iter().map(|g| -g).collect()))
        };
        let within = vec![[-MOST, MOST]; count];
        if let Some(found) = minimise(negative, &space.centre, &within, ITERATIONS, |_, _| ()) {
            space.centre = found.point;
        }
        space.factor = space.whitening()?;
        Ok(space)
    }

    /// From central differences of the gradient at the centre.
    fn whitening(&self) -> Result<Mat<f64>, GpError> {
        let count = self.centre.len();
        let mut curvature = Mat::<f64>::zeros(count, count);
        for column in 0..count {
            let mut step = STEP;
            for _ in 0..2 {
                let gradient = |step: f64| {
                    let mut moved = self.centre.clone();
                    moved[column] += step;
                    Ok::<_, GpError>(self.evaluate(&moved)?.1)
                };
                let (after, before) = (gradient(step)?, gradient(-step)?);
                for row in 0..count {
                    curvature[(row, column)] = (before[row] - after[row]) / (2.0 * step);
                }
                // A tenth of the width that is left to this parameter alone.
                let narrow = 0.1 / curvature[(column, column)].abs().sqrt();
                if narrow >= step {
                    break;
                }
                step = narrow;
            }
        }
        let symmetric =
            Mat::from_fn(count, count, |i, j| 0.5 * (curvature[(i, j)] + curvature[(j, i)]));
        let Ok(eigen) = SelfAdjointEigen::new(symmetric.as_ref(), Triangle::Lower) else {
            return Err(GpError::NotPositiveDefinite { size: count, jitter: 0.0 });
        };
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let top = self.log_density_of(&self.centre);
        let spread = |mode: usize| {
            let direction: Vec<f64> = vectors.col(mode).iter().copied().collect();
            self.spread(&direction, values[mode].max(LEAST_CURVATURE).sqrt().recip(), top)
        };
        let spreads: Vec<f64> = (0..count).map(spread).collect();
        Ok(Mat::from_fn(count, count, |row, mode| vectors[(row, mode)] * spreads[mode]))
    }

    /// Width along a direction: that of the curvature at the centre, `curved`, or more where the density falls by less than a
    /// third of what a normal one of that width does at two deviations, on either side: a spike on a broad density.
    fn spread(&self, direction: &[f64], curved: f64, top: f64) -> f64 {
        let widest = LEAST_CURVATURE.sqrt().recip();
        let mut spread = curved;
        for side in [1.0, -1.0] {
            let falls = |spread: f64| {
                let at = self.centre.iter().zip(direction);
                let at: Vec<f64> = at.map(|(q, d)| q + side * 2.0 * spread * d).collect();
                top - self.log_density_of(&at)
            };
            while spread < widest && falls(spread) < FALL {
                spread = (2.0 * spread).min(widest);
            }
        }
        spread
    }

    pub(crate) fn dimension(&self) -> usize {
        self.centre.len()
    }

    fn unwhitened(&self, z: &[f64]) -> Vec<f64> {
        let mut q = self.centre.clone();
        for (mode, z) in z.iter().enumerate() {
            q.iter_mut().zip(self.factor.col(mode).iter()).for_each(|(q, s)| *q += s * z);
        }
        q
    }

    fn scaled(&self, q: &[f64]) -> Vec<f64> {
        let ends = q.iter().zip(&self.bounds);
        let free = ends.map(|(q, [lower, upper])| lower + (upper - lower) * logistic(*q).0);
        free.chain(self.held.iter().copied()).collect()
    }

    /// The parameters at z, on their scales.
    pub(crate) fn parameters(&self, z: &[f64]) -> Vec<f64> {
        self.scaled(&self.unwhitened(z))
    }

    /// Logarithm of |dx/dq| up to a constant.
    fn log_slope(q: &[f64]) -> f64 {
        q.iter().map(|q| logistic(*q).1.ln()).sum()
    }

    /// Logarithm of the density at z; −∞ where the evidence has no value.
    pub(crate) fn log_density(&self, z: &[f64]) -> f64 {
        self.log_density_of(&self.unwhitened(z))
    }

    fn log_density_of(&self, q: &[f64]) -> f64 {
        let x = self.scaled(q);
        match self.model.log_evidence(&x) {
            Ok(value) => finite(value + self.model.log_hyperprior(&x) + Self::log_slope(q)),
            Err(_) => f64::NEG_INFINITY,
        }
    }

    /// [`Space::log_density`] with its gradient in z.
    pub(crate) fn log_density_and_slope(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let Ok((value, by_q)) = self.evaluate(&self.unwhitened(z)) else {
            return (f64::NEG_INFINITY, vec![0.0; z.len()]);
        };
        let along = |mode: usize| self.factor.col(mode).iter().zip(&by_q).map(|(s, g)| s * g).sum();
        (finite(value), (0..z.len()).map(along).collect())
    }

    /// Density of q and its gradient.
    fn evaluate(&self, q: &[f64]) -> Result<(f64, Vec<f64>), GpError> {
        let evaluation = self.model.evaluate_posterior(&self.scaled(q))?;
        let each = q.iter().zip(&self.bounds).zip(&evaluation.gradient);
        let gradient = each.map(|((q, [lower, upper]), g)| {
            let (s, slope) = logistic(*q);
            g * (upper - lower) * slope + 1.0 - 2.0 * s
        });
        Ok((evaluation.value + Self::log_slope(q), gradient.collect()))
    }
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NEG_INFINITY }
}
