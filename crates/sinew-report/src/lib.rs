//! One report for every result: errors beside times, charts and provenance.
//!
//! A [`Report`] is plain data in sections. It is written as `report.json` (documented in `docs/report-schema.md`) and as
//! `report.html`, one file without fonts or links that is a function of the data alone, in light and dark. Its only script draws
//! surfaces of bodies to be turned ([`Surfaces`]), and pages of emulators ([`Viewer`]).
//! Methods, errors, times and units are the caller's: none is named here.
//!
//! ```
//! use sinew_report::{Block, Cell, Chart, Column, Distribution, Provenance, Report, Row, Section, Table};
//!
//! let mut table = Table::new(
//!     [Column::new("err_u", "mm").about("‖u − û‖ at every node")],
//!     [Column::new("train", "s").once(), Column::new("predict", "s")],
//!     [Column::new("steps", "")],
//! );
//! // Errors of an emulator at every node of every test case, held against a published median.
//! let errors = Distribution::with_density("err_u", vec![0.0, 4e-3, 6e-3, 9e-3])?;
//! let row = Row::new("emulator", Cell::from(errors).against("published", Some(6.5e-3)), 26.0)?;
//! table.push(row.time(4.3e-4).other(2000.0))?;
//! assert!(table.rows[0].errors[0].verdict.as_ref().is_some_and(|verdict| verdict.met));
//!
//! let provenance = Provenance::of_this_run("example", env!("CARGO_MANIFEST_DIR"));
//! let mut report = Report::new("A beam", "an emulator of it", provenance);
//! let chart = Chart::speed_against_error(&table, 0);
//! report.sections.push(Section {
//!     name: "beam".into(),
//!     title: "Beam".into(),
//!     blocks: vec![Block::Table(table), Block::charts("Speed", "", [chart])],
//! });
//! assert_eq!(Report::from_json(&report.to_json()?)?, report);
//! assert!(report.to_html().contains("emulator"));
//! # Ok::<(), sinew_report::ReportError>(())
//! ```

mod distribution;
mod error;
mod files;
pub mod format;
mod picture;
mod render;
mod report;
mod summary;
mod table;
mod viewer;

pub use distribution::{Distribution, density};
pub use error::ReportError;
pub use picture::{Chart, Figure, Level, Series, Style, SurfaceCase, Surfaces};
pub use report::{Block, Provenance, Report, SCHEMA, Section};
pub use table::{Cell, Column, Row, Table, Value, Verdict};
pub use viewer::{
    LineSegments, Model, Packed, PackedRow, Quantity, Slider, Source, Viewer, ViewerCase,
    ViewerCavity, ViewerEmulator,
};
