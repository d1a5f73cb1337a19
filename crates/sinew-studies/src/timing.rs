//! Runs that are begun or go on; CPU time and memory of this process.

use anyhow::{Context, Result, ensure};
use serde::{Serialize, de::DeserializeOwned};
use sinew_emulate::store;
use std::path::{Path, PathBuf};

/// Begins a run in `out`, emptied of the `folders` of an earlier one, and keeps what it was begun with there; or returns what the run
/// that goes on was begun with.
pub(crate) fn begin_in<T: Serialize + DeserializeOwned>(
    out: &Path,
    folders: &[String],
    resume: bool,
    beginning: &T,
) -> Result<Option<T>> {
    let file = out.join("config.json");
    ensure!(
        !resume || file.exists(),
        "there is no run to resume in {}; start it without --resume",
        out.display()
    );
    let folders: Vec<_> = folders.iter().map(|name| out.join(name)).collect();
    begin(&file, &folders, resume, beginning)
}

/// Begins a run anew, in `folders` emptied of an earlier one, and keeps in `file` what it was begun with; or returns what the run
/// that goes on was begun with.
pub(crate) fn begin<T: Serialize + DeserializeOwned>(
    file: &Path,
    folders: &[PathBuf],
    resume: bool,
    beginning: &T,
) -> Result<Option<T>> {
    // What a run replaces may be of an earlier form.
    if resume && let Some(stored) = store::read_json(file)? {
        return Ok(Some(stored));
    }
    for old in folders.iter().map(PathBuf::as_path).filter(|old| old.exists()) {
        ensure!(
            file.exists(),
            "{} exists but is not of an earlier run; choose another --out",
            old.display()
        );
        std::fs::remove_dir_all(old)
            .with_context(|| format!("{} could not be emptied", old.display()))?;
    }
    store::write_json(file, beginning)?;
    Ok(None)
}

/// CPU time of this process on all its threads \[s\]; NaN where the system does not tell.
pub fn cpu_seconds() -> f64 {
    spent(OWN)
}

/// CPU time of the processes that this one started and that have ended \[s\]; NaN where the system does not tell.
pub(crate) fn cpu_seconds_of_children() -> f64 {
    spent(OWN + 2)
}

/// CPU time of one call \[s\], on all threads, over as many calls as take half a second: on a busy machine wall time is that of others, too.
pub(crate) fn cpu_seconds_of<T>(mut call: impl FnMut() -> Result<T>) -> Result<f64> {
    /// Long beside a tick of the clock \[s\].
    const ENOUGH: f64 = 0.5;
    let (start, mut calls) = (cpu_seconds(), 0.0);
    loop {
        call()?;
        calls += 1.0;
        let spent = cpu_seconds() - start;
        if spent.is_nan() || spent >= ENOUGH {
            return Ok(spent / calls);
        }
    }
}

/// Place of user time among the fields of `/proc/self/stat` after the name, which may hold spaces; system time follows.
const OWN: usize = 11;

fn spent(first: usize) -> f64 {
    /// Clock ticks in a second, which Linux fixes for programs.
    const TICKS: f64 = 100.0;
    let status = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = status.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: Vec<f64> =
        fields.skip(first).take(2).filter_map(|field| field.parse().ok()).collect();
    if ticks.len() == 2 { (ticks[0] + ticks[1]) / TICKS } else { f64::NAN }
}

/// Largest resident memory of this process so far \[kB\], where the system tells it.
pub(crate) fn peak_kb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}
