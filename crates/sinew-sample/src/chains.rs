//! Draws in chains, quantiles, and summaries of a parameter.
//!
//! R̂ and effective sample sizes of chains: Vehtari, Gelman, Simpson, Carpenter and Bürkner,
//! "Rank-normalization, folding, and localization" (Bayesian Analysis, 2021).

use statrs::distribution::{ContinuousCDF, Normal};
use statrs::statistics::{Data, OrderStatistics, RankTieBreaker};

/// Draws of a sampler.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chains {
    /// Parameters by chain and draw; all chains have equally many draws.
    pub draws: Vec<Vec<Vec<f64>>>,
}

/// Moments, quantiles and mixing of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Summary {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// 2.5 %, 50 % and 97.5 % quantile.
    pub quantiles: [f64; 3],
    /// R̂.
    pub r_hat: f64,
    /// Effective sample size of the bulk.
    pub ess_bulk: f64,
    /// Effective sample size of the tails.
    pub ess_tail: f64,
}

impl Chains {
    /// Values of one parameter, chain by chain.
    pub fn parameter(&self, index: usize) -> Vec<Vec<f64>> {
        self.draws.iter().map(|chain| chain.iter().map(|draw| draw[index]).collect()).collect()
    }

    /// All draws, chain after chain.
    pub fn pooled(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.draws.iter().flatten()
    }

    /// Chains thinned to this number of draws at equal distances, the last among them; all if there are fewer.
    pub fn thinned(&self, per_chain: usize) -> Self {
        let thin = |chain: &Vec<Vec<f64>>| {
            let kept = per_chain.min(chain.len());
            (1..=kept).map(|i| chain[i * chain.len() / kept - 1].clone()).collect()
        };
        Self { draws: self.draws.iter().map(thin).collect() }
    }

    /// Summary of one parameter.
    pub fn summary(&self, index: usize) -> Summary {
        Summary::of(&self.parameter(index))
    }

    /// Largest R̂, and smallest effective sample sizes of bulk and tails, over all parameters.
    pub fn mixing(&self) -> [f64; 3] {
        let count = self.pooled().next().map_or(0, Vec::len);
        let all = (0..count).map(|index| self.summary(index));
        all.fold([1.0, f64::INFINITY, f64::INFINITY], |[r_hat, bulk, tail], s| {
            [r_hat.max(s.r_hat), bulk.min(s.ess_bulk), tail.min(s.ess_tail)]
        })
    }

    /// A function of each draw, by chain.
    pub fn mapped(&self, of: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let chain = |chain: &Vec<Vec<f64>>| chain.iter().map(|draw| of(draw)).collect();
        Self { draws: self.draws.iter().map(chain).collect() }
    }
}

impl Summary {
    /// Summary of a quantity by chain and draw.
    pub fn of(chains: &[Vec<f64>]) -> Self {
        let all = chains.concat();
        Self {
            mean: mean(&all),
            deviation: variance(&all).sqrt(),
            quantiles: [0.025, 0.5, 0.975].map(|share| quantile(&all, share)),
            r_hat: r_hat(chains),
            ess_bulk: ess_bulk(chains),
            ess_tail: ess_tail(chains),
        }
    }
}

/// Smallest number of draws of a chain for a diagnostic.
const FEWEST_DRAWS: usize = 4;
/// Range of values below which they count as one: the resolution of double precision, as numpy states it.
const CONSTANT: f64 = 1e-15;
/// Quantiles of the tail's effective sample size.
const TAILS: [f64; 2] = [0.05, 0.95];

/// R̂ of split chains, the larger of that of rank-normalised and of folded rank-normalised draws; one list of draws per
/// chain, all of one length. NaN for fewer than two chains, fewer than four draws or values that are not finite.
pub fn r_hat(chains: &[Vec<f64>]) -> f64 {
    if chains.len() < 2 || !usable(chains) {
        return f64::NAN;
    }
    let split = split(chains);
    let median = quantile_of_sorted(&sorted(&split), 0.5);
    let folded: Vec<Vec<f64>> =
        split.iter().map(|chain| chain.iter().map(|x| (x - median).abs()).collect()).collect();
    plain_r_hat(&normal_scores(&split)).max(plain_r_hat(&normal_scores(&folded)))
}

/// Effective sample size of the bulk: of rank-normalised split chains. NaN as [`r_hat`], but for one chain.
pub fn ess_bulk(chains: &[Vec<f64>]) -> f64 {
    if usable(chains) { effective(&normal_scores(&split(chains))) } else { f64::NAN }
}

/// Effective sample size of the tails: the smaller of that of the 5 % and of the 95 % quantile. NaN as [`ess_bulk`].
pub fn ess_tail(chains: &[Vec<f64>]) -> f64 {
    if !usable(chains) {
        return f64::NAN;
    }
    let all = sorted(chains);
    let of = |share: f64| {
        let bound = quantile_of_sorted(&all, share);
        let below = |x: &f64| f64::from(u8::from(*x <= bound));
        let inside: Vec<Vec<f64>> =
            chains.iter().map(|chain| chain.iter().map(below).collect()).collect();
        effective(&split(&inside))
    };
    of(TAILS[0]).min(of(TAILS[1]))
}

