//! Command line.

use clap::{Parser, ValueEnum};
use serde::{Deserialize, Serialize};
use sinew_gnn::Backend;
use std::path::PathBuf;

/// Compare data-driven (dd) and physics-informed (pi) emulators of the thesis' two gravity beams with the
/// finite-element solver and with regression on few simulations, from the mesh to the report.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-beam", version, max_term_width = 110)]
pub struct BeamOptions {
    /// Beam [default: both]
    #[arg(long, value_parser = ["once", "twice"])]
    pub(crate) scene: Option<String>,
    /// Emulators to train, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "dd,pi")]
    pub method: Vec<Method>,
    /// Same code with few simulations and steps, within a minute: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Backend of networks: flex (this processor), ndarray (deprecated), wgpu or cuda (graphics processors)
    #[arg(long, default_value_t)]
    pub backend: Backend,
    /// Folder for report, tables, fields and checkpoints
    #[arg(long, default_value = "out/reproduce-beam")]
    pub out: PathBuf,
    /// Continue the run in the output folder where it was interrupted
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

/// An emulator that can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Supervised on simulated displacements, thesis (3.11)
    Dd,
    /// Minimum potential energy, without any simulation, thesis (3.12)
    Pi,
}

impl Method {
    /// Name in reports and files.
    pub(crate) fn key(self) -> &'static str {
        ["dd", "pi"][self as usize]
    }
}
