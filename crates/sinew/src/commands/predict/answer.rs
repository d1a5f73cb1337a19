//! Answers to an accuracy that is asked for, by the method that costs least.

use super::{Asked, others};
use crate::commands::plan::table;
use crate::commands::{Batch, Neighbour, chosen, refuse, tell_doubtful, trained, warn_of_locking};
use anyhow::{Result, bail};
use sinew::output::{Quality, Row, displacement_in_words, mean_and_largest};
use sinew::{Body, Case};
use sinew_emulate::{Answer, Answers, Emulator, Method, Terminal};
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
    let batch = asked.theta.read(body, None)?;
    let known = neighbour.body()?;
    let emulator = match (&asked.emulator, &known, trained(folder)) {
        (Some(_), Some(_), _) => {
            return refuse("--emulator and --from are two starts: give one".into());
        }
        (None, Some(known), _) => Some(neighbour.emulator(known, body)?),
        (None, None, Err(_)) => None,
        _ => Some(sinew::load(&chosen(asked.emulator.as_deref(), case, folder)?.1, body)?),
    };
    let folder = folder.join("predict").join(FOLDER);
    let mut beyond = [0, 0];
    batch.in_parts(body, &asked.written, |batch| {
        part(batch, asked, (accuracy, emulator.as_ref()), body, &folder, &mut beyond)
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
    mut batch: Batch,
    asked: &Asked,
    (accuracy, emulator): (f64, Option<&Emulator<'b>>),
    body: &'b Body,
    folder: &Path,
    beyond: &mut [usize; 2],
) -> Result<usize> {
    let thetas = batch.thetas();
    if thetas.is_empty() {
        return batch.write(body, &["answer"], Vec::new(), &asked.written, folder);
    }
    let found = Answers::to(body, &thetas, accuracy, emulator, &mut Terminal::default())?;
    table(&found.plan);
    let open: Vec<usize> = batch.open().collect();
    let mut answers: Vec<Answer> = Vec::new();
    for (row, answer) in open.into_iter().zip(found.answers) {
        match answer {
            Ok(answer) => answers.push(answer),
            Err(reason) => batch.fail(body, row, reason.to_string()),
        }
    }
    if let (Some(theta), Some(first)) = (batch.thetas().first(), answers.first()) {
        warn_of_locking(sinew_fem::locking(body, theta, &first.displacement));
    }
    tell_doubtful(body, answers.iter().map(|answer| answer.displacement.as_slice()));
    batch.print(body, |place| {
        let Answer { displacement, error, .. } = &answers[place];
        let moved = displacement_in_words(displacement, &body.units.length);
        format!(": displacement {moved}; checked error {error:.1e}")
    });
    let more = answers.iter().filter(|answer| !answer.is_within(accuracy)).count();
    *beyond = [beyond[0] + more, beyond[1] + answers.len()];
    let solved = answers.iter().filter(|answer| answer.method == Method::Solver).count();
    println!(
        "{} answers in {:.1} s, {solved} of them by the solver; {} within {accuracy:e}",
        answers.len(),
        found.seconds,
        answers.len() - more
    );
    let cells = answers.iter().map(|answer| Row {
        fields: vec![&answer.displacement],
        quality: Some(quality(answer)),
        warnings: others(&answer.warnings),
        ..Row::default()
    });
    batch.write(body, &["answer"], cells.collect(), &asked.written, folder)
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
