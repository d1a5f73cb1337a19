//! Fixed-size sketch of an error distribution on a logarithmic axis.
//!
//! A test set has 10⁵ to 10⁷ element errors; their histogram has at most
//! [`DECADES`] × [`BINS_PER_DECADE`] numbers and carries the density plots of
//! thesis Figs 3.3 and 3.4.

use serde::{Deserialize, Serialize};

/// Bins per factor of ten: 7 % wide each, finer than any bandwidth drawn from it.
pub const BINS_PER_DECADE: i32 = 32;
/// Smaller errors, exact zeros at clamped nodes among them, count as `below`.
const LOWEST_DECADE: i32 = -16;
/// Larger errors count as `above`.
const HIGHEST_DECADE: i32 = 8;
/// Range of the histogram in factors of ten.
pub const DECADES: i32 = HIGHEST_DECADE - LOWEST_DECADE;

/// Smallest bandwidth in bins (0.08 decades). Neighbouring nodes err together, so there is
/// less information than the number of samples that Silverman's rule counts on.
const MIN_BANDWIDTH_BINS: f64 = 2.5;
/// The Gaussian is cut here, where 6e-5 of its mass is left.
const KERNEL_REACH: f64 = 4.0;

/// Histogram over log₁₀ of the error.
///
/// Bin `i` of `counts` holds the samples `x` with
/// `first_bin + i ≤ 32 log₁₀ x < first_bin + i + 1`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LogHistogram {
    /// Samples below 1e-16: exact zeros (clamped nodes) and rounding.
    pub below: u64,
    /// Samples of 1e8 and more.
    pub above: u64,
    /// Number of the first bin, counted from 1 in steps of 10^(1/32).
    pub first_bin: i32,
    /// Samples per bin, from the first to the last bin that has any.
    pub counts: Vec<u64>,
}

impl LogHistogram {
    /// Counts the samples; NaN and negative values count as `below`, as zero does.
    pub fn from_samples(samples: &[f64]) -> Self {
        let lowest = LOWEST_DECADE * BINS_PER_DECADE;
        let mut all = vec![0; (DECADES * BINS_PER_DECADE) as usize];
        let (mut below, mut above) = (0, 0);
        for &sample in samples {
            // −∞ for zero, NaN for negative samples.
            let bin = (sample.log10() * f64::from(BINS_PER_DECADE)).floor();
            if bin.is_nan() || bin < f64::from(lowest) {
                below += 1;
            } else if bin >= f64::from(HIGHEST_DECADE * BINS_PER_DECADE) {
                above += 1;
            } else {
                all[(bin as i32 - lowest) as usize] += 1;
            }
        }
        let filled = |&(_, count): &(usize, &u64)| *count > 0;
        let first = all.iter().enumerate().find(filled).map_or(0, |(i, _)| i);
        let last = all.iter().rposition(|&count| count > 0);
        Self {
            below,
            above,
            first_bin: lowest + first as i32,
            counts: last.map_or_else(Vec::new, |last| all[first..=last].to_vec()),
        }
    }

