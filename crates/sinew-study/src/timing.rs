//! Runs and their wall times over interruptions.

use anyhow::{Context, Result, ensure};
use serde::{Serialize, de::DeserializeOwned};
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
    /// Begins a run in `out`, emptied of the `folders` of an earlier one, and keeps what it was begun with there; or goes on
    /// with that run where its time was last saved. What the run in the folder was begun with.
    ///
    /// # Errors
    /// Folders that are not of an earlier run, a run to be resumed that does not exist, files that cannot be read or written.
    pub fn begin<T: Serialize + DeserializeOwned>(
        out: &Path,
        folders: &[String],
        resume: bool,
        beginning: T,
    ) -> Result<(Self, T)> {
        let (config, file) = (out.join("config.json"), out.join("elapsed.json"));
        let begin = |earlier| Self { earlier, start: Instant::now(), file: file.clone() };
        if resume {
            let stored = store::read_json(&config)?.with_context(|| {
                let out = out.display();
                format!("there is no run to resume in {out}; start it without --resume")
            })?;
            return Ok((begin(store::read_json(&file)?.unwrap_or_default()), stored));
        }
        for old in folders.iter().map(|name| out.join(name)).filter(|old| old.exists()) {
            let old = old.as_path();
            ensure!(
                config.exists(),
                "{} exists but is not of an earlier run; choose another --out",
                old.display()
            );
            std::fs::remove_dir_all(old)
                .with_context(|| format!("{} could not be emptied", old.display()))?;
        }
        store::write_json(&config, &beginning)?;
        Ok((begin(Duration::ZERO), beginning))
    }

    /// Wall time so far, kept for a run that resumes this one.
    pub fn save(&self) -> Result<Duration> {
        let wall = self.earlier + self.start.elapsed();
        store::write_json(&self.file, &wall)?;
        Ok(wall)
    }
}
