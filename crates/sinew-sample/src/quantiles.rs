//! Quantiles of samples.

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
