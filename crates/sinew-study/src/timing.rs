//! Wall times of runs over their interruptions.

use anyhow::Result;
use sinew_emulate::store;
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
