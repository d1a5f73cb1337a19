//! Wall times: of calls, without those that one slow call spoils, and of runs over their interruptions.

use crate::store;
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Wall time of a run, over its interruptions.
pub struct WallClock {
    earlier: Duration,
    start: Instant,
    file: PathBuf,
}

impl WallClock {
    /// Starts at zero; kept in `folder`.
    pub fn start(folder: &Path) -> Self {
        Self::from(Duration::ZERO, folder)
    }

    /// Goes on where that of an earlier run in `folder` was last saved.
    ///
    /// # Errors
    /// A file that cannot be read, by path.
    pub fn resume(folder: &Path) -> Result<Self> {
        let earlier = store::read_json(&Self::file(folder))?.unwrap_or_default();
        Ok(Self::from(earlier, folder))
    }

    fn from(earlier: Duration, folder: &Path) -> Self {
        Self { earlier, start: Instant::now(), file: Self::file(folder) }
    }

    fn file(folder: &Path) -> PathBuf {
        folder.join("elapsed.json")
    }

    /// Wall time so far, kept for a run that resumes this one.
    ///
    /// # Errors
    /// A file that cannot be written, by path.
    pub fn save(&self) -> Result<Duration> {
        let wall = self.earlier + self.start.elapsed();
        store::write_json(&self.file, &wall)?;
        Ok(wall)
    }
}

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
