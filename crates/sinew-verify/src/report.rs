//! What a run leaves: `verify.json` for programs and `verify.html` for people.

use crate::case::Effort;
use crate::format::utc;
use crate::html;
use crate::run::Outcome;
use anyhow::{Context, Result};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// Version of `verify.json`, raised with any change of its fields.
pub const SCHEMA: u32 = 1;

/// A run of the benchmarks with what it was made with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Version of these fields.
    pub schema: u32,
    /// The command line.
    pub command: String,
    /// Version of the workspace.
    pub version: String,
    /// Git revision of the sources, `-dirty` appended when they were changed; "unknown" outside a checkout.
    pub revision: String,
    /// Processor and operating system.
    pub machine: String,
    /// Cores that the program may use.
    pub cores: usize,
    /// When the run ended.
    pub finished: String,
    /// Coarse meshes only, or everything.
    pub effort: Effort,
    /// Whether every case passed.
    pub passed: bool,
    /// The cases.
    pub cases: Vec<Outcome>,
}

impl Report {
    /// The report of a run that ends now.
    pub fn of_this_run(effort: Effort, cases: Vec<Outcome>) -> Self {
        let arguments = std::env::args().skip(1);
        Self {
            schema: SCHEMA,
            command: ["cargo xtask verify".to_string()]
                .into_iter()
                .chain(arguments)
                .collect::<Vec<_>>()
                .join(" "),
            version: env!("CARGO_PKG_VERSION").into(),
            revision: revision(),
            machine: machine(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            finished: utc(SystemTime::now()),
            effort,
            passed: cases.iter().all(Outcome::passes),
            cases,
        }
    }

    /// Writes both files into a folder, which is made if need be; gives the path of the page.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        let put = |name: &str, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
            Ok::<_, anyhow::Error>(path)
        };
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        put("verify.json", &(serde_json::to_string_pretty(self)? + "\n"))?;
        put("verify.html", &html::render(self))
    }
}

fn revision() -> String {
    let git = |arguments: &[&str]| {
        let folder = env!("CARGO_MANIFEST_DIR");
        let output = Command::new("git").args(arguments).current_dir(folder).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    match (git(&["rev-parse", "--short=12", "HEAD"]), git(&["status", "--porcelain"])) {
        (Some(revision), Some(changes)) if changes.is_empty() => revision,
        (Some(revision), _) => format!("{revision}-dirty"),
        (None, _) => "unknown".to_string(),
    }
}

fn machine() -> String {
    let processor = fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let processor = processor.as_deref().unwrap_or("unknown processor");
    format!("{processor}, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{run, tests::Fake};

    #[test]
    fn both_files_hold_errors_times_and_bands() {
        let outcome = run(&Fake { error: 0.01, breaks: None }, Effort::Full, &mut |_| ());
        let report = Report::of_this_run(Effort::Full, vec![outcome]);
        let folder = tempfile::tempdir().unwrap();
        let page = report.write(&folder.path().join("new")).unwrap();
        let page = fs::read_to_string(page).unwrap();
        let json = fs::read_to_string(folder.path().join("new/verify.json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["passed"], true);
        assert!(json["cores"].as_u64().unwrap() >= 1);
        let row = &json["cases"][0]["rows"][1];
        assert_eq!((&row["formulation"], &row["unknowns"]), (&"p2".into(), &1000.into()));
        assert!((row["error"].as_f64().unwrap() - 0.01).abs() < 1e-12);
        assert_eq!(row["band"]["most"], 0.1);
        assert_eq!(row["seconds"], 0.1);
        assert!(page.contains("A made-up &lt;case&gt;") && !page.contains("A made-up <case>"));
        // Error against unknowns and error against seconds, with two markers each and one in the legend.
        assert_eq!(page.matches("<svg class=\"chart\"").count(), 2);
        assert_eq!(page.matches("class=\"dot ").count(), 5);
        assert!(!page.contains("<script") && !page.contains("http"));
    }
}
