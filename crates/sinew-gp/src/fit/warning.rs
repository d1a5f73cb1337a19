//! Warnings about an answer, in words.

use crate::error::place;
use thiserror::Error;

/// Why an answer may be worth less than it looks.
///
/// ```
/// use sinew_gp::{
///     Data, Domain, Evidence, FitOptions, Model, Noise, Prior, Problem, Warning, squared_exponential,
/// };
///
/// let domain = Domain::interval("x", [0.0, 1.0])?;
/// let [dx] = domain.derivatives();
/// let prior = Prior::constrained(&Problem::new(domain, dx * dx)?, &squared_exponential())?;
/// let data = Data::new()
///     .values(&[[0.4]], &[1.0], Noise::Learned)
///     .equation(&[[0.5]], &[0.0], Noise::Exact);
/// let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
/// let few = Warning::FewValues { noise: "noise 1".into(), values: 1 };
/// assert!(fit.warnings()?.contains(&few));
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Warning {
    /// A parameter of the equation, or a learned noise, at an end of its range.
    #[error(
        "{parameter} ends at its bound {bound:e}: the posterior is largest there or beyond it; widen the bounds, or read its interval as one-sided"
    )]
    AtBound { parameter: String, bound: f64 },
    /// A parameter of the equation that the data do not tell.
    #[error(
        "unidentified: the data say next to nothing of {parameter}; measure elsewhere, or hold one of the parameters"
    )]
    Unidentified { parameter: String },
    /// No values to learn the equation's parameters from.
    #[error(
        "no value of u is measured, so that the equation's parameters follow from the prior alone; add values of u"
    )]
    NothingMeasured,
    /// Fewer values than a level of noise can be told from.
    #[error(
        "{noise} is learned from {values} values only, so that its prior decides; state the noise, or add values"
    )]
    FewValues { noise: String, values: usize },
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
    Unresolved { at: Vec<f64>, residual: f64, term: f64 },
    /// A value that the others predict far worse than its noise allows.
    #[error(
        "value {value} of the group of {noise} at {}, {measured:.4}, is {:.0} standard deviations from what all other data predict{}; check it, leave it out, or take `Noise::StudentT`",
        place(at), z.abs(), and_others(*others)
    )]
    Outlier { noise: String, value: usize, at: Vec<f64>, measured: f64, z: f64, others: usize },
    /// Importance weights of [`crate::laplace`] with a tail so heavy that its averages cannot be trusted.
    #[error(
        "importance weights are heavy-tailed (k̂ = {k_hat:.2}, above 0.4): Laplace's approximation misses much of the posterior; draw by `nuts`"
    )]
    HeavyWeights { k_hat: f64 },
    /// Chains of [`crate::nuts`] that do not agree.
    #[error(
        "chains disagree on {parameter} (R̂ = {r_hat:.2}, {effective:.0} effective draws); raise `NutsOptions::warmup` and `draws`"
    )]
    NotMixed { parameter: String, r_hat: f64, effective: f64 },
    /// A most probable value outside of what nearly all draws say.
    #[error(
        "the most probable {parameter}, {mode:.4e}, lies outside of 99 % of the draws, {lower:.4e} to {upper:.4e}: the posterior has a narrow maximum apart from most of its mass; report the draws' interval and median"
    )]
    ModeApart { parameter: String, mode: f64, lower: f64, upper: f64 },
    /// Intervals that still moved when collocation points ran out.
    #[error(
        "intervals still move with {points} collocation points; raise `FitOptions::most_points`, or stretch the axis by `Prior::stretched` where the solution is steep"
    )]
    Unsettled { points: usize },
    /// An equation that more collocation points left as far off as it was.
    #[error(
        "the equation is off between {points} collocation points, and more of them did not help: it has no solution with these conditions, or one that the kernel does not resolve; stretch the axis by `Prior::stretched` where that is steep, or take a rougher kernel"
    )]
    Stalled { points: usize },
    /// Linearisations of [`crate::SemiLinear`] that did not converge.
    #[error(
        "u changed by {change:.1e} of its size in the last of {steps} linearisations: too few steps, or no solution near the start; take more, or `SemiLinear::solve_from` the solution of an easier equation"
    )]
    NotConverged { steps: usize, change: f64 },
}

impl Warning {
    /// Warning of an equation that is off between so many points, of so many at most.
    pub(crate) fn of_points(points: usize, most: usize) -> Self {
        if points < most { Self::Stalled { points } } else { Self::Unsettled { points } }
    }
}

fn and_others(others: usize) -> String {
    match others {
        0 => String::new(),
        1 => ", and so is one other".into(),
        count => format!(", and so are {count} others"),
    }
}
