//! Patient files: a case whose mesh is an image, with phases, data and settings of a calibration in the same TOML.
//!
//! Every key is described in `docs/calibration.md`.

mod measured;
mod prepare;
mod prepared;
mod synthesise;
mod tables;

pub use prepared::{Prepared, Reported};

use crate::case::{Case, CaseError};
use std::path::Path;
use tables::Tables;

/// A case file with what was measured of the body.
///
/// ```
/// let file = sinew::PatientFile::parse(
///     r#"
///     law = { name = "neo-hookean-isochoric", bulk_modulus = 100.0 }
///     loads = [{ pressure = "p", facets = "endo" }]
///     supports = [{ clamped = "base" }]
///     mesh.ellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [1, 8, 4] }
///     parameters = { mu = [5.0, 50.0], p = { range = [0.0, 30.0], unit = "mmHg", sampling = "linear" } }
///     phases = { image = { p = "8 mmHg" }, late = { p = "16 mmHg" } }
///     data = [{ volume = "endo", phase = "late", value = 40.0, unit = "mL", sd = "3 %" }]
///     "#,
///     "patient.toml",
/// )?;
/// let patient = file.prepare()?;
/// assert_eq!(patient.problem.unknowns[0].name, "mu");
/// assert_eq!(patient.problem.data[0].name, "volume of endo at late");
/// # Ok::<(), sinew::CaseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PatientFile {
    /// The body in the image.
    pub case: Case,
    tables: Tables,
    /// Whether values of data are still to be made.
    blank: bool,
}

impl PatientFile {
    /// Reads a patient file.
    ///
    /// # Errors
    /// A file that cannot be read, a case that makes no sense, or phases, data and settings that are misspelt.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        Self::of(Case::read(path)?)
    }

    /// Reads a patient from text; `file` names it in errors.
    ///
    /// # Errors
    /// As [`PatientFile::read`].
    pub fn parse(text: &str, file: &str) -> Result<Self, CaseError> {
        Self::of(Case::parse(text, file)?)
    }

    /// The patient of a case whose text has phases and data.
    ///
    /// # Errors
    /// Phases, data and settings that are misspelt.
    pub fn of(case: Case) -> Result<Self, CaseError> {
        let tables: Tables =
            toml::from_str(case.text()).map_err(|error| case.source.syntax(&error))?;
        let place = |(key, reason)| case.source.error(&["calibration", key], reason);
        tables.calibration.check().map_err(place)?;
        Ok(Self { case, tables, blank: false })
    }

    /// Keys and values of the file in one form, whatever its comments, its spacing and the order of its tables.
    ///
    /// # Errors
    /// Never, but for a case that came from no text.
    pub fn settings(&self) -> Result<String, CaseError> {
        let source = &self.case.source;
        let table: toml::Table =
            toml::from_str(self.case.text()).map_err(|error| source.syntax(&error))?;
        // Names in an ascending order.
        Ok(table.to_string())
    }

    /// Settings of the calibration.
    pub fn options(&self) -> sinew_calibrate::CalibrateOptions {
        self.tables.calibration.options()
    }
}
