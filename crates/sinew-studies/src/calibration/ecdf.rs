//! Empirical distribution functions of ranks with simultaneous bands: Säilynoja, Bürkner and Vehtari, "Graphical test for
//! discrete uniformity" (Statistics and Computing, 2022).

use statrs::distribution::{Binomial, Discrete, DiscreteCDF};

/// Halvings of the pointwise probability: below the spacing of the bands' counts.
const HALVINGS: usize = 40;

/// Band that holds the whole empirical distribution function of uniform numbers with a given probability.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EcdfBand {
    /// Points in 0..1 at which the function is looked at, ascending.
    pub points: Vec<f64>,
    /// Least count of numbers up to each point.
    pub lower: Vec<u64>,
    /// Largest count of numbers up to each point.
    pub upper: Vec<u64>,
    /// Number of numbers.
    pub count: u64,
}

impl EcdfBand {
    /// Band of `count` uniform numbers at `points` equally spaced points that holds with probability `probability`.
    pub(super) fn new(count: u64, points: usize, probability: f64) -> Self {
        let points: Vec<f64> = (1..points).map(|i| i as f64 / points as f64).collect();
        let [mut low, mut high] = [probability, 1.0 - f64::EPSILON];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match Self::pointwise(count, &points, middle).holds() >= probability {
                true => high = middle,
                false => low = middle,
            }
        }
        Self::pointwise(count, &points, high)
    }

    /// Central intervals of the counts at each point by itself.
    fn pointwise(count: u64, points: &[f64], probability: f64) -> Self {
        let tail = 0.5 * (1.0 - probability);
        let ends = points.iter().map(|&point| {
            let counts = binomial(point, count);
            (quantile(&counts, tail), quantile(&counts, 1.0 - tail))
        });
        let (lower, upper) = ends.unzip();
        Self { points: points.to_vec(), lower, upper, count }
    }

    /// Probability that counts of uniform numbers stay inside at all points: the counts are a Markov chain from point to
    /// point.
    fn holds(&self) -> f64 {
        let (mut from, mut chances, mut before) = (0, vec![1.0], 0.0);
        for (at, &point) in self.points.iter().enumerate() {
            let step = (point - before) / (1.0 - before);
            let [low, high] = [self.lower[at], self.upper[at]];
            let mut next = vec![0.0; (high - low + 1) as usize];
            for (number, chance) in chances.iter().enumerate() {
                let below = from + number as u64;
                let more = binomial(step, self.count - below);
                for total in low.max(below)..=high.min(self.count) {
                    next[(total - low) as usize] += chance * more.pmf(total - below);
                }
            }
            (from, chances, before) = (low, next, point);
        }
        chances.iter().sum()
    }
}

fn binomial(probability: f64, count: u64) -> Binomial {
    Binomial::new(probability.clamp(0.0, 1.0), count).expect("a probability between 0 and 1")
}

/// Smallest count whose cumulative probability reaches a share.
fn quantile(counts: &Binomial, share: f64) -> u64 {
    (0..counts.n()).find(|count| counts.cdf(*count) >= share).unwrap_or(counts.n())
}

/// Empirical distribution function of ranks against the band that it has to stay in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RankEcdf {
    /// The band.
    pub band: EcdfBand,
    /// Count of ranks up to each point.
    pub counts: Vec<u64>,
}

impl RankEcdf {
    /// The function of ranks scaled to 0..=1, such as the share of draws below the truth.
    pub(super) fn new(ranks: &[f64], points: usize, probability: f64) -> Self {
        let band = EcdfBand::new(ranks.len() as u64, points, probability);
        let count = |point: &f64| ranks.iter().filter(|rank| *rank <= point).count() as u64;
        Self { counts: band.points.iter().map(count).collect(), band }
    }

    /// Whether it is inside at every point.
    pub(super) fn inside(&self) -> bool {
        let ends = self.band.lower.iter().zip(&self.band.upper);
        self.counts.iter().zip(ends).all(|(count, (low, high))| (low..=high).contains(&count))
    }
}
