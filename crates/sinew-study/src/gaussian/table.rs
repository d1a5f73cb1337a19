//! Rows as text: what stands in each cell, for the page and for the terminal.

use crate::gaussian::report::GaussianReport;
use crate::gaussian::row::{Row, Spread};
use crate::report::format::{digits, digits_rounded, seconds, two_digits};
use std::fmt::Write;

/// One column of the tables.
pub struct Column {
    /// Head, as plain text.
    pub head: &'static str,
    /// What stands in a row.
    pub cell: fn(&Row) -> Cell,
}

/// A value with what is written small below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// Large.
    pub value: String,
    /// Small; may be empty.
    pub note: String,
}

/// The columns after problem, setting and method.
pub const COLUMNS: [Column; 9] = [
    Column { head: "err_u, thesis", cell: |row| printed(row.label.thesis.err_u) },
    Column { head: "err_u, ours", cell: |row| spread(row.err_u()) },
    Column { head: "θ̂, thesis", cell: theta_thesis },
    Column { head: "θ̂, ours", cell: theta_ours },
    Column { head: "‖θ − θ̂‖", cell: |row| row.err_theta.map(spread).unwrap_or_default() },
    Column { head: "seconds", cell: time },
    Column { head: "evaluations", cell: evaluations },
    Column { head: "jitter", cell: jitter },
    Column { head: "collapsed", cell: collapsed },
];

fn printed(value: Option<f64>) -> Cell {
    Cell { value: value.map_or_else(String::new, two_digits), note: String::new() }
}

/// `1.2×10⁻³` over `8.9×10⁻⁴ to 2.3×10⁻³`.
pub fn spread(spread: Spread) -> Cell {
    Cell { value: two_digits(spread.median), note: range(&spread, two_digits) }
}

/// Both ends, unless they read the same.
fn range(spread: &Spread, text: impl Fn(f64) -> String) -> String {
    let (low, high) = (text(spread.low), text(spread.high));
    if low == high { String::new() } else { format!("{low} to {high}") }
}

fn theta_thesis(row: &Row) -> Cell {
    let thesis = &row.label.thesis;
    let text = |(value, digit): (&f64, &f64)| {
        let decimals = (-digit.log10()).round().max(0.0) as usize;
        format!("{value:.decimals$}")
    };
    let all: Vec<String> = thesis.theta.iter().zip(&thesis.digit).map(text).collect();
    Cell { value: all.join(", "), note: String::new() }
}

fn theta_ours(row: &Row) -> Cell {
    let join = |text: &dyn Fn(&Spread) -> String| {
        row.theta.iter().map(text).collect::<Vec<_>>().join(", ")
    };
    let single = row.theta.iter().all(|spread| spread.low == spread.high);
    let note = if single { String::new() } else { join(&|s| range(s, |value| digits(value, 4))) };
    Cell { value: join(&|spread| digits(spread.median, 4)), note }
}

fn time(row: &Row) -> Cell {
    let own = row.seconds();
    Cell { value: seconds(own.median), note: range(&own, seconds) }
}

fn evaluations(row: &Row) -> Cell {
    let value = row.evaluations.map(|spread| format!("{:.0}", spread.median));
    Cell { value: value.unwrap_or_default(), note: String::new() }
}

fn jitter(row: &Row) -> Cell {
    Cell { value: row.jitter.map_or_else(String::new, |j| digits(j, 1)), note: String::new() }
}

fn collapsed(row: &Row) -> Cell {
    let value = format!("{} of {}", row.collapsed, row.runs);
    let failed = row.failures.len();
    let note = if failed > 0 { format!("{failed} more gave no result") } else { String::new() };
    Cell { value, note }
}

