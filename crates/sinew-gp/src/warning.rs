//! What a fit cannot tell, said aloud.

use crate::compile::Variance;
use crate::data::Role;
use crate::error::{GpError, place};
use crate::fit::Fit;
use crate::model::Model;
use crate::operator::Operator;
use crate::space::Space;
use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side as Triangle};
use std::sync::Arc;
use thiserror::Error;

/// Why an answer may be worth less than it looks.
///
/// ```
/// use sinew_gp::{
///     Data, Domain, Evidence, FitOptions, Model, Noise, Prior, Problem, SquaredExponential, Warning,
/// };
///
/// let domain = Domain::interval("x", [0.0, 1.0])?;
/// let [dx] = domain.derivatives();
/// let prior = Prior::constrained(&Problem::new(domain, dx * dx)?, &SquaredExponential::new())?;
/// let data = Data::new()
///     .values(&[[0.4]], &[1.0], Noise::Learned)
///     .equation(&[[0.5]], &[0.0], Noise::Exact);
/// let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
/// let few = Warning::FewValues { noise: "noise 1".into(), values: 1 };
/// assert!(fit.warnings()?.contains(&few));
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Warning {
    /// A parameter of the equation, or a learned noise, at an end of its range.
    #[error(
        "{parameter} ends at its bound {bound:e}: the posterior is largest there or beyond it; widen the bounds, or read its interval as one-sided"
    )]
    AtBound {
        /// Its name.
        parameter: String,
        /// The bound, in its own unit.
        bound: f64,
    },
    /// A direction in the equation's parameters along which the posterior is about as wide as the bounds.
    #[error(
        "the data say next to nothing of {}: there the posterior is about as wide as the bounds; measure elsewhere, or hold one of the parameters",
        named(direction)
    )]
    Unidentified {
        /// Parameters with their shares in the direction, largest first.
        direction: Vec<(String, f64)>,
    },
    /// No values to learn the equation's parameters from.
    #[error(
        "no value of u is measured, so that the equation's parameters follow from the prior alone; add values of u"
    )]
    NothingMeasured,
    /// Fewer values than a level of noise can be told from.
    #[error(
        "{noise} is learned from {values} values only, so that its prior decides; state the noise, or add values"
    )]
    FewValues {
        /// Name of the noise.
        noise: String,
        /// Number of values.
        values: usize,
    },
    /// See [`crate::Outcome::collapsed`].
    #[error(
        "all variation of the values is taken for noise: the trivial solution, or data without information; compare restarts, or add collocation points"
    )]
    Collapsed,
    /// The equation predicts at its own points what it is not given there, worse than a tenth of its terms.
    #[error(
        "left out, the equation at {} is off by {residual:.1e} where its terms are of the size {term:.1e}: too few collocation points, or conditions, values and equation that contradict each other; add points there and compare",
        place(at)
    )]
    Unresolved {
        /// The point where it is worst.
        at: Vec<f64>,
        /// Root mean square over all points.
        residual: f64,
        /// That of the largest term of the equation; a thousandth of the left-hand side's deviation before the data, if that is more.
        term: f64,
    },
    /// Intervals that still moved when collocation points ran out.
    #[error(
        "intervals still move with {points} collocation points; raise `FitOptions::most_points`, or stretch the axis where the solution is steep"
    )]
    Unsettled {
        /// Points in the end.
        points: usize,
    },
}

fn named(direction: &[(String, f64)]) -> String {
    let parts: Vec<&str> = direction.iter().map(|(name, _)| name.as_str()).collect();
    if parts.len() == 1 {
        parts[0].into()
    } else {
        format!("a combination of {}", parts.join(" and "))
    }
}

/// Values below which a level of noise is mostly what is believed of it: the standard deviation of its logarithm from n
/// values is about (2n)^−½.
const FEW: usize = 4;
/// Share of an interval within which its end counts as reached.
const END: f64 = 1e-6;
/// Standard deviation of a parameter's q (see [`Space`]) from which on the data count as silent; without any it is
/// π/√3 ≈ 1.8, with an interval cut in half about 1.
const SILENT: f64 = 1.2;
/// Share in a direction from which on a parameter is named.
const SHARE: f64 = 0.3;
/// Residual of left-out points, in units of the equation's largest term, that is resolved.
const RESOLVED: f64 = 0.1;
/// Share of the left-hand side's standard deviation before the data below which terms count as zero: a residual is not held
/// against what is next to nothing.
const NOTHING: f64 = 1e-3;

/// Points that are left out at most, for time.
const MOST_LEFT_OUT: usize = 200;

