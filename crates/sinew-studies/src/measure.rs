//! Measurements that documents cite.

mod by_size;
mod mean_ventricle;
mod rivals;
mod runs;

use anyhow::Result;
use clap::Subcommand;

/// A measurement by name.
#[derive(Subcommand)]
pub enum Measurement {
    /// Cost of preparation and of an answer by the size of a body, beside a sweep of the solver
    BySize(by_size::Arguments),
    /// A ventricle by Sinew, FEniCS, NGSolve, FElupe and scikit-fem, on the same meshes: seconds, memory, energies
    Rivals(rivals::Arguments),
    /// Emulators of stored runs against runs that are held back, of a table or of smooth functions
    Runs(runs::Arguments),
    /// Cost of a solve from rest by the size of a ventricle
    Size(by_size::SizeArguments),
}

impl Measurement {
    /// Prints what it measures.
    ///
    /// # Errors
    /// A body that cannot be made or solved; files that cannot be read.
    pub fn run(self) -> Result<()> {
        match self {
            Self::BySize(arguments) => by_size::run(&arguments),
            Self::Rivals(arguments) => rivals::run(&arguments),
            Self::Runs(arguments) => runs::run(&arguments),
            Self::Size(arguments) => by_size::run_size(&arguments),
        }
    }
}
