//! The result of a study: what was compared, with which error and at which cost.
//!
//! Plain data in, files out. A [`Report`] holds the numbers; [`write_all`] turns it
//! into `report.json` (documented in `docs/report-schema.md`), `samples.csv` and a
//! self-contained `report.html` with the tables and plots.
//!
//! A method enters a report as a [`MethodRow`], and there is no way to make one
//! without both its errors and its times.
//!
//! ```
//! use sinew_study::report::{ErrorSamples, Method, MethodRow, Times};
//!
//! // Errors of one method over the test set: every node, element and test case.
//! let errors = ErrorSamples {
//!     err_u_mm: vec![0.0, 4e-3, 6e-3, 9e-3],
//!     err_f_pct: vec![0.10, 0.16, 0.22],
//!     err_i1_pct: vec![0.06, 0.09, 0.13],
//!     err_pi_pct: vec![1.2, 1.7],
//! };
//! let times = Times {
//!     prepare_s: 2.1,
//!     train_s: 140.0,
//!     steps: 1000,
//!     predict_full_s: 1.6e-2,
//!     predict_decoder_s: 1.9e-3,
//!     predict_batch_per_theta_s: 4.0e-4,
//! };
//! let row = MethodRow::from_samples(
//!     Method::Dd,
//!     "fit to 200 finite-element solutions",
//!     "our finite-element solution",
//!     errors,
//!     times,
//! )?;
//! assert_eq!(row.errors().err_u_mm.q50, 5e-3);
//!
//! // A time that is not a number is refused, and the message names the field.
//! let broken = Times { train_s: f64::NAN, ..times };
//! let refused = MethodRow::new(
//!     Method::Dd, "as above", "as above", *row.errors(), row.histograms().clone(), broken,
//! );
//! assert!(refused.unwrap_err().to_string().contains("dd.times.train_s"));
//! # Ok::<(), sinew_study::report::ReportError>(())
//! ```

pub(crate) mod axis;
pub(crate) mod chart;
pub(crate) mod colours;
mod error;
pub(crate) mod format;
mod histogram;
mod html;
pub(crate) mod json;
mod labels;
mod metric;
pub(crate) mod page;
mod plots;
mod quantiles;
mod row;
mod samples;
mod scene;
mod shapes;
mod summary;
mod surface;
mod tables;
mod training;

#[cfg(test)]
mod tests;

pub use error::ReportError;
pub use format::utc_timestamp;
pub use histogram::LogHistogram;
pub use html::render as render_html;
pub use json::{SCHEMA, read_json, to_json};
pub use metric::{Method, Metric, PerMetric};
pub use quantiles::{Quantiles, quantiles};
pub use row::{ErrorSamples, Errors, Histograms, MethodRow, Times};
pub use samples::{SampleRow, SceneSamples, Spread, write_samples};
pub use scene::{DisplacementScale, MeshCounts, Report, SceneReport, ThesisReference, ThetaRange};
pub use surface::{SurfaceCase, SurfaceCases};
pub use training::{CurvePoint, EnergyPoint, TrainingHistory};

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `report.json`, `report.html` and `samples.csv` into `folder`, which is
/// created if it does not exist.
///
/// # Errors
/// [`ReportError::Io`] with the path, or what [`write_samples`] refuses.
pub fn write_all(
    folder: &Path,
    report: &Report,
    samples: &[SceneSamples],
) -> Result<(), ReportError> {
    fs::create_dir_all(folder).map_err(|source| ReportError::io(folder, source))?;
    write_file(&folder.join("report.json"), to_json(report)?.as_bytes())?;
    write_file(&folder.join("report.html"), render_html(report).as_bytes())?;
    let path = folder.join("samples.csv");
    let file = File::create(&path).map_err(|source| ReportError::io(&path, source))?;
    let mut file = BufWriter::new(file);
    write_samples(samples, &mut file)?;
    file.flush().map_err(|source| ReportError::io(&path, source))
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    fs::write(path, bytes).map_err(|source| ReportError::io(path, source))
}
