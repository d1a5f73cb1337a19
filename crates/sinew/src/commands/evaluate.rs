//! Errors and times of trained emulators.

use super::{CaseArguments, chosen, refuse_if, solved, trained};
use anyhow::Result;
use clap::Args;
use sinew::{Comparison, Design, TestSet};
use sinew_emulate::{Counter, Terminal, store};
use std::path::Path;

/// Body and number of cases.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/evaluate.txt"))]
pub(crate) struct Evaluate {
    #[command(flatten)]
    case: CaseArguments,
    /// Number of test cases
    #[arg(long, default_value_t = 100, value_parser = super::count)]
    cases: usize,
    /// Newton steps after which errors are measured, from 0 to this number
    #[arg(long, default_value_t = 2)]
    corrections: usize,
    /// Names of emulators within OUT [default: all]
    #[arg(long, value_name = "NAME")]
    emulator: Vec<String>,
}

/// Apart from the seeds of trainings.
const SEED: u64 = 0x7e57;

impl Evaluate {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.case.open()?;
        let mut found = trained(&folder)?;
        for name in &self.emulator {
            chosen(Some(name), &case, &folder)?;
        }
        found.retain(|(name, _)| self.emulator.is_empty() || self.emulator.contains(name));
        let thetas = Design::Uniform.sample(&body.parameters, self.cases, SEED)?;
        let kept = folder.join(format!("test/{}", self.cases));
        let simulations = solved(&body, &thetas, "solve test cases", Some(&kept))?;
        let reason = "there is no test case with an equilibrium; ask for more --cases";
        refuse_if(simulations.fields.is_empty(), || reason)?;
        let test = TestSet::new(&body, simulations);
        let mut comparison = Comparison::new(&test)?;
        (comparison.case, comparison.seed) = (case.text().into(), Some(SEED));
        let mut terminal = Terminal::default();
        let mut counter = Counter::new(&mut terminal, "evaluate", 0, found.len());
        for (name, path) in &found {
            let emulator = sinew::load(path, &body)?;
            comparison.add(name, &emulator, &test, self.corrections)?;
            if let Some(method) = comparison.methods.last_mut() {
                method.options = stored_options(path);
            }
            let _ = counter.step(1, &format!("{name} on {} cases", test.thetas.len()));
        }
        counter.finish(&format!("{} emulators", found.len()));
        println!("{comparison}");
        store::write_json(&folder.join("evaluation.json"), &comparison)?;
        let page = comparison.report()?.write(&folder)?;
        println!("written: {}", page.display());
        Ok(())
    }
}

/// Recipe and options of the run that made an emulator; nothing where they were not kept.
fn stored_options(emulator: &Path) -> String {
    let run = store::read_json(&emulator.with_file_name("run.json"));
    let run: Option<serde_json::Value> = run.ok().flatten();
    let kept = |name: &str| Some(format!("{name} = {}", run.as_ref()?.get(name)?));
    ["recipe", "options"].into_iter().filter_map(kept).collect::<Vec<_>>().join("\n")
}
