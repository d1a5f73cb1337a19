//! The report as a whole, and its provenance.

use crate::{Cell, Figure, Surfaces, Table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

/// Version of `report.json`, raised with any change of its fields (`docs/report-schema.md`).
pub const SCHEMA: u32 = 4;

/// A result: what it was made with, and sections of text, tables and drawings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of the file, [`SCHEMA`].
    pub schema: u32,
    /// Title.
    pub title: String,
    /// Subject, in a line.
    pub about: String,
    /// The result in a sentence; may be empty.
    pub headline: String,
    /// Provenance.
    pub provenance: Provenance,
    /// Notes beside the numbers.
    pub notes: Vec<String>,
    /// The sections.
    pub sections: Vec<Section>,
    /// Terms with their definitions, beside those of the columns.
    pub definitions: Vec<(String, String)>,
}

/// A part of the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Short name, unique on the page.
    pub name: String,
    /// Title.
    pub title: String,
    /// Sections, from top to bottom.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// Sentences.
    List(Vec<String>),
    /// Names with values.
    Facts(Vec<(String, String)>),
    /// Errors beside times.
    Table(Table),
    /// Anything else in rows, folded.
    Listing {
        /// Title.
        title: String,
        /// Heads of the columns.
        head: Vec<String>,
        /// Cells, row by row.
        rows: Vec<Vec<Cell>>,
    },
    /// Charts.
    Figure(Figure),
    /// Surfaces coloured by a value.
    Surfaces(Surfaces),
}

impl Block {
    /// A figure of charts.
    pub fn charts(
        title: impl Into<String>,
        caption: impl Into<String>,
        charts: impl IntoIterator<Item = crate::Chart>,
    ) -> Self {
        let (title, caption) = (title.into(), caption.into());
        Self::Figure(Figure { title, caption, panels: charts.into_iter().collect() })
    }

    /// A listing.
    pub fn listing<H: Into<String>>(
        title: impl Into<String>,
        head: impl IntoIterator<Item = H>,
        rows: impl IntoIterator<Item = Vec<Cell>>,
    ) -> Self {
        let head = head.into_iter().map(Into::into).collect();
        Self::Listing { title: title.into(), head, rows: rows.into_iter().collect() }
    }
}

impl Section {
    /// All tables.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks
            .iter()
            .filter_map(|block| if let Block::Table(t) = block { Some(t) } else { None })
    }
}

impl Report {
    /// Without sections.
    pub fn new(title: impl Into<String>, about: impl Into<String>, provenance: Provenance) -> Self {
        let (title, about) = (title.into(), about.into());
        Self { schema: SCHEMA, title, about, provenance, ..Self::default() }
    }

    /// All tables of all sections.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.sections.iter().flat_map(Section::tables)
    }

    /// Number of errors that are judged, and of those that meet what they are held against.
    pub fn verdicts(&self) -> [usize; 2] {
        let all = || self.tables().flat_map(Table::verdicts);
        [all().count(), all().filter(|found| found.3.met).count()]
    }
}

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
