//! Parameters drawn from their ranges.

use super::{CaseArguments, solved};
use anyhow::{Result, ensure};
use clap::Args;
use sinew::output::Fields;
use sinew::{Body, Design};
use sinew_emulate::store;

/// How many, and how they are spread.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes OUT/sample/thetas.csv, which --theta of the other commands reads; with --solve also the equilibria.

Example: sinew sample OnceClampedBeam --count 200 --design sobol --solve")]
pub struct Sample {
    #[command(flatten)]
    case: CaseArguments,
    /// How many
    #[arg(long, default_value_t = 100)]
    count: usize,
    /// How they are spread over the ranges: one in each of COUNT slices of every range; by Sobol's sequence, the most
    /// even; or independently
    #[arg(long, value_parser = ["latin-hypercube", "sobol", "uniform"], default_value = "latin-hypercube")]
    design: String,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Solve for them, too
    #[arg(long)]
    solve: bool,
}

impl Sample {
    pub fn run(&self) -> Result<()> {
        let case = self.case.read()?;
        let body = case.body()?;
        let design: Design = serde_json::from_value(self.design.as_str().into())?;
        let thetas = design.sample(&body.parameters, self.count, self.seed)?;
        let folder = self.case.folder(&case).join("sample");
        let path = folder.join("thetas.csv");
        store::write_bytes(&path, table(&body, &thetas).as_bytes())?;
        if self.solve {
            let found = solved(&body, &thetas, "solve", None)?;
            let (failed, tried) = (found.failures.len(), thetas.len());
            let (thetas, found) = (&found.thetas[..], vec![("solved", found.fields)]);
            Fields { body: &body, thetas, found }.write(&folder, 0)?;
            ensure!(
                failed == 0,
                "{failed} of {tried} samples have no equilibrium; the others are written"
            );
        }
        println!("written: {}", path.display());
        Ok(())
    }
}

/// A row per θ that is read back bit for bit.
fn table(body: &Body, thetas: &[Vec<f64>]) -> String {
    let heads: Vec<_> = body
        .parameters
        .iter()
        .map(|p| match p.unit.as_str() {
            "1" => p.name.clone(),
            unit => format!("{} [{unit}]", p.name),
        })
        .collect();
    let row = |theta: &Vec<f64>| theta.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let rows: Vec<_> = std::iter::once(heads.join(",")).chain(thetas.iter().map(row)).collect();
    rows.join("\n") + "\n"
}
