//! The command line.

use clap::Parser;
use std::path::PathBuf;

/// Compare the solver with references that share no code with it: a table, `report.json` and `report.html`.
/// Ends with an error when a value falls outside its stated band.
#[derive(Clone, Debug, Parser)]
#[command(name = "cargo xtask verify", version)]
pub struct Options {
    /// Only the cases whose names contain this text; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// List the cases and end
    #[arg(long)]
    pub list: bool,
    /// Coarse meshes only
    #[arg(long)]
    pub quick: bool,
    /// Folder of report.json and report.html
    #[arg(long, value_name = "DIR", default_value = "out/verify")]
    pub out: PathBuf,
}
