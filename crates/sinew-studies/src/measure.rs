//! Measurements that documents cite.

mod by_size;
mod locking;
mod mean_ventricle;
mod organ;
mod patient_cost;
mod real_heart;
mod rivals;
mod runs;
mod unload;
mod unload_robustness;

use anyhow::Result;
use clap::Subcommand;
use std::path::PathBuf;

/// A measurement by name.
#[derive(Subcommand)]
pub enum Measurement {
    /// Cost of preparation and of an answer by the size of a body, beside a sweep of the solver
    BySize(by_size::Arguments),
    /// Displacement that linear tetrahedra lose, by the estimate and by a solve in quadratic ones: blocks, plates, ventricles, livers; the
    /// published organs and the surfaces of a real heart where ../shared/meshes has them
    Locking,
    /// Processor time of one patient, stage by stage
    PatientCost(patient_cost::Arguments),
    /// The left ventricle of a real heart over one beat, meshed from its surfaces and loaded; the surfaces of
    /// ../shared/meshes/biv-me, else those of an ideal ventricle
    RealHeart,
    /// A ventricle by Sinew, FEniCS, NGSolve, FElupe and scikit-fem, on the same meshes: seconds, memory, energies
    Rivals(rivals::Arguments),
    /// Emulators of stored runs against runs that are held back, of a table or of smooth functions
    Runs(runs::Arguments),
    /// Cost of a solve from rest by the size of a ventricle
    Size(by_size::SizeArguments),
    /// The thesis' left ventricle unloaded: error against processor time
    Unload {
        /// Fixed points beside Newton's method
        #[arg(long)]
        rivals: bool,
    },
    /// Random ventricles and frames of a real heart unloaded: clean answers, typed refusals and wrong answers
    UnloadRobustness {
        /// Random ventricles of two layers, and of one
        #[arg(default_value_t = 100)]
        shapes: u64,
        /// Folder with the surfaces of biv-me
        folder: Option<PathBuf>,
    },
}

impl Measurement {
    /// Prints what it measures.
    ///
    /// # Errors
    /// A body that cannot be made or solved; files that cannot be read.
    pub fn run(self) -> Result<()> {
        match self {
            Self::BySize(arguments) => by_size::run(&arguments),
            Self::Locking => locking::run(),
            Self::PatientCost(arguments) => patient_cost::run(&arguments),
            Self::RealHeart => real_heart::run(),
            Self::Rivals(arguments) => rivals::run(&arguments),
            Self::Runs(arguments) => runs::run(&arguments),
            Self::Size(arguments) => by_size::run_size(&arguments),
            Self::Unload { rivals } => unload::run(rivals),
            Self::UnloadRobustness { shapes, folder } => {
                unload_robustness::run(shapes, folder.as_deref())
            }
        }
    }
}
