//! Posteriors of synthetic patients: how often their intervals hold, and how far they are from brute force
//! (`cargo xtask reproduce-calibration`).

mod coverage;
mod ecdf;
mod exactness;
pub mod options;
mod reference;

use crate::program::Growing;
use anyhow::Result;
use options::{Options, Part};
use std::path::PathBuf;

/// Runs all parts that are asked for and writes the report, anew after each; the path of `report.html`.
///
/// # Errors
/// Patients that cannot be solved, and files that cannot be written. What is done is kept.
pub fn reproduce(options: &Options) -> Result<PathBuf> {
    let about = "Posteriors of synthetic patients against truth and brute force.";
    let names = ["Calibration", about];
    let size = (options.seed, options.quick);
    let mut growing = Growing::new(names, size, options, |_| String::new())?;
    let mut page = options.out.join("report.html");
    if options.wants(Part::Coverage) {
        page = growing.add(coverage::section(options)?, &options.out)?;
    }
    if options.wants(Part::Importance) {
        page = growing.add(exactness::importance(options)?, &options.out)?;
    }
    Ok(page)
}
