//! A report as a page and as a file, and back.

use crate::report::{Block, Report, SCHEMA};
use crate::{ReportError, render};
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};

impl Report {
    /// The page: one file without fonts or links to anything outside, with a script only where a surface is to be turned. A function of
    /// the report alone.
    pub fn to_html(&self) -> String {
        render::page(self).into_string()
    }

    /// The text of `report.json`.
    ///
    /// # Errors
    /// [`ReportError::Json`] if it cannot be written.
    pub fn to_json(&self) -> Result<String, ReportError> {
        Ok(serde_json::to_string(self)? + "\n")
    }

    /// A report from the text of `report.json`.
    ///
    /// # Errors
    /// [`ReportError::Schema`] for another version, [`ReportError::Json`] for anything that is not a report, and whatever
    /// keeps a row or a surface from being made.
    pub fn from_json(text: &str) -> Result<Self, ReportError> {
        // The schema first, so that another version is named as such and not as a missing field.
        #[derive(Deserialize)]
        struct Version {
            schema: u64,
        }
        let found = serde_json::from_str::<Version>(text)?.schema;
        if found != u64::from(SCHEMA) {
            return Err(ReportError::Schema(found, SCHEMA));
        }
        let report: Self = serde_json::from_str(text)?;
        for block in report.sections.iter().flat_map(|section| &section.blocks) {
            match block {
                Block::Table(table) => table.rows.iter().try_for_each(|row| table.check(row))?,
                Block::Surfaces(surfaces) => surfaces.check()?,
                _ => (),
            }
        }
        Ok(report)
    }

    /// Reads `report.json`.
    ///
    /// # Errors
    /// [`ReportError::Io`] if the file cannot be read, otherwise as [`Report::from_json`].
    pub fn read(path: &Path) -> Result<Self, ReportError> {
        Self::from_json(&fs::read_to_string(path).map_err(ReportError::io(path))?)
    }

    /// Writes `report.json` and `report.html` into a folder, which is made if need be; the path of the page.
    ///
    /// # Errors
    /// [`ReportError::Io`] with the path.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ReportError> {
        fs::create_dir_all(folder).map_err(ReportError::io(folder))?;
        let put = |name: &str, text: String| {
            let path = folder.join(name);
            fs::write(&path, text).map_err(ReportError::io(&path))?;
            Ok(path)
        };
        put("report.json", self.to_json()?)?;
        put("report.html", self.to_html())
    }
}
