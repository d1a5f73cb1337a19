//! Parameters drawn from their ranges.

use super::CaseArguments;
use anyhow::{Context, Result, ensure};
use clap::Args;
use sinew::output::Fields;
use sinew::{Body, Design};

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
    /// How they are spread over the ranges
    #[arg(long, value_enum, default_value_t = Spread::LatinHypercube)]
    design: Spread,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Solve for them, too
    #[arg(long)]
    solve: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Spread {
    /// One sample in each of COUNT slices of every range
    LatinHypercube,
    /// Sobol's sequence, scrambled: the most even
    Sobol,
    /// Independent
    Uniform,
}

impl Sample {
    pub fn run(&self) -> Result<()> {
        let case = self.case.read()?;
        let body = case.body()?;
        let design = match self.design {
            Spread::LatinHypercube => Design::LatinHypercube,
            Spread::Sobol => Design::Sobol,
            Spread::Uniform => Design::Uniform,
        };
        let thetas = design.sample(&body.parameters, self.count, self.seed)?;
        let folder = self.case.folder(&case).join("sample");
        let path = folder.join("thetas.csv");
        let written = std::fs::create_dir_all(&folder)
            .and_then(|()| std::fs::write(&path, table(&body, &thetas)));
        written.with_context(|| format!("{} cannot be written", path.display()))?;
        if self.solve {
            let mut terminal = sinew_emulate::Terminal::default();
            let found = sinew::simulate(&body, &thetas, "solve", None, &mut terminal)?;
            for failure in &found.failures {
                eprintln!(
                    "no equilibrium at {}: {}",
                    super::shown(&body, &failure.theta),
                    failure.reason
                );
            }
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
