//! Patient files: a case whose mesh is an image, with phases, data and settings of a calibration in the same TOML.
//!
//! Every key is described in `docs/calibration.md`.

mod measured;
mod prepare;
mod prepared;
mod tables;

use crate::case::{Case, CaseError};
pub use prepared::Prepared;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_calibrate::{Forward, Prior};
use sinew_energy::{Parameter, Unit};
use sinew_sample::{split_seed, standard_normals};
use std::path::Path;
use tables::{Quantity, Tables};
use toml::{Table, Value};

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

    /// Whether the file has data.
    pub fn has_data(&self) -> bool {
        !self.tables.data.is_empty()
    }

    /// Settings of the calibration.
    pub fn options(&self) -> sinew_calibrate::CalibrateOptions {
        self.tables.calibration.options()
    }

    /// The unknown parameters that a θ of [`PatientFile::synthesise`] lists: all but factors of pressures, which are 1.
    ///
    /// # Errors
    /// As [`PatientFile::prepare`].
    pub fn parameters(&self) -> Result<Vec<Parameter>, CaseError> {
        let prepared = Self { blank: true, ..self.clone() }.prepare()?;
        let own = |name: &str| prepared.body.parameters.iter().any(|p| p.name == name);
        let parameter = |unknown: &sinew_calibrate::Unknown| {
            let unit = match unknown.unit.as_str() {
                "" => Unit::from("1"),
                name => Unit::sized(name, unknown.size),
            };
            let [low, high] = unknown.prior.range();
            Parameter::log(&unknown.name, unit, low..=high)
        };
        let unknowns = prepared.problem.unknowns.iter().filter(|unknown| own(&unknown.name));
        Ok(unknowns.map(parameter).collect())
    }

    /// The patient file with values that the solver gives at θ, with noise of the stated standard deviations; the logarithm of a share's
    /// noise is normal. Values that the file has are replaced.
    ///
    /// # Errors
    /// As [`PatientFile::prepare`], and a θ at which the solver has no answer.
    pub fn synthesise(&self, theta: &[f64], seed: u64) -> Result<String, CaseError> {
        let file = Self { blank: true, ..self.clone() };
        let prepared = file.prepare()?;
        let refuse = |reason: String| self.case.source.error(&[], reason);
        // Factors of pressures follow the parameters of the body.
        let mut all = theta.to_vec();
        let median = |prior: &Prior| prior.logarithm(0.0)[0].exp();
        all.extend(prepared.problem.unknowns.iter().skip(theta.len()).map(|u| median(&u.prior)));
        let patient = prepared.patient().map_err(refuse)?;
        let seen = patient.observe(&all, false).map_err(|error| refuse(error.to_string()))?;
        let mut random = ChaCha8Rng::seed_from_u64(split_seed(seed, NOISE));
        let mut root: Table =
            self.case.text().parse().map_err(|_| refuse("the file cannot be read again".into()))?;
        let entries = root.get_mut("data").and_then(Value::as_array_mut);
        let mut place = 0;
        for (value, entry) in entries.into_iter().flatten().zip(&self.tables.data) {
            let Some(written) = value.as_table_mut() else { continue };
            let of_all = entry.strain.is_some() && entry.segment.is_none();
            let count = match (&prepared.segments, of_all) {
                (Some(segments), true) => segments.names().len(),
                _ => 1,
            };
            let mut values = Vec::with_capacity(count);
            for exact in &seen.values[place..place + count] {
                let exact = exact / prepared.size_of(place);
                let z = standard_normals(1, &mut random)[0];
                values.push(match &entry.sd {
                    Some(Quantity::Number(deviation)) => exact + z * deviation,
                    Some(Quantity::Text(text)) => {
                        let share = text.trim().trim_end_matches('%').trim().parse::<f64>();
                        exact * (0.01 * z * share.unwrap_or(0.0)).exp()
                    }
                    None => exact,
                });
            }
            place += count;
            written.remove("value");
            written.remove("values");
            let (key, value) = match of_all {
                true => ("values", Value::from(values)),
                false => ("value", Value::from(values[0])),
            };
            written.insert(key.into(), value);
        }
        toml::to_string(&root).map_err(|error| refuse(error.to_string()))
    }
}

/// Seed stream of the noise.
const NOISE: u64 = 0x4e4f;
