//! Rows as the tables and sections of a report.

use crate::gp::row::Row;
use crate::thesis;
use sinew_report::format::{digits, rounded};
use sinew_report::{Block, Cell, Column, Figure, ReportError, Section, Table, Value};

/// One experiment: its rows, drawings and restarts.
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
