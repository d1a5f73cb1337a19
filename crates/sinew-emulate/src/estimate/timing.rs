//! Wall times of calls, without those that one slow call spoils.

use std::time::Instant;

/// Median wall time of `repeats` calls after one that warms up \[s\].
///
/// # Errors
/// The first error of a call.
pub(crate) fn median_seconds<T, E>(
    repeats: usize,
    mut call: impl FnMut() -> Result<T, E>,
) -> Result<f64, E> {
    call()?;
    let mut seconds = Vec::with_capacity(repeats);
    for _ in 0..repeats.max(1) {
        let start = Instant::now();
        std::hint::black_box(call()?);
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(median(&seconds))
}

/// The upper median; NaN of nothing.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Does some work and adds its wall time to `total` \[s\].
pub fn timed<T>(total: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *total += start.elapsed().as_secs_f64();
    done
}
