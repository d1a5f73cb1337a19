//! Data against what their posterior predicts.

use crate::problem::Problem;
use sinew_sample::psis;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Probability of one false alarm or more among all data: each datum has its share (Bonferroni).
const FALSE_ALARMS: f64 = 0.05;
/// Probability below which the sum of all misfits contradicts the noise.
pub(crate) const UNLIKELY: f64 = 0.01;
/// Pareto k̂ from which on a datum cannot be left out by weights.
const MOST_K: f64 = 0.7;

/// One datum beside its prediction.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DatumCheck {
    /// The datum.
    pub name: String,
    /// Measured value, in the unit of the observable.
    pub value: f64,
    /// Mean of the observable over the posterior.
    pub predicted: f64,
    /// Standard deviation of the observable over the posterior.
    pub deviation: f64,
    /// Measured minus predicted over the standard deviation of the measurement.
    pub residual: f64,
    /// Two-sided posterior predictive probability.
    pub p: f64,
    /// Leave-one-out predictive probability: the posterior without this datum; `None` where importance weights are unreliable.
    pub p_left_out: Option<f64>,
}

impl DatumCheck {
    /// The smaller of both probabilities.
    fn least(&self) -> f64 {
        self.p.min(self.p_left_out.unwrap_or(1.0))
    }
}

/// All data beside their predictions.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Predictive {
    /// Datum by datum.
    pub data: Vec<DatumCheck>,
    /// Posterior predictive probability of a sum of squared misfits that is larger (Gelman et al. 6.3).
    pub p_overall: f64,
    /// Root mean square of the residuals, of as many data as are left after one for each parameter \[standard deviations\].
    pub misfit: f64,
}

/// One draw: its coordinates and the solver's observables.
pub(crate) type Draw<'a> = (&'a [f64], &'a [f64]);

impl Predictive {
    pub(crate) fn new(problem: &Problem, draws: &[Draw]) -> Self {
        let data: Vec<DatumCheck> =
            (0..problem.data.len()).map(|at| check(problem, draws, at)).collect();
        let chi = ChiSquared::new(problem.data.len() as f64).expect("positive degrees of freedom");
        let tail = |(y, observed): &Draw| chi.sf(problem.squares(y, observed));
        let p_overall = draws.iter().map(tail).sum::<f64>() / draws.len() as f64;
        let left = data.len().saturating_sub(problem.unknowns.len()).max(1);
        let squares: f64 = data.iter().map(|datum| datum.residual.powi(2)).sum();
        let misfit = (squares / left as f64).sqrt();
        Self { data, p_overall, misfit }
    }

    /// Data that contradict the others.
    pub fn contradicting(&self) -> impl Iterator<Item = &DatumCheck> {
        let least = FALSE_ALARMS / self.data.len() as f64;
        self.data.iter().filter(move |datum| datum.least() < least)
    }

    /// Sentences about what does not fit; none if all does.
    pub fn in_words(&self) -> Vec<String> {
        let contradicts = |datum: &DatumCheck| {
            format!(
                "{} contradicts the other data: measured {:.1} standard deviations from its prediction, p = {:.1e}.",
                datum.name,
                datum.residual,
                datum.least()
            )
        };
        let mut said: Vec<String> = self.contradicting().map(contradicts).collect();
        let p = self.p_overall;
        if p < UNLIKELY {
            said.push(format!(
                "The misfits are larger than the stated noise by a factor of {:.1} (p = {p:.1e}): the standard deviations are too small, or the model is wrong.",
                self.misfit
            ));
        } else if p > 1.0 - UNLIKELY {
            said.push(format!(
                "The misfits are smaller than the stated noise (p = {p:.4}): the standard deviations are too large."
            ));
        }
        said
    }
}

fn check(problem: &Problem, draws: &[Draw], at: usize) -> DatumCheck {
    let (datum, normal) = (&problem.data[at], Normal::standard());
    let bias = problem.kinds.iter().find(|kind| kind.name == datum.kind).map_or(0.0, |k| k.bias);
    let deviation = |y: &[f64]| {
        let factor = problem.log_factor(at, &problem.log_factors(y)).exp();
        factor.hypot(bias / datum.error())
    };
    let misfit = |value: f64| problem.measured[at] - datum.scaled(value);
    let scores: Vec<f64> =
        draws.iter().map(|(y, o)| misfit(o[datum.observable]) / deviation(y)).collect();
    let two_sided = |below: f64| 2.0 * below.min(1.0 - below);
    let count = draws.len() as f64;
    let below = scores.iter().map(|z| normal.cdf(*z)).sum::<f64>() / count;
    // Weights of the posterior without this datum: one over its likelihood.
    let ratio = |((y, _), z): (&Draw, &f64)| 0.5 * z * z + deviation(y).ln();
    let ratios: Vec<f64> = draws.iter().zip(&scores).map(ratio).collect();
    let smoothed = psis(&ratios, 1.0);
    let weighted = smoothed.weights().iter().zip(&scores).map(|(w, z)| w * normal.cdf(*z)).sum();
    let predicted = draws.iter().map(|(_, o)| o[datum.observable]).sum::<f64>() / count;
    let squares = draws.iter().map(|(_, o)| (o[datum.observable] - predicted).powi(2));
    DatumCheck {
        name: datum.name.clone(),
        value: datum.value,
        predicted,
        deviation: (squares.sum::<f64>() / (count - 1.0)).sqrt(),
        residual: misfit(predicted),
        p: two_sided(below),
        p_left_out: (smoothed.k_hat <= MOST_K).then(|| two_sided(weighted)),
    }
}
