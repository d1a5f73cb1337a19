//! Rows as the tables and sections of a report.

use crate::gp::draw::BAND;
use crate::gp::row::{Covered, Row};
use crate::thesis;
use sinew_report::format::{digits, rounded};
use sinew_report::{Block, Cell, Column, Distribution, Figure, ReportError, Section, Table, Value};

/// One experiment: its rows, coverage, drawings and restarts.
pub fn section(
    name: String,
    title: &str,
    about: &str,
    rows: &[Row],
    figures: Vec<Figure>,
) -> Result<Section, ReportError> {
    let mut table = Table::new(
        [
            Column::new(ERR_U, "").about(
                "mean |u − û| over a grid of the domain (4.50); û is the posterior mean, or the network",
            ),
            Column::new(ERR_F, "").about("mean |f − f̂|, f the right-hand side"),
            Column::new(ERR_THETA, "").about("Euclidean distance from the true values (4.50)"),
        ],
        [Column::new("seconds", "").about(
            "one fit on one thread: prior, model, all restarts",
        )],
        [
            Column::new("θ̂", "").about("the equation’s parameters at the fit, in the order of the problem"),
            Column::new("θ̂, thesis", ""),
            Column::new("evaluations", "").about(
                "of evidence (or loss) and gradient, over all restarts; empty where they are not counted",
            ),
            Column::new("jitter", "").about("largest relative jitter that a covariance needed at the end of a fit"),
            Column::new("collapsed", "").about(
                "data sets whose fit explains less than a tenth of what was measured and takes the rest for noise",
            ),
        ],
    );
    for row in rows {
        table.push(self::row(&name, row)?)?;
    }
    let mut blocks = vec![Block::Text(about.into()), Block::Table(table)];
    blocks.extend(rows.iter().filter_map(coverage).map(Block::Text));
    blocks.extend(figures.into_iter().map(Block::Figure));
    blocks.extend(restarts(rows));
    Ok(Section { name, title: title.into(), blocks })
}

fn row(section: &str, row: &Row) -> Result<sinew_report::Row, ReportError> {
    let label = &row.label;
    let (subject, about) = (label.problem.clone(), label.setting.clone());
    let seconds = row.spread(|run| run.seconds);
    let own = sinew_report::Row::new(label.method.label(), row.err_u(), seconds)?;
    let own = sinew_report::Row { subject, about, ..own };
    let name = own.name();
    let printed = |column: &str| thesis::printed_median([section, &name, column]);
    let cell = |value: Value, column: &str| {
        Cell::from(value).against("the thesis’", printed(column).map(|printed| printed.limit))
    };
    let failed = match row.failures.len() {
        0 => String::new(),
        failed => format!("{failed} more gave no result: {}", row.failures.join("; ")),
    };
    let runs = &row.runs;
    let collapsed = runs.iter().filter(|run| run.collapsed).count();
    let collapsed = Value::Text(format!("{collapsed} of {}", runs.len()));
    let jitter = runs.iter().filter_map(|run| run.jitter).reduce(f64::max);
    let errors = vec![
        cell(row.err_u().into(), ERR_U),
        cell(row.optional(|run| run.err_f).into(), ERR_F),
        cell(row.err_theta().into(), ERR_THETA),
    ];
    let theta = printed(ERR_THETA).map(|printed| printed.printed.replace(',', ", "));
    Ok(sinew_report::Row { errors, ..own }
        .other(Value::Several(row.theta().into_iter().map(Value::from).collect()))
        .other(theta.unwrap_or_default())
        .other(row.optional(|run| run.evaluations.map(|count| count as f64)))
        .other(jitter.map(|jitter| rounded(jitter, 2)))
        .other(Cell { note: failed, ..Cell::from(collapsed) }))
}

/// Columns that the thesis prints figures for.
const ERR_U: &str = "err_u";
const ERR_F: &str = "err_f";
const ERR_THETA: &str = "‖θ − θ̂‖";

/// Every restart of the first data set: what the best one was chosen from.
fn restarts(rows: &[Row]) -> Option<Block> {
    let restarted = rows.iter().filter(|row| row.runs[0].restarts.len() > 1);
    let lines: Vec<Vec<Cell>> = restarted
        .flat_map(|row| {
            let label = &row.label;
            let name = format!("{} {} {}", label.problem, label.method.label(), label.setting);
            row.runs[0].restarts.iter().enumerate().map(move |(number, end)| {
                let theta: Vec<String> = end.theta.iter().map(|value| digits(*value, 4)).collect();
                vec![
                    name.trim_end().into(),
                    (number as f64 + 1.0).into(),
                    (end.evaluations as f64).into(),
                    end.log_evidence.into(),
                    theta.join(", ").into(),
                    if end.collapsed { "yes" } else { "no" }.into(),
                ]
            })
        })
        .collect();
    let head = ["method", "restart", "evaluations", "log evidence", "θ̂", "collapsed"];
    (!lines.is_empty()).then(|| Block::listing("All restarts on the first data set", head, lines))
}

/// Coverage of the intervals, in a sentence; none if that was not asked.
fn coverage(row: &Row) -> Option<String> {
    let covered: Vec<&Covered> =
        row.runs.iter().map(|run| run.covered.as_ref()).collect::<Option<_>>()?;
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let of = covered.len();
    let parameters = row.label.truth.iter().enumerate().map(|(number, truth)| {
        let held = covered.iter().filter(|covered| covered.theta[number]).count();
        let [share, low, high] = wilson(held, of).map(percent);
        format!("{}: {held} of {of} = {share} % (95 % interval {low} to {high})", truth.name)
    });
    let widths = row.label.truth.iter().enumerate().filter_map(|(number, truth)| {
        let width =
            |covered: &&Covered| covered.intervals[number][1] - covered.intervals[number][0];
        let median = Distribution::of(covered.iter().map(width).collect())?.q50;
        Some(format!("{} % of {}", digits(100.0 * median / truth.value, 3), truth.name))
    });
    let u = Distribution::of(covered.iter().map(|covered| covered.u).collect())?;
    let mean = covered.iter().map(|covered| covered.u).sum::<f64>() / of as f64;
    Some(format!(
        "{}, {}: 95 % intervals held {}, median width {}; the band held u on {} % of the places (median data set {} %, worst {} %).",
        [row.label.problem.as_str(), &row.label.setting].join(", ").trim_end_matches(", "),
        row.label.method.label(),
        parameters.collect::<Vec<_>>().join("; "),
        widths.collect::<Vec<_>>().join(" and "),
        percent(mean),
        percent(u.q50),
        percent(u.q0),
    ))
}

/// A share with its 95 % interval by the score method (Wilson 1927), which holds near 0 and 1 too.
fn wilson(held: usize, of: usize) -> [f64; 3] {
    let (n, z2) = (of as f64, BAND * BAND);
    let share = held as f64 / n;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = BAND / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    [share, (centre - half).max(0.0), (centre + half).min(1.0)]
}
