//! Rows as the tables and sections of a report.

use crate::row::{Label, Row};
use sinew_report::format::{digits, rounded};
use sinew_report::{Block, Cell, Column, Figure, ReportError, Section, Table, Value};

/// One experiment: its rows, coverage, drawings and restarts.
///
/// # Errors
/// A row whose error or time is not a number.
pub fn section(
    name: String,
    title: &str,
    about: &str,
    rows: &[Row],
    figures: Vec<Figure>,
) -> Result<Section, ReportError> {
    let mut table = Table::new(
        [
            Column::new("err_u", "").about(
                "mean |u − û| over a grid of the domain (4.50); û is the posterior mean, or the network",
            ),
            Column::new("err_f", "").about("mean |f − f̂|, f the right-hand side"),
            Column::new("‖θ − θ̂‖", "").about("Euclidean distance from the true values (4.50)"),
        ],
        [Column::new("seconds", "").about(
            "one fit on one thread: prior, model, all restarts; with NUTS the sampling too",
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
        table.push(self::row(row)?)?;
    }
    let mut blocks = vec![Block::Text(about.into()), Block::Table(table)];
    blocks.extend(rows.iter().filter_map(coverage).map(Block::Text));
    blocks.extend(figures.into_iter().map(Block::Figure));
    blocks.extend(restarts(rows));
    Ok(Section { name, title: title.into(), blocks })
}

fn row(row: &Row) -> Result<sinew_report::Row, ReportError> {
    let (label, thesis) = (&row.label, &row.label.thesis);
    let cell = |value: Value, printed| Cell::from(value).against("the thesis’", printed);
    let own = sinew_report::Row::new(
        label.method.label(),
        cell(row.err_u().clone().into(), thesis.err_u),
        row.seconds().clone(),
    )?;
    let failed = match row.failures.len() {
        0 => String::new(),
        failed => format!("{failed} more gave no result: {}", row.failures.join("; ")),
    };
    let collapsed = Value::Text(format!("{} of {}", row.collapsed, row.runs));
    Ok(own
        .on(label.problem.as_str(), label.setting.as_str())
        .error(cell(row.err_f.clone().into(), thesis.err_f))
        .error(cell(row.err_theta.clone().into(), thesis.err_theta(&label.truth)))
        .other(Value::Several(row.theta.iter().cloned().map(Value::from).collect()))
        .other(printed(label))
        .other(row.evaluations.clone())
        .other(row.jitter.map(|jitter| rounded(jitter, 2)))
        .other(Cell { note: failed, ..Cell::from(collapsed) }))
}

/// The thesis' parameters with the digits it prints.
fn printed(label: &Label) -> String {
    let thesis = &label.thesis;
    let text = |(value, digit): (&f64, &f64)| {
        let decimals = (-digit.log10()).round().max(0.0) as usize;
        format!("{value:.decimals$}")
    };
    thesis.theta.iter().zip(&thesis.digit).map(text).collect::<Vec<_>>().join(", ")
}

/// Every restart of the first data set: what the best one was chosen from.
fn restarts(rows: &[Row]) -> Option<Block> {
    let restarted = rows.iter().filter(|row| row.restarts.len() > 1);
    let lines: Vec<Vec<Cell>> = restarted
        .flat_map(|row| {
            let label = &row.label;
            let name = format!("{} {} {}", label.problem, label.method.label(), label.setting);
            row.restarts.iter().enumerate().map(move |(number, end)| {
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
    let head = ["method", "restart", "evaluations", "log evidence", "θ̂", "collapsed"]
        .map(String::from)
        .to_vec();
    let title = "All restarts on the first data set".to_string();
    (!lines.is_empty()).then_some(Block::Listing { title, head, rows: lines })
}

/// How often intervals held the truth, in a sentence; none if that was not asked.
fn coverage(row: &Row) -> Option<String> {
    let coverage = row.coverage.as_ref()?;
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let held = coverage.theta.iter().zip(&coverage.theta_share);
    let theta: Vec<String> = row
        .label
        .truth
        .iter()
        .zip(held)
        .map(|(truth, (held, share))| {
            let [share, low, high] = share.map(percent);
            let (name, of) = (&truth.name, row.runs);
            format!("{name}: {held} of {of} = {share} % (95 % interval {low} to {high})")
        })
        .collect();
    Some(format!(
        "{}: 95 % intervals held {}; the band held u on {} % of the places (median data set {} %, worst {} %).",
        [row.label.problem.as_str(), &row.label.setting].join(", ").trim_end_matches(", "),
        theta.join("; "),
        percent(coverage.u_mean),
        percent(coverage.u_share.q50),
        percent(coverage.u_share.q0),
    ))
}