/// Quantile at a share in 0..=1 with linear interpolation between order statistics (type 7 of Hyndman and Fan 1996);
/// NaN of an empty list.
///
/// ```
/// assert_eq!(sinew_sample::quantile(&[4.0, 1.0, 2.0, 3.0], 0.25), 1.75);
/// ```
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

/// [`quantile`] of ascending values.
pub(crate) fn quantile_of_sorted(sorted: &[f64], share: f64) -> f64 {
    let count = sorted.len();
    if count < 2 {
        return sorted.first().copied().unwrap_or(f64::NAN);
    }
    // The operations of scipy's `mquantiles`, so that ties round alike.
    let position = count as f64 * share + (1.0 - share);
    let below = position.clamp(1.0, (count - 1) as f64).floor();
    let part = (position - below).clamp(0.0, 1.0);
    let at = below as usize;
    (1.0 - part) * sorted[at - 1] + part * sorted[at]
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Variance with n − 1.
pub(crate) fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
}

fn usable(chains: &[Vec<f64>]) -> bool {
    let Some(first) = chains.first() else { return false };
    first.len() >= FEWEST_DRAWS
        && chains.iter().all(|chain| chain.len() == first.len())
        && chains.iter().flatten().all(|x| x.is_finite())
}

fn sorted(chains: &[Vec<f64>]) -> Vec<f64> {
    let mut all = chains.concat();
    all.sort_unstable_by(f64::total_cmp);
    all
}

/// First halves of all chains, then second halves; a middle draw is left out.
fn split(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let half = chains[0].len() / 2;
    let first = chains.iter().map(|chain| chain[..half].to_vec());
    first.chain(chains.iter().map(|chain| chain[chain.len() - half..].to_vec())).collect()
}

/// Normal scores of the mean ranks among all draws (Blom, 1958).
fn normal_scores(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let all = chains.concat();
    let length = chains[0].len();
    let normal = Normal::standard();
    let count = all.len() as f64;
    let score = |rank: f64| normal.inverse_cdf((rank - 0.375) / (count + 0.25));
    let ranks = Data::new(all).ranks(RankTieBreaker::Average);
    let scores: Vec<f64> = ranks.into_iter().map(score).collect();
    scores.chunks(length).map(<[f64]>::to_vec).collect()
}

/// Means of the chains.
fn means(chains: &[Vec<f64>]) -> Vec<f64> {
    chains.iter().map(|chain| mean(chain)).collect()
}

fn plain_r_hat(chains: &[Vec<f64>]) -> f64 {
    let draws = chains[0].len() as f64;
    let between = draws * variance(&means(chains));
    let within = mean(&chains.iter().map(|chain| variance(chain)).collect::<Vec<_>>());
    ((between / within + draws - 1.0) / draws).sqrt()
}

/// Effective sample size by Geyer's initial positive and monotone sequences.
fn effective(chains: &[Vec<f64>]) -> f64 {
    let all = sorted(chains);
    let total = all.len() as f64;
    if all[all.len() - 1] - all[0] < CONSTANT {
        return total;
    }
    total / correlation_time(chains).max(1.0 / total.log10())
}

/// Sum of the autocorrelations at all lags, negative ones too, until their noise begins.
fn correlation_time(chains: &[Vec<f64>]) -> f64 {
    let draws = chains[0].len();
    let centre = means(chains);
    // Mean over the chains of the autocovariance at a lag.
    let covariance = |lag: usize| {
        let of = |(chain, mean): (&Vec<f64>, &f64)| {
            let pairs = chain.iter().zip(&chain[lag..]);
            pairs.map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>() / draws as f64
        };
        chains.iter().zip(&centre).map(of).sum::<f64>() / chains.len() as f64
    };
    let count = draws as f64;
    let within = covariance(0) * count / (count - 1.0);
    let between = if chains.len() > 1 { variance(&centre) } else { 0.0 };
    let whole = within * (count - 1.0) / count + between;
    let correlation = |lag: usize| 1.0 - (within - covariance(lag)) / whole;
    let mut found = vec![0.0; draws];
    let (mut even, mut odd) = (1.0, correlation(1));
    (found[0], found[1]) = (even, odd);
    let mut lag = 1;
    while lag + 3 < draws && even + odd > 0.0 {
        (even, odd) = (correlation(lag + 1), correlation(lag + 2));
        if even + odd >= 0.0 {
            (found[lag + 1], found[lag + 2]) = (even, odd);
        }
        lag += 2;
    }
    // Those before the last pair count twice, and the first of that once.
    let kept = lag - 1;
    if even > 0.0 {
        found[kept] = even;
    }
    for lag in (1..kept.saturating_sub(2)).step_by(2) {
        let before = found[lag - 1] + found[lag];
        if found[lag + 1] + found[lag + 2] > before {
            (found[lag + 1], found[lag + 2]) = (0.5 * before, 0.5 * before);
        }
    }
    2.0 * found[..kept].iter().sum::<f64>() + found[kept] - 1.0
}
