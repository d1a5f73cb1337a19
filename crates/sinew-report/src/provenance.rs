//! Provenance of a result: versions, machine and command.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

/// Versions, machine and command of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The command line.
    pub command: String,
    /// When the run ended, UTC, as `2026-03-01 14:05:09Z`.
    pub finished: String,
    /// Wall time of the whole run \[s\].
    pub wall_s: f64,
    /// Worker threads.
    pub threads: usize,
    /// Seed that all random choices derive from; `None` if nothing is random.
    pub seed: Option<u64>,
    /// Git revision of the sources, `-dirty` appended when they were changed, other than in `docs`; "unknown" outside a checkout.
    pub revision: String,
    /// Processor, cores and operating system.
    pub machine: String,
    /// Versions by name.
    pub versions: BTreeMap<String, String>,
    /// The configuration as used, in its own text format; may be empty.
    pub config: String,
}

impl Provenance {
    /// Provenance of the running program; `program` is its command. `source` is a folder of its sources, such as
    /// `env!("CARGO_MANIFEST_DIR")`. Seed, versions and configuration are left to the caller.
    pub fn of_this_run(program: &str, source: impl AsRef<Path>) -> Self {
        let arguments = std::env::args().skip(1);
        let command = std::iter::once(program.to_string()).chain(arguments).collect::<Vec<_>>();
        Self {
            command: command.join(" "),
            finished: now(),
            threads: cores(),
            revision: revision(source.as_ref()),
            machine: machine(),
            ..Self::default()
        }
    }

    /// Provenance at the end of the run, after `wall_s` seconds.
    pub fn finished(self, wall_s: f64) -> Self {
        Self { finished: now(), wall_s, ..self }
    }
}

fn now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace('T', " ")
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn revision(source: &Path) -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(source).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    let Some(revision) = git(&["rev-parse", "--short=12", "HEAD"]) else { return "unknown".into() };
    // A run that writes its results into a document leaves the sources as they were.
    let changes = git(&["status", "--porcelain", "--", ":/", ":(top,exclude)docs"]);
    if changes.is_some_and(|changes| changes.is_empty()) { revision } else { revision + "-dirty" }
}

fn machine() -> String {
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let processor = processor.as_deref().unwrap_or("unknown processor");
    let (system, kind) = (std::env::consts::OS, std::env::consts::ARCH);
    format!("{processor}, {} cores, {system} {kind}", cores())
}
