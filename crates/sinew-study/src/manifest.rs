//! What a result was made with.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::process::Command;

/// Revision, crate versions and machine of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The command line.
    pub command: String,
    /// Seed that all seeds of the run derive from.
    pub seed: u64,
    /// Git revision of the sources, `-dirty` appended when they were changed; "unknown" outside a checkout.
    pub revision: String,
    /// Versions of this workspace and of the packages its numbers depend on.
    pub versions: BTreeMap<String, String>,
    /// Processor and operating system.
    pub machine: String,
    /// Worker threads.
    pub threads: usize,
}

impl Manifest {
    /// Reads the manifest of the running program.
    pub fn of_this_run(seed: u64) -> Self {
        Self {
            command: std::iter::once("sinew-study".to_string())
                .chain(std::env::args().skip(1))
                .collect::<Vec<_>>()
                .join(" "),
            seed,
            revision: revision(),
            versions: locked_versions(include_str!("../../../Cargo.lock")),
            machine: machine(),
            threads: rayon::current_num_threads(),
        }
    }
}

fn revision() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git")
            .args(arguments)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    match (git(&["rev-parse", "--short=12", "HEAD"]), git(&["status", "--porcelain"])) {
        (Some(revision), Some(changes)) if changes.is_empty() => revision,
        (Some(revision), _) => format!("{revision}-dirty"),
        (None, _) => "unknown".to_string(),
    }
}

/// Versions of the packages that numbers depend on, from the lock file the program was built with.
fn locked_versions(lock: &str) -> BTreeMap<String, String> {
    const NUMERIC: &[&str] = &[
        "sinew-study",
        "sinew-gp",
        "burn",
        "burn-flex",
        "faer",
        "kiddo",
        "linfa-clustering",
        "nalgebra",
        "rand_chacha",
    ];
    let mut versions = BTreeMap::new();
    let mut name = "";
    for line in lock.lines() {
        let quoted = |key: &str| line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"');
        if let Some(found) = quoted("name") {
            name = found;
        } else if let Some(version) = quoted("version")
            && NUMERIC.contains(&name)
        {
            versions.insert(name.to_string(), version.to_string());
        }
    }
    versions
}

fn machine() -> String {
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "{}, {cores} cores, {} {}",
        processor.as_deref().unwrap_or("unknown processor"),
        std::env::consts::OS,
        std::env::consts::ARCH
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifest_names_the_pinned_tensor_library() {
        let manifest = Manifest::of_this_run(1);
        assert_eq!(manifest.versions["burn"], "0.22.1");
        assert!(manifest.versions.contains_key("faer"));
        assert!(!manifest.revision.is_empty() && manifest.threads >= 1);
    }
}
