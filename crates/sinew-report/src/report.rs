//! The report as a whole, and its files.

use crate::{Cell, Figure, Panel, Provenance, Surfaces, Table};
use serde::{Deserialize, Serialize};

/// Version of `report.json`, raised with any change of its fields (`docs/report-schema.md`).
pub const SCHEMA: u32 = 3;

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
    /// Drawings.
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
        let panels = charts.into_iter().map(Panel::Chart).collect();
        Self::Figure(Figure { title: title.into(), caption: caption.into(), panels })
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

    /// The section of a name.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.name == name)
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
