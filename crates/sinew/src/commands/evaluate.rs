//! Errors and times of trained emulators.

use super::{CaseArguments, Usage, trained};
use anyhow::{Context, Result};
use clap::Args;
use sinew::{Comparison, Design, Emulator, TestSet};
use sinew_emulate::{Observer, Progress};

/// On how many cases.
#[derive(Debug, Args)]
#[command(after_help = "\
Test cases are uniform in the ranges, each on its scale, and unknown to every training. Errors are those of the thesis:
err_u (mm, per node), err_F, err_I1, err_Pi and err_V (%, deformation gradient, first invariant, potential energy, cavity
volume), as predicted and after Newton steps. Simulations are kept in OUT/test and solved once. Writes
OUT/evaluation.json, which sinew report reads.

Example: sinew train OnceClampedBeam --recipe regression && sinew evaluate OnceClampedBeam --cases 50")]
pub struct Evaluate {
    #[command(flatten)]
    case: CaseArguments,
    /// Test cases
    #[arg(long, default_value_t = 100)]
    cases: usize,
    /// Most Newton steps
    #[arg(long, default_value_t = 2)]
    corrections: usize,
    /// Names of emulators within OUT [default: all]
    #[arg(long, value_name = "NAME")]
    emulator: Vec<String>,
}

/// Apart from the seeds of trainings.
const SEED: u64 = 0x7e57;

impl Evaluate {
    pub fn run(&self) -> Result<()> {
        let case = self.case.read()?;
        let body = case.body()?;
        let folder = self.case.folder(&case);
        let mut found = trained(&folder)?;
        if let Some(missing) =
            self.emulator.iter().find(|name| found.iter().all(|(known, _)| known != *name))
        {
            let names: Vec<_> = found.iter().map(|(name, _)| name.as_str()).collect();
            return Err(Usage(format!(
                "there is no emulator `{missing}` in {}; there are: {}",
                folder.display(),
                names.join(", ")
            ))
            .into());
        }
        found.retain(|(name, _)| self.emulator.is_empty() || self.emulator.contains(name));
        if found.is_empty() {
            return Err(Usage(format!(
                "there is no emulator in {}; make one: sinew train",
                folder.display()
            ))
            .into());
        }
        let thetas = Design::Uniform.sample(&body.parameters, self.cases, SEED)?;
        let mut terminal = sinew_emulate::Terminal::default();
        let kept = folder.join(format!("test/{}", self.cases));
        let simulations =
            sinew::simulate(&body, &thetas, "solve test cases", Some(&kept), &mut terminal)?;
        for failure in &simulations.failures {
            eprintln!(
                "no equilibrium at {}: {}",
                super::shown(&body, &failure.theta),
                failure.reason
            );
        }
        if simulations.fields.is_empty() {
            return Err(Usage(
                "there is no test case with an equilibrium; ask for more --cases".into(),
            )
            .into());
        }
        let test = TestSet::new(&body, simulations);
        let mut comparison = Comparison::new(&test)?;
        let start = std::time::Instant::now();
        for (done, (name, path)) in found.iter().enumerate() {
            let share = done as f64 / found.len() as f64;
            let seconds_left = start.elapsed().as_secs_f64() * (1.0 - share) / share;
            let message = format!("{name} on {} cases", test.thetas.len());
            let _ = terminal.progress(&Progress {
                stage: "evaluate",
                fraction: share,
                seconds_left,
                message: &message,
            });
            let emulator = Emulator::load(path, &body)?;
            comparison.add(name, &emulator, &test, self.corrections)?;
        }
        let outcome = format!("{} emulators", found.len());
        terminal.finished("evaluate", &outcome, start.elapsed().as_secs_f64());
        println!("{comparison}");
        let path = folder.join("evaluation.json");
        let text = serde_json::to_string_pretty(&comparison)?;
        std::fs::write(&path, text)
            .with_context(|| format!("{} cannot be written", path.display()))?;
        println!("written: {}", path.display());
        Ok(())
    }
}
