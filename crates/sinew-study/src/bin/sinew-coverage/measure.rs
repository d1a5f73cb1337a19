//! Measurements that documents cite.

mod anchors;
mod by_size;
mod patient_cost;

use anyhow::Result;
use clap::Subcommand;

/// A measurement by name.
#[derive(Subcommand)]
pub(crate) enum Measurement {
    /// Errors of Taylor expansions about several solved states, beside regression on as many solves
    Anchors(anchors::Arguments),
    /// Cost of preparation and of an answer by the size of a body, beside a sweep of the solver
    BySize(by_size::Arguments),
    /// Processor time of one patient, stage by stage
    PatientCost(patient_cost::Arguments),
}

impl Measurement {
    /// Prints what it measures.
    pub(crate) fn run(self) -> Result<()> {
        match self {
            Self::Anchors(arguments) => anchors::run(arguments),
            Self::BySize(arguments) => by_size::run(&arguments),
            Self::PatientCost(arguments) => patient_cost::run(&arguments),
        }
    }
}
