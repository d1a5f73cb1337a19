//! The last evaluation.

use super::{CaseArguments, Usage};
use anyhow::{Context, Result};
use clap::Args;
use sinew::Comparison;

/// Case and output.
#[derive(Debug, Args)]
#[command(
    after_help = "Run sinew evaluate first; this reads OUT/evaluation.json and writes OUT/report.html and\nOUT/report.json."
)]
pub(crate) struct Report {
    #[command(flatten)]
    case: CaseArguments,
}

impl Report {
    pub(crate) fn run(&self) -> Result<()> {
        let (_, folder) = self.case.read()?;
        let path = folder.join("evaluation.json");
        let text = std::fs::read_to_string(&path).map_err(|error| {
            Usage(format!("{}: {error}; run sinew evaluate first", path.display()))
        })?;
        let comparison: Comparison = serde_json::from_str(&text).with_context(|| {
            format!("{} is damaged or of another version; run sinew evaluate again", path.display())
        })?;
        println!("{comparison}");
        let page = comparison.report()?.write(&folder)?;
        println!("written: {}", page.display());
        Ok(())
    }
}
