//! Wall times that one slow call does not spoil.

use std::time::Instant;

/// Median wall time of `repeats` calls after one that warms up \[s\].
///
/// # Errors
/// The first error of a call.
pub fn median_seconds<T, E>(
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
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[seconds.len() / 2])
}

/// Does some work and adds its wall time to `total` \[s\].
pub fn timed<T>(total: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *total += start.elapsed().as_secs_f64();
    done
}
