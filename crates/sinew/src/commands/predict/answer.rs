//! Answers to an accuracy that is asked for, by the method that costs least, and the expected costs of all.

use super::{Asked, others};
use crate::commands::{Batch, CaseArguments, Neighbour, chosen, count, refuse, trained, warn};
use anyhow::{Result, bail};
use clap::Args;
use sinew::output::{Quality, Row, displacement_in_words, mean_and_largest};
use sinew::{Body, Case, Design};
use sinew_emulate::{Answer, Answers, Emulator, Method, Plan as Costs, Terminal, Warning};
use std::path::Path;

/// Name of the folder of answers.
const FOLDER: &str = "accuracy";

/// Answers all rows and writes them.
///
/// # Errors
/// An accuracy that makes no sense, an emulator that is named and not there, rows without an answer or beyond the tolerance.
pub(super) fn to(
    asked: &Asked,
    accuracy: f64,
    neighbour: &Neighbour,
    (case, body, folder): (&Case, &Body, &Path),
) -> Result<()> {
    let to = folder.join("predict").join(FOLDER);
    let batch = asked.theta.read(body, None, Some(&to))?;
    let known = neighbour.body()?;
    let emulator = match (&asked.emulator, &known, trained(folder)) {
        (Some(_), Some(_), _) => {
            return refuse("--emulator and --from are two starts: give one".into());
        }
        (None, Some(known), _) => Some(neighbour.emulator(known, body)?),
        (None, None, Err(_)) => None,
        _ => Some(sinew::load(&chosen(asked.emulator.as_deref(), case, folder)?.1, body)?),
    };
    let mut beyond = [0, 0];
    batch.in_parts(&asked.written, |batch| {
        part(batch, asked, (accuracy, emulator.as_ref()), body, &to, &mut beyond)
    })?;
    match beyond {
        [0, _] => Ok(()),
        [beyond, all] => bail!(
            "{beyond} of {all} answers are not within {accuracy:e}: the column `estimate` of cases.csv says how far they are"
        ),
    }
}

/// Answers and writes a part of the rows; returns how many failed, and counts answers beyond the tolerance among all.
fn part<'b>(
    mut batch: Batch<'_>,
    asked: &Asked,
    (accuracy, emulator): (f64, Option<&Emulator<'b>>),
    body: &'b Body,
    folder: &Path,
    beyond: &mut [usize; 2],
) -> Result<usize> {
    let thetas = batch.thetas();
    if thetas.is_empty() {
        return batch.write(&["answer"], [], &asked.written, folder);
    }
    let found = Answers::to(body, &thetas, accuracy, emulator, &mut Terminal::default())?;
    table(&found.plan);
    let answers = found.answers.into_iter().map(|found| found.map_err(|why| why.to_string()));
    let answers: Vec<Answer> = batch.answered(answers);
    batch.tell_states(&batch.thetas(), answers.iter().map(|answer| &answer.displacement[..]));
    batch.print(|place| {
        let Answer { displacement, error, .. } = &answers[place];
        let moved = displacement_in_words(displacement, &body.units.length);
        format!(": displacement {moved}; checked error {error:.1e}")
    });
    let doubts = [
        (
            Warning::Jumped,
            "may be on another branch than that of a rising load, whose equilibria `sinew solve --load-steps` finds",
        ),
        (Warning::Unstable, "are unstable: the least disturbance may end them"),
    ];
    for (doubt, what) in doubts {
        let count = answers.iter().filter(|answer| answer.warnings.contains(&doubt)).count();
        let all = answers.len();
        warn((count > 0).then(|| {
            format!(
                "{count} of {all} answers {what}; the column `warnings` of cases.csv marks them"
            )
        }));
    }
    let more = answers.iter().filter(|answer| !answer.is_within(accuracy)).count();
    *beyond = [beyond[0] + more, beyond[1] + answers.len()];
    let solved = answers.iter().filter(|answer| answer.method == Method::Solver).count();
    let (all, seconds, within) = (answers.len(), found.seconds, answers.len() - more);
    println!(
        "{all} answers in {seconds:.1} s, {solved} of them by the solver; {within} within {accuracy:e}"
    );
    let cells = answers.iter().map(|answer| Row {
        fields: vec![&answer.displacement],
        quality: Some(quality(answer)),
        warnings: others(&answer.warnings),
        ..Row::default()
    });
    batch.write(&["answer"], cells, &asked.written, folder)
}

fn quality(answer: &Answer) -> Quality {
    let mean = answer.error * mean_and_largest(&answer.displacement)[0];
    let (steps, method) = (answer.steps, answer.method.name());
    let kind = match answer.method {
        Method::Solver => format!("{method}, {steps} Newton steps"),
        _ => format!("{method}: {steps} that contract"),
    };
    Quality { mean: Some(mean), kind, ..Quality::default() }
}

/// Numbers of parameter sets.
#[derive(Debug, Args)]
#[command(after_help = include_str!("../help/plan.txt"))]
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
        let (counts, accuracy, terminal) = (&self.count, self.accuracy, &mut Terminal::default());
        let emulator = emulator.as_ref();
        let plans = Costs::for_counts(&body, &first[0], counts, accuracy, emulator, terminal)?;
        for plan in &plans {
            println!("{} parameter sets to {accuracy:e}", plan.sets);
            table(plan);
        }
        Ok(())
    }
}

/// The table of costs.
fn table(plan: &Costs) {
    let threads = match plan.threads() {
        1 => "one thread".into(),
        count => format!("each of {count} threads"),
    };
    for (place, cost) in plan.costs.iter().enumerate() {
        let taken = if place == 0 { "taken" } else { "     " };
        let name = cost.method.name();
        let seconds = [cost.prepare, cost.each].map(|steps| plan.seconds(steps));
        match (plan.total_s(cost), seconds) {
            (Some(total), [Some(prepare), Some(each)]) => println!(
                "{taken} {name:34} {total:8.2} s expected: {prepare:.2} s to prepare, {:.1} ms a set on {threads}",
                1e3 * each
            ),
            _ => println!("{taken} {name:34} for {} sets", plan.sets),
        }
    }
}
