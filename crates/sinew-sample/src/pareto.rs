//! Pareto smoothed importance sampling: Vehtari, Simpson, Gelman, Yao and Gabry (JMLR, 2024), with the generalised
//! Pareto distribution fitted as by Zhang and Stephens (Technometrics, 2009).

/// Fewest weights in the tail that a distribution is fitted to.
const FEWEST_IN_TAIL: usize = 5;
/// Weight of the prior k = ½ of the fit \[samples\].
const PRIOR_SAMPLES: f64 = 10.0;
/// Strength of the prior of Zhang and Stephens' scale.
const PRIOR_SCALE: f64 = 3.0;
/// Weights of grid points below this do not count, as in `arviz`.
const NEGLIGIBLE: f64 = 10.0 * f64::EPSILON;

/// Importance weights with their tail smoothed.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// Logarithms of the weights, whose sum is 1.
    pub log_weights: Vec<f64>,
    /// Shape k̂ of the tail: means are reliable below 0.5, doubtful from 0.7 on; infinite if the tail has fewer than five
    /// distinct weights.
    pub k_hat: f64,
}

impl Smoothed {
    /// Weights, whose sum is 1.
    pub fn weights(&self) -> Vec<f64> {
        self.log_weights.iter().map(|w| w.exp()).collect()
    }
}

/// Smooths importance weights given by logarithms up to a constant; −∞ is a weight of 0. `relative_efficiency` is the
/// effective share of the proposals, 1 for independent ones.
pub fn psis(log_ratios: &[f64], relative_efficiency: f64) -> Smoothed {
    let most = log_ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut logs: Vec<f64> = log_ratios.iter().map(|x| x - most).collect();
    let k_hat = smooth_tail(&mut logs, relative_efficiency);
    let sum = logs.iter().map(|x| x.exp()).sum::<f64>().ln();
    logs.iter_mut().for_each(|x| *x -= sum);
    Smoothed { log_weights: logs, k_hat }
}

/// Effective share of importance weights given by logarithms up to a constant: (Σw)² / (n Σw²), in 0..=1; 0 if none is
/// positive.
pub fn effective_share(log_ratios: &[f64]) -> f64 {
    let most = log_ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return 0.0;
    }
    let weights = log_ratios.iter().map(|x| (x - most).exp());
    let [sum, squares] = weights.fold([0.0, 0.0], |[s, q], w| [s + w, q + w * w]);
    sum * sum / (log_ratios.len() as f64 * squares)
}

/// Replaces the largest weights by quantiles of the distribution fitted to them; its shape.
fn smooth_tail(logs: &mut [f64], relative_efficiency: f64) -> f64 {
    let count = logs.len() as f64;
    let wanted = (count / 5.0).min(3.0 * (count / relative_efficiency).sqrt()).ceil() as usize;
    let mut order: Vec<usize> = (0..logs.len()).collect();
    order.sort_by(|&a, &b| logs[a].total_cmp(&logs[b]));
    let Some(last) = order.len().checked_sub(wanted + 1) else { return f64::INFINITY };
    let cut = logs[order[last]].max(f64::MIN_POSITIVE.ln());
    let tail: Vec<usize> = order.into_iter().filter(|&at| logs[at] > cut).collect();
    if tail.len() < FEWEST_IN_TAIL {
        return f64::INFINITY;
    }
    let base = cut.exp();
    let excess: Vec<f64> = tail.iter().map(|&at| logs[at].exp() - base).collect();
    let (shape, scale) = fit(&excess);
    if shape.is_finite() {
        let length = tail.len() as f64;
        for (place, &at) in tail.iter().enumerate() {
            let quantile = quantile((place as f64 + 0.5) / length, shape, scale);
            logs[at] = (quantile + base).ln().min(0.0);
        }
    }
    shape
}

/// Shape and scale of the generalised Pareto distribution of ascending excesses.
fn fit(excess: &[f64]) -> (f64, f64) {
    let count = excess.len() as f64;
    let grid = 30 + count.sqrt() as usize;
    let quartile = excess[(count / 4.0 + 0.5) as usize - 1];
    let shape_of = |b: f64| excess.iter().map(|x| (-b * x).ln_1p()).sum::<f64>() / count;
    let points: Vec<f64> = (1..=grid)
        .map(|i| {
            let part = 1.0 - (grid as f64 / (i as f64 - 0.5)).sqrt();
            part / (PRIOR_SCALE * quartile) + 1.0 / excess[excess.len() - 1]
        })
        .collect();
    let likelihood = |b: &f64| {
        let shape = shape_of(*b);
        count * ((-(b / shape)).ln() - shape - 1.0)
    };
    let heights: Vec<f64> = points.iter().map(likelihood).collect();
    let weight = |height: &f64| 1.0 / heights.iter().map(|h| (h - height).exp()).sum::<f64>();
    let weights = heights.iter().map(weight);
    let kept: Vec<_> = points.iter().zip(weights).filter(|(_, w)| *w >= NEGLIGIBLE).collect();
    let total: f64 = kept.iter().map(|(_, w)| w).sum();
    let b = kept.iter().map(|(b, w)| *b * w / total).sum::<f64>();
    let shape = shape_of(b);
    let scale = -shape / b;
    ((count * shape + PRIOR_SAMPLES * 0.5) / (count + PRIOR_SAMPLES), scale)
}

/// Quantile of the generalised Pareto distribution.
fn quantile(probability: f64, shape: f64, scale: f64) -> f64 {
    if scale <= 0.0 {
        return f64::NAN;
    }
    let logarithm = -(-probability).ln_1p();
    if shape.abs() < f64::EPSILON {
        scale * logarithm
    } else {
        scale * (shape * logarithm).exp_m1() / shape
    }
}