    /// Number of samples inside the bins.
    pub fn inside(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Share of the samples that the logarithmic axis cannot show, from 0 to 1.
    pub fn share_outside(&self) -> f64 {
        let outside = (self.below + self.above) as f64;
        outside / (outside + self.inside() as f64).max(1.0)
    }

    /// Gaussian kernel density over log₁₀ of the error: points (log₁₀ x, density per
    /// decade) whose integral is 1. Bandwidth by Silverman's rule (1986, eq. 3.31).
    /// Empty if no sample lies inside the bins.
    pub fn density(&self) -> Vec<(f64, f64)> {
        let total = self.inside() as f64;
        if total == 0.0 {
            return Vec::new();
        }
        let bandwidth = self.bandwidth_bins();
        let reach = (KERNEL_REACH * bandwidth).ceil() as i64;
        let bins = self.counts.len() as i64;
        let scale = 1.0 / (total * bandwidth * (2.0 * std::f64::consts::PI).sqrt());
        (-reach..bins + reach)
            .map(|at| {
                let near = (at - reach).max(0)..(at + reach + 1).min(bins);
                let sum: f64 = near
                    .map(|bin| {
                        let distance = (bin - at) as f64 / bandwidth;
                        self.counts[bin as usize] as f64 * (-0.5 * distance * distance).exp()
                    })
                    .sum();
                let centre = f64::from(self.first_bin) + at as f64 + 0.5;
                let per_decade = f64::from(BINS_PER_DECADE);
                (centre / per_decade, sum * scale * per_decade)
            })
            .collect()
    }

    /// 0.9 min(σ, IQR/1.34) n^(-1/5) in bins.
    fn bandwidth_bins(&self) -> f64 {
        let total = self.inside() as f64;
        let moment = |f: &dyn Fn(f64) -> f64| -> f64 {
            let terms = self.counts.iter().enumerate();
            terms.map(|(i, &n)| n as f64 * f(i as f64)).sum::<f64>() / total
        };
        let mean = moment(&|x| x);
        let deviation = moment(&|x| (x - mean) * (x - mean)).sqrt();
        let range = (self.bin_of_quantile(0.75) - self.bin_of_quantile(0.25)) / 1.34;
        let spread = if range > 0.0 { deviation.min(range) } else { deviation };
        (0.9 * spread * total.powf(-0.2)).max(MIN_BANDWIDTH_BINS)
    }

    fn bin_of_quantile(&self, probability: f64) -> f64 {
        let wanted = probability * self.inside() as f64;
        let mut sum = 0.0;
        let at = self.counts.iter().position(|&count| {
            sum += count as f64;
            sum >= wanted
        });
        at.unwrap_or(0) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spaced quantiles of a logistic distribution of log₁₀ x.
    fn log_logistic(count: usize, centre: f64, scale: f64) -> Vec<f64> {
        (0..count)
            .map(|i| (i as f64 + 0.5) / count as f64)
            .map(|p| 10f64.powf(centre + scale * (p / (1.0 - p)).ln()))
            .collect()
    }

    fn integral(points: &[(f64, f64)]) -> f64 {
        let trapezoid = |pair: &[(f64, f64)]| (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1);
        0.5 * points.windows(2).map(trapezoid).sum::<f64>()
    }

    #[test]
    fn density_integrates_to_one() {
        let cases = [
            vec![1e-3],
            vec![0.0, 2e-3, 2e-3],
            log_logistic(100, -2.0, 0.2),
            log_logistic(50_000, -3.0, 0.3),
        ];
        for samples in cases {
            let density = LogHistogram::from_samples(&samples).density();
            // Cut tails of the kernel (6e-5) and the trapezoidal rule on bins.
            assert!((integral(&density) - 1.0).abs() < 2e-4);
        }
    }

    #[test]
    fn density_peaks_where_the_samples_are() {
        let density = LogHistogram::from_samples(&log_logistic(20_000, -2.5, 0.25)).density();
        let peak = density.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        // Half a bin, and the smoothing of the kernel (h²f″/2: 2.4 %).
        assert!((peak.0 + 2.5).abs() < 0.5 / 32.0 + 1e-9, "{peak:?}");
        assert!((peak.1 * 4.0 * 0.25 - 1.0).abs() < 0.03, "{peak:?}");
    }

    #[test]
    fn every_sample_is_counted_once() {
        let samples = [0.0, 1e-20, 1e-3, 1.1e-3, 1.0, 1e8, 1e300];
        let histogram = LogHistogram::from_samples(&samples);
        assert_eq!((histogram.below, histogram.above), (2, 2));
        assert_eq!(histogram.inside(), 3);
        assert_eq!(histogram.first_bin, -96);
        assert_eq!(histogram.counts.len(), 97);
        assert!(LogHistogram::from_samples(&[0.0]).density().is_empty());
    }
}
