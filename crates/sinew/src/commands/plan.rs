//! Expected costs of answers to an accuracy.

use super::{CaseArguments, Neighbour, count, trained};
use anyhow::Result;
use clap::Args;
use sinew::Design;
use sinew_emulate::{Plan as Costs, Terminal};

/// Numbers of parameter sets.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/plan.txt"))]
pub(crate) struct Plan {
    #[command(flatten)]
    case: CaseArguments,
    /// Numbers of parameter sets
    #[arg(long, value_delimiter = ',', default_values_t = [1, 100, 10_000], value_parser = count)]
    count: Vec<usize>,
    /// Largest mean nodal error, relative to the mean nodal displacement
    #[arg(long, value_name = "TOLERANCE", default_value_t = 1e-3)]
    accuracy: f64,
    #[command(flatten)]
    neighbour: Neighbour,
}

/// Seed of the first parameter set, near which the solver is timed.
const SEED: u64 = 1;

impl Plan {
    pub(crate) fn run(&self) -> Result<()> {
        let (_, body, folder) = self.case.open()?;
        let known = self.neighbour.body()?;
        let emulator = match (&known, trained(&folder).as_deref()) {
            (Some(known), _) => Some(self.neighbour.emulator(known, &body)?),
            (None, Ok([(_, path)])) => Some(sinew::load(path, &body)?),
            _ => None,
        };
        // The costs are measured at the first set; of the others only the number counts.
        let first = Design::Uniform.sample(&body.parameters, 1, SEED)?;
        let (counts, terminal) = (&self.count, &mut Terminal::default());
        let plans = Costs::for_counts(
            &body,
            &first[0],
            counts,
            self.accuracy,
            emulator.as_ref(),
            terminal,
        )?;
        for plan in &plans {
            println!("{} parameter sets to {:e}", plan.sets, self.accuracy);
            table(plan);
        }
        Ok(())
    }
}

/// The table of costs.
pub(super) fn table(plan: &Costs) {
    for (place, cost) in plan.costs.iter().enumerate() {
        let taken = if place == 0 { "taken" } else { "     " };
        let name = cost.method.name();
        let seconds = [cost.prepare, cost.each].map(|steps| plan.seconds(steps));
        match (plan.total_s(cost), seconds) {
            (Some(total), [Some(prepare), Some(each)]) => println!(
                "{taken} {name:34} {total:8.2} s expected: {prepare:.2} s to prepare, {:.1} ms a set on {}",
                1e3 * each,
                threads_in_words(plan.threads())
            ),
            _ => println!("{taken} {name:34} for {} sets", plan.sets),
        }
    }
}

fn threads_in_words(count: usize) -> String {
    if count == 1 { "one thread".into() } else { format!("each of {count} threads") }
}