/// How a row stands to the thesis, and whether all its figures are reached; none if it prints none.
pub fn verdict(row: &Row) -> Option<(bool, String)> {
    let comparisons = row.comparisons();
    let missed: Vec<String> = comparisons
        .iter()
        .filter(|(_, ours, theirs)| digits_rounded(*ours, 2) > theirs * (1.0 + 1e-9))
        .map(|(symbol, ours, theirs)| {
            format!("{} {}, thesis {}", name(symbol), two_digits(*ours), two_digits(*theirs))
        })
        .collect();
    match (comparisons.is_empty(), missed.is_empty()) {
        (true, _) => None,
        (false, true) => Some((true, "reached".into())),
        (false, false) => Some((false, format!("not reached: {}", missed.join("; ")))),
    }
}

/// A symbol of [`Row::comparisons`] for people.
fn name(symbol: &str) -> &str {
    match symbol {
        "err_theta" => "error of θ",
        other => other,
    }
}

/// Everything as one table in Markdown, as the terminal shows it.
pub fn markdown(report: &GaussianReport) -> String {
    let mut text = String::from("| problem | method |");
    for column in &COLUMNS {
        let _ = write!(text, " {} |", column.head);
    }
    let _ = writeln!(text, " thesis |\n|---|---|{}---|", "---|".repeat(COLUMNS.len()));
    for row in report.experiments.iter().flat_map(|experiment| &experiment.rows) {
        let label = &row.label;
        let method = format!("{} {}", label.method.label(), label.setting);
        let _ = write!(text, "| {} | {} |", label.problem, method.trim_end());
        for column in &COLUMNS {
            let cell = (column.cell)(row);
            let note = if cell.note.is_empty() { cell.note } else { format!(" ({})", cell.note) };
            let _ = write!(text, " {}{note} |", cell.value);
        }
        let _ = writeln!(text, " {} |", verdict(row).map_or_else(String::new, |v| v.1));
    }
    for row in report.experiments.iter().flat_map(|experiment| &experiment.rows) {
        text.extend(coverage(row).map(|line| format!("\n{line}\n")));
    }
    text
}

/// How often intervals held the truth, in a sentence; none if that was not asked.
pub fn coverage(row: &Row) -> Option<String> {
    let coverage = row.coverage.as_ref()?;
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let theta: Vec<String> = row
        .label
        .truth
        .iter()
        .zip(coverage.theta.iter().zip(&coverage.theta_share))
        .map(|(truth, (held, share))| {
            format!(
                "{}: {held} of {} = {} % (95 % interval {} to {})",
                truth.name,
                row.runs,
                percent(share.median),
                percent(share.low),
                percent(share.high)
            )
        })
        .collect();
    Some(format!(
        "{}: 95 % intervals held {}; the band held u on {} % of the places (median data set {} %, worst {} %).",
        [row.label.problem.as_str(), &row.label.setting].join(", ").trim_end_matches(", "),
        theta.join("; "),
        percent(coverage.u_mean),
        percent(coverage.u_share.median),
        percent(coverage.u_share.low),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaussian::row::{Findings, Label, Method, Run, Thesis, Truth};

    fn row(err_u: f64, theta: f64) -> Row {
        let label = Label {
            problem: "Heat-BVP-1".into(),
            setting: String::new(),
            method: Method::Hcgp,
            abscissa: None,
            truth: vec![Truth { name: "theta".into(), value: 1.0 }],
            thesis: Thesis {
                err_u: Some(4.9e-5),
                theta: vec![1.0],
                digit: vec![1e-3],
                ..Thesis::default()
            },
        };
        let found = Findings { theta: vec![theta], ..Findings::default() };
        let run = Run::new(err_u, 0.5, found).unwrap();
        Row::of(label, &[run], Vec::new()).unwrap()
    }

    #[test]
    fn what_is_missed_is_said_plainly() {
        assert_eq!(verdict(&row(4.94e-5, 1.0004)), Some((true, "reached".into())));
        let (reached, text) = verdict(&row(9.8e-5, 1.02)).unwrap();
        assert!(!reached);
        assert_eq!(
            text,
            "not reached: err_u 9.8×10⁻⁵, thesis 4.9×10⁻⁵; error of θ 0.020, thesis 5.0×10⁻⁴"
        );
        assert_eq!(theta_thesis(&row(1.0, 1.0)).value, "1.000");
    }
}