impl<const D: usize> Fit<D> {
    /// Warnings about the fit; empty if no fault was found. Takes twice as many evaluations
    /// of the evidence's gradient as there are parameters.
    ///
    /// # Errors
    /// If the evidence cannot be evaluated next to the fit.
    pub fn warnings(&self) -> Result<Vec<Warning>, GpError> {
        let model = self.model();
        let mut warnings = at_bounds(model, &self.outcome().parameters);
        let observed = |g: &&crate::compile::Compiled<D>| g.role == Role::Observed;
        for group in model.groups.iter().filter(observed) {
            if let (Variance::Learned(noise), true) = (group.variance, group.values.len() < FEW) {
                let noise = model.parameters[noise].name.clone();
                warnings.push(Warning::FewValues { noise, values: group.values.len() });
            }
        }
        if !model.theta.is_empty() && !model.groups.iter().any(|g| observed(&g)) {
            warnings.push(Warning::NothingMeasured);
        }
        if self.outcome().collapsed {
            warnings.push(Warning::Collapsed);
        }
        warnings.extend(unidentified(model, &self.outcome().parameters)?);
        warnings.extend(self.unresolved()?);
        warnings.extend(self.unsettled.map(|points| Warning::Unsettled { points }));
        Ok(warnings)
    }

    /// The equation left out at each of its exact points in turn, by the inverse of the covariance.
    fn unresolved(&self) -> Result<Option<Warning>, GpError> {
        let (model, posterior) = (self.model(), self.posterior()?);
        let (mut squares, mut count, mut worst) = (0.0, 0, (0.0, Vec::new()));
        let mut term = 0.0_f64;
        for group in model.groups.iter().filter(|g| !g.places.is_empty()) {
            let at = &group.places;
            term = term.max(NOTHING * posterior.prior_deviation(&model.prior.equation, at)?);
            for (row, at) in group.rows().zip(at).step_by(1 + at.len() / MOST_LEFT_OUT) {
                let left_out = posterior.left_out(row).abs();
                squares += left_out * left_out;
                count += 1;
                if left_out > worst.0 {
                    worst = (left_out, at.to_vec());
                }
            }
            for summand in model.prior.equation.terms() {
                let values = posterior.mean_of(&Operator::of(summand), at)?;
                let square: f64 = values.iter().map(|v| v * v).sum();
                term = term.max((square / values.len() as f64).sqrt());
            }
        }
        let residual = (squares / count.max(1) as f64).sqrt();
        let at = worst.1;
        Ok((residual > RESOLVED * term).then_some(Warning::Unresolved { at, residual, term }))
    }
}

fn at_bounds<const D: usize>(model: &Model<D>, scaled: &[f64]) -> Vec<Warning> {
    let theta = model.theta_offset..model.theta_offset + model.theta.len();
    let learned = |k: usize| model.groups.iter().any(|g| g.variance == Variance::Learned(k));
    let watched = (0..scaled.len()).filter(|k| theta.contains(k) || learned(*k));
    watched
        .filter_map(|k| {
            let end = model.end_reached(k, scaled[k])?;
            let parameter = &model.parameters[k];
            Some(Warning::AtBound {
                parameter: parameter.name.clone(),
                bound: parameter.bounds[end],
            })
        })
        .collect()
}

impl<const D: usize> Model<D> {
    /// Which end of its interval a parameter is at, if any.
    pub(crate) fn end_reached(&self, parameter: usize, scaled: f64) -> Option<usize> {
        let [lower, upper] = self.scaled_bounds()[parameter];
        let near = END * (upper - lower);
        if scaled - lower <= near {
            return Some(0);
        }
        (upper - scaled <= near).then_some(1)
    }
}

/// The direction of θ in which its posterior is widest, if that is nearly all there is.
fn unidentified<const D: usize>(
    model: &Arc<Model<D>>,
    scaled: &[f64],
) -> Result<Option<Warning>, GpError> {
    let (offset, count) = (model.theta_offset, model.theta.len());
    if count == 0 {
        return Ok(None);
    }
    let factor = Space::new(model, scaled)?.factor;
    let covariance = Mat::from_fn(count, count, |i, j| {
        let (a, b) = (factor.row(offset + i), factor.row(offset + j));
        a.iter().zip(b.iter()).map(|(a, b)| a * b).sum::<f64>()
    });
    let Ok(eigen) = SelfAdjointEigen::new(covariance.as_ref(), Triangle::Lower) else {
        return Err(GpError::NotPositiveDefinite { size: count, jitter: 0.0 });
    };
    // Eigenvalues ascend.
    let (last, values) = (count - 1, eigen.S().column_vector());
    if values[last].max(0.0).sqrt() < SILENT {
        return Ok(None);
    }
    let share = |k: usize| (model.theta[k].name().to_string(), eigen.U()[(k, last)]);
    let mut direction: Vec<(String, f64)> =
        (0..count).map(share).filter(|(_, share)| share.abs() > SHARE).collect();
    direction.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    Ok(Some(Warning::Unidentified { direction }))
}
