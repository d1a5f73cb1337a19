//! `verify.html`: one file without scripts, fonts or links.

use crate::case::{Effort, Formulation, Measure, Row};
use crate::chart::{Series, class, legend, plot};
use crate::format::{count, error, escape, seconds, significant};
use crate::report::Report;
use crate::run::Outcome;
use crate::table;
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");

/// The whole page.
pub fn render(report: &Report) -> String {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\"><title>Solver benchmarks</title><style>{STYLE}</style></head><body><main>"
    );
    push_head(&mut html, report);
    push_overview(&mut html, &report.cases);
    for outcome in &report.cases {
        push_case(&mut html, outcome);
    }
    html.push_str("</main></body></html>\n");
    html
}

fn push_head(html: &mut String, report: &Report) {
    let effort = match report.effort {
        Effort::Quick => "coarse meshes only",
        Effort::Full => "everything",
    };
    let _ = write!(
        html,
        "<header><h1>The solver against references it shares no code with</h1><p>{}</p><dl class=\"facts\">",
        escape(&table::summary(&report.cases))
    );
    for (name, value) in [
        ("command", report.command.as_str()),
        ("extent", effort),
        ("version", report.version.as_str()),
        ("revision", report.revision.as_str()),
        ("machine", report.machine.as_str()),
        ("cores", &report.cores.to_string()),
        ("finished", report.finished.as_str()),
    ] {
        let _ = write!(html, "<div><dt>{name}</dt><dd>{}</dd></div>", escape(value));
    }
    html.push_str("</dl></header>");
}

/// One line per case: its verdict and the row that is nearest to the upper end of its band.
fn push_overview(html: &mut String, cases: &[Outcome]) {
    html.push_str("<section><h2>Overview</h2><div class=\"scroll\"><table><thead><tr><th>case</th><th>verdict</th><th>values</th><th class=\"text\">closest to its band's end</th><th>error</th><th>band</th><th>time</th></tr></thead><tbody>");
    for outcome in cases {
        let used = |row: &&Row| row.error / row.band.most;
        let closest = outcome.rows.iter().max_by(|a, b| used(a).total_cmp(&used(b)));
        let verdict = if outcome.passes() { ("good", "passes") } else { ("bad", "fails") };
        let _ = write!(
            html,
            "<tr><th scope=\"row\"><a href=\"#{0}\">{0}</a><small>{1}</small></th><td class=\"{2}\">{3}</td><td>{4}</td>",
            escape(&outcome.name),
            escape(&outcome.title),
            verdict.0,
            verdict.1,
            outcome.rows.len()
        );
        let cells = closest.map_or([const { String::new() }; 3], |row| {
            [table::subject(row), error(row.error, row.measure), table::band(row)]
        });
        let _ = write!(
            html,
            "<td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&cells[0]),
            cells[1],
            cells[2],
            seconds(outcome.seconds)
        );
    }
    html.push_str("</tbody></table></div></section>");
}

fn push_case(html: &mut String, outcome: &Outcome) {
    let _ = write!(
        html,
        "<section><h2 id=\"{}\">{}</h2><p class=\"note\">Reference: {}</p>",
        escape(&outcome.name),
        escape(&outcome.title),
        escape(&outcome.provenance)
    );
    if let Some(failure) = &outcome.failure {
        let _ = write!(html, "<p class=\"bad\">Failed</p><pre>{}</pre>", escape(failure));
    }
    push_plots(html, &outcome.rows);
    if !outcome.rows.is_empty() {
        push_rows(html, &outcome.rows);
    }
    html.push_str("</section>");
}

/// A pair of plots for each quantity that some formulation gave on several meshes.
fn push_plots(html: &mut String, rows: &[Row]) {
    let mut quantities: Vec<&str> = Vec::new();
    for row in rows {
        if !quantities.contains(&row.label.quantity.as_str()) {
            quantities.push(&row.label.quantity);
        }
    }
    for quantity in quantities {
        let rows: Vec<_> = rows.iter().filter(|row| row.label.quantity == quantity).collect();
        let by = |formulation| {
            rows.iter().copied().filter(move |r: &&Row| r.label.formulation == formulation)
        };
        let is_ladder = |&formulation: &Formulation| {
            let mut unknowns: Vec<_> = by(formulation).map(|row| row.cost.unknowns).collect();
            unknowns.sort_unstable();
            let all = unknowns.len();
            unknowns.dedup();
            unknowns.len() > 1 && unknowns.len() == all
        };
        if !Formulation::ALL.iter().any(is_ladder) {
            continue;
        }
        let shown: Vec<_> =
            Formulation::ALL.into_iter().filter(|&f| by(f).next().is_some()).collect();
        let series = |abscissa: fn(&Row) -> f64| -> Vec<Series> {
            let points = |formulation| {
                let point = |row: &Row| (abscissa(row), row.error, hint(row));
                let mut points: Vec<_> = by(formulation).map(point).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                points
            };
            shown.iter().map(|&f| Series { formulation: f, points: points(f) }).collect()
        };
        let y = match rows[0].measure {
            Measure::Relative => "relative error",
            Measure::Absolute => "error",
        };
        let charts = [
            plot(quantity, ["unknowns", y], &series(|row| row.cost.unknowns as f64)),
            plot(quantity, ["seconds", y], &series(|row| row.cost.seconds)),
        ];
        let _ = write!(html, "<h3>{}</h3><p class=\"legend\">", escape(quantity));
        shown.iter().for_each(|&f| html.push_str(&legend(f)));
        html.push_str("</p><div class=\"grid2\">");
        for chart in charts.into_iter().flatten() {
            let _ = write!(html, "<figure>{chart}</figure>");
        }
        html.push_str("</div>");
    }
}

fn hint(row: &Row) -> String {
    format!(
        "{}: {}, error {}, {} unknowns, {}",
        table::subject(row),
        significant(row.value, 6),
        error(row.error, row.measure),
        count(row.cost.unknowns as u64),
        seconds(row.cost.seconds)
    )
}

fn push_rows(html: &mut String, rows: &[Row]) {
    html.push_str("<div class=\"scroll\"><table><thead><tr><th>quantity</th><th class=\"text\">element</th><th class=\"text\">mesh and parameters</th><th>value</th><th>reference</th><th>error</th><th>band</th><th>time</th><th>unknowns</th></tr></thead><tbody>");
    for row in rows {
        let label = &row.label;
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{}</th><td class=\"text {}\">{}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td class=\"{}\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&label.quantity),
            class(label.formulation),
            label.formulation.label(),
            escape(&label.setup),
            significant(row.value, 8),
            significant(row.reference, 8),
            if row.passes() { "good" } else { "bad" },
            error(row.error, row.measure),
            table::band(row),
            seconds(row.cost.seconds),
            count(row.cost.unknowns as u64)
        );
    }
    html.push_str("</tbody></table></div>");
}
