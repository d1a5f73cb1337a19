//! The table on the terminal.

use crate::verify::case::{Measure, Row};
use crate::verify::run::Outcome;
use sinew_report::format::{count, digits, seconds, trimmed};
use std::fmt::Write;

const HEADINGS: [&str; 7] = ["value", "reference", "error", "band", "time", "unknowns", ""];

/// The rows of one case with its verdict, for a terminal.
pub fn table(outcome: &Outcome) -> String {
    let verdict = if outcome.passes() { "ok" } else { "FAILED" };
    let mut text = format!(
        "\n{}: {} [{}, {verdict}]\n",
        outcome.name,
        outcome.title,
        seconds(outcome.seconds)
    );
    let mut lines: Vec<(String, [String; 7])> = vec![("".into(), HEADINGS.map(String::from))];
    lines.extend(outcome.rows.iter().map(|row| (subject(row), cells(row))));
    if outcome.rows.is_empty() {
        lines.clear();
    }
    let width = |text: &str| text.chars().count();
    let widest = |column: usize| lines.iter().map(|l| width(&l.1[column])).max().unwrap_or(0);
    let widths: [usize; 7] = std::array::from_fn(widest);
    let first = lines.iter().map(|line| width(&line.0)).max().unwrap_or(0);
    for (subject, cells) in &lines {
        let _ = write!(text, "  {subject:<first$}");
        for (cell, width) in cells.iter().zip(widths) {
            let _ = write!(text, "  {cell:>width$}");
        }
        let kept = text.trim_end().len();
        text.truncate(kept);
        text.push('\n');
    }
    if let Some(failure) = &outcome.failure {
        let _ = writeln!(text, "  failed: {}", failure.replace('\n', "\n    "));
    }
    text
}

/// Subject of a row: quantity, element and mesh.
pub(crate) fn subject(row: &Row) -> String {
    let label = &row.label;
    let setup = if label.setup.is_empty() { "" } else { ", " };
    format!("{}, {}{setup}{}", label.quantity, label.formulation.label(), label.setup)
}

fn cells(row: &Row) -> [String; 7] {
    let verdict = if row.passes() { "" } else { "OUTSIDE" };
    [
        trimmed(row.value, 8),
        trimmed(row.reference, 8),
        error(row.error, row.measure),
        band(row),
        seconds(row.cost.seconds),
        count(row.cost.unknowns as u64),
        verdict.into(),
    ]
}

/// An error: relative ones from a hundredth of a percent on in percent.
pub(crate) fn error(value: f64, measure: Measure) -> String {
    match measure == Measure::Relative && value >= 0.999e-4 {
        true => format!("{} %", trimmed(100.0 * value, 2)),
        false => digits(value, 2),
    }
}

/// Band of the error.
pub(crate) fn band(row: &Row) -> String {
    let most = error(row.band.most, row.measure);
    if row.band.least == 0.0 {
        format!("≤ {most}")
    } else {
        format!("{} … {most}", error(row.band.least, row.measure))
    }
}

/// The last line: how many rows lie in their bands.
pub fn summary(outcomes: &[Outcome]) -> String {
    let rows = || outcomes.iter().flat_map(|outcome| &outcome.rows);
    let failed: Vec<_> = outcomes.iter().filter(|o| !o.passes()).map(|o| o.name.as_str()).collect();
    let total: f64 = outcomes.iter().map(|outcome| outcome.seconds).sum();
    let (inside, all) = (rows().filter(|row| row.passes()).count(), rows().count());
    let verdict = match failed.as_slice() {
        [] => "every case passes".to_string(),
        names => format!("failed: {}", names.join(", ")),
    };
    format!(
        "{inside} of {all} values within their bands, {} cases in {}; {verdict}",
        outcomes.len(),
        seconds(total)
    )
}
