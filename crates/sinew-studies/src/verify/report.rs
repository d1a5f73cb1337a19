//! The report of a run: `report.json` for programs and `report.html` for people; its table on the terminal.

use crate::verify::case::{Case, Effort, Formulation, Measure, Row};
use crate::verify::run::Outcome;
use sinew_report::format::{count, digits, seconds, trimmed};
use sinew_report::{
    Block, Cell, Chart, Column, Provenance, Report, ReportError, Section, Series, Style, Table,
    Verdict, format,
};
use std::fmt::Write;

/// The report of a run.
pub fn report(effort: Effort, cases: &[Outcome]) -> Result<Report, ReportError> {
    let mut provenance = Provenance::of_this_run("cargo xtask", env!("CARGO_MANIFEST_DIR"));
    provenance.versions.insert("sinew-studies".into(), env!("CARGO_PKG_VERSION").into());
    provenance.wall_s = cases.iter().map(|case| case.seconds).sum();
    let extent = match effort {
        Effort::Quick => "coarse meshes only",
        Effort::Full => "everything",
    };
    let title = "The solver against references it shares no code with";
    let mut report = Report::new(title, format!("Extent: {extent}."), provenance);
    report.headline = summary(cases);
    report.sections.push(overview(cases));
    for case in cases {
        report.sections.push(section(case)?);
    }
    Ok(report)
}

/// One line per case: its verdict and the row that is nearest to the upper end of its band.
fn overview(cases: &[Outcome]) -> Section {
    let head = ["case", "verdict", "values", "closest to its band's end", "error", "band", "time"];
    let rows = cases.iter().map(|case| {
        let used = |row: &&Row| row.error / row.band.most;
        let closest = case.rows.iter().max_by(|a, b| used(a).total_cmp(&used(b)));
        let closest = closest.map_or([const { String::new() }; 3], |row| {
            [subject(row), error(row.error, row.measure), band(row)]
        });
        let verdict = if case.passes() { "passes" } else { "fails" };
        let [subject, error, band] = closest.map(Cell::from);
        let time = format::seconds(case.seconds);
        vec![
            case.case.name.into(),
            verdict.into(),
            (case.rows.len() as f64).into(),
            subject,
            error,
            band,
            time.into(),
        ]
    });
    let blocks = vec![Block::listing("All cases", head, rows)];
    Section { name: "overview".into(), title: "Overview".into(), blocks }
}

fn section(outcome: &Outcome) -> Result<Section, ReportError> {
    let Case { name, title, provenance, .. } = outcome.case;
    let mut blocks = vec![Block::Text(format!("Reference: {provenance}"))];
    blocks.extend(outcome.failure.iter().map(|failure| Block::Text(format!("Failed: {failure}"))));
    blocks.extend(convergence(&outcome.rows));
    let mut table = Table::new(
        [Column::new("error", "")
            .about("relative to the reference, or in the unit of the quantity where it says so")],
        [Column::new("time", "s").about("wall time of preparing and solving")],
        ["value", "reference", "unknowns"].map(|name| Column::new(name, "")),
    );
    for row in &outcome.rows {
        let band = Verdict {
            met: row.passes(),
            limit: row.band.most,
            text: format!("band {}", band(row)),
        };
        let error = Cell { verdict: Some(band), ..row.error.into() };
        let mut setup = row.label.setup.clone();
        if row.measure == Measure::Absolute {
            setup.push_str(" (absolute)");
        }
        let subject = row.label.quantity.clone();
        let method = row.label.formulation.label();
        let own = sinew_report::Row::new(method, error, row.cost.seconds)?;
        let row = sinew_report::Row { subject, about: setup, ..own }
            .other(row.value)
            .other(row.reference)
            .other(row.cost.unknowns as f64);
        table.push(row)?;
    }
    if !table.rows.is_empty() {
        blocks.push(Block::Table(table));
    }
    Ok(Section { name: name.into(), title: title.into(), blocks })
}

/// Error against unknowns and against time for each quantity that some formulation gave on several meshes.
fn convergence(rows: &[Row]) -> Vec<Block> {
    let mut quantities: Vec<&str> = Vec::new();
    for row in rows {
        if !quantities.contains(&row.label.quantity.as_str()) {
            quantities.push(&row.label.quantity);
        }
    }
    let of = |quantity: &str, formulation| {
        let quantity = quantity.to_string();
        let chosen = move |row: &&Row| {
            row.label.quantity == quantity && row.label.formulation == formulation
        };
        rows.iter().filter(chosen).collect::<Vec<_>>()
    };
    let is_ladder = |rows: Vec<&Row>| {
        let mut unknowns: Vec<_> = rows.iter().map(|row| row.cost.unknowns).collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        unknowns.len() > 1 && unknowns.len() == rows.len()
    };
    quantities.retain(|quantity| Formulation::ALL.iter().any(|&f| is_ladder(of(quantity, f))));
    let block = |quantity: &str| {
        let chart = |name: &str, abscissa: fn(&Row) -> f64| {
            let mut chart = Chart::new(format!("Error against {name}"), [name, "error"], [true; 2]);
            for formulation in Formulation::ALL {
                let mut rows = of(quantity, formulation);
                rows.sort_by(|a, b| abscissa(a).total_cmp(&abscissa(b)));
                let points = rows.iter().map(|row| [abscissa(row), row.error]);
                let hints = rows.iter().map(|row| hint(row)).collect();
                let series = Series::new(formulation.label(), Style::Marked, points);
                if !rows.is_empty() {
                    chart.series.push(Series { hints, ..series });
                }
            }
            chart
        };
        let charts = [
            chart("unknowns", |row| row.cost.unknowns as f64),
            chart("seconds", |row| row.cost.seconds),
        ];
        Block::charts(quantity, "", charts)
    };
    quantities.into_iter().map(block).collect()
}

fn hint(row: &Row) -> String {
    format!(
        "{}: {}, error {}, {} unknowns, {}",
        subject(row),
        format::trimmed(row.value, 6),
        error(row.error, row.measure),
        format::count(row.cost.unknowns as u64),
        format::seconds(row.cost.seconds)
    )
}

const HEADINGS: [&str; 7] = ["value", "reference", "error", "band", "time", "unknowns", ""];

/// The rows of one case with its verdict, for a terminal.
pub fn table(outcome: &Outcome) -> String {
    let verdict = if outcome.passes() { "ok" } else { "FAILED" };
    let Case { name, title, .. } = outcome.case;
    let mut text = format!("\n{name}: {title} [{}, {verdict}]\n", seconds(outcome.seconds));
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
    let failed: Vec<_> = outcomes.iter().filter(|o| !o.passes()).map(|o| o.case.name).collect();
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
