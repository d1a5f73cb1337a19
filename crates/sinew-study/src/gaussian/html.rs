//! `report.html`: one file without scripts, fonts or links.

use crate::gaussian::picture::{Figure, Panel};
use crate::gaussian::report::{ExperimentReport, GaussianReport};
use crate::gaussian::row::Row;
use crate::gaussian::{svg, table};
use crate::report::format::{digits, escape, seconds};
use crate::report::page;
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");
const TITLE: &str = "Boundary conditions built in: Gaussian processes and networks";

/// The whole page.
pub fn render(report: &GaussianReport) -> String {
    let mut html = page::start(TITLE, STYLE);
    push_head(&mut html, report);
    push_summary(&mut html, report);
    for experiment in &report.experiments {
        push_experiment(&mut html, experiment);
    }
    push_provenance(&mut html, report);
    html.push_str(page::END);
    html
}

fn push_head(html: &mut String, report: &GaussianReport) {
    let _ = write!(
        html,
        "<header><h1>{TITLE}</h1><p>The experiments of chapter 4 and §1.7.3 of the thesis, beside the figures it prints, and a nonlinear equation beyond them.</p>"
    );
    page::push_facts(
        html,
        &[
            ("machine", report.machine.clone()),
            ("fits side by side", report.threads.to_string()),
            ("wall time", seconds(report.wall_s)),
            ("seed", report.seed.to_string()),
            ("data sets", report.data_sets.to_string()),
            ("revision", report.revision.clone()),
            ("finished", report.finished.clone()),
        ],
    );
    html.push_str("</header>");
}

/// What the thesis prints beside what we have, and what has to be known.
fn push_summary(html: &mut String, report: &GaussianReport) {
    let rows: Vec<&Row> = report
        .experiments
        .iter()
        .flat_map(|experiment| &experiment.rows)
        .filter(|row| table::verdict(row).is_some())
        .collect();
    html.push_str("<section class=\"summary\"><h2>In short</h2>");
    if !rows.is_empty() {
        let reached = rows.iter().filter(|row| table::verdict(row).is_some_and(|v| v.0)).count();
        let _ = write!(
            html,
            "<p class=\"headline\">The thesis prints figures for {} of these rows; {reached} of them are reached.</p>",
            rows.len()
        );
        push_table(html, &rows);
    }
    html.push_str("<h3>To be known</h3><ul>");
    for note in &report.notes {
        let _ = write!(html, "<li>{}</li>", escape(note));
    }
    html.push_str("</ul></section>");
}

fn push_experiment(html: &mut String, experiment: &ExperimentReport) {
    let _ = write!(
        html,
        "<section><h2 id=\"{}\">{}</h2><p>{}</p>",
        escape(&experiment.name),
        escape(&experiment.title),
        escape(&experiment.about)
    );
    push_table(html, &experiment.rows.iter().collect::<Vec<_>>());
    for sentence in experiment.rows.iter().filter_map(table::coverage) {
        let _ = write!(html, "<p>{}</p>", escape(&sentence));
    }
    for figure in &experiment.figures {
        push_figure(html, figure);
    }
    push_restarts(html, &experiment.rows);
    html.push_str("</section>");
}

fn push_table(html: &mut String, rows: &[&Row]) {
    html.push_str(
        "<div class=\"scroll\"><table class=\"rows\"><thead><tr><th>problem and method</th>",
    );
    for column in &table::COLUMNS {
        let _ = write!(html, "<th>{}</th>", column.head);
    }
    let forces = rows.iter().any(|row| row.err_f.is_some());
    if forces {
        html.push_str("<th>err_f</th>");
    }
    html.push_str("<th>against the thesis</th></tr></thead><tbody>");
    for row in rows {
        let label = &row.label;
        let _ = write!(
            html,
            "<tr><th scope=\"row\"><span class=\"key m-{}\"></span>{}<small>{} {}</small></th>",
            label.method.key(),
            escape(&label.problem),
            label.method.label(),
            escape(&label.setting)
        );
        for column in &table::COLUMNS {
            push_cell(html, &(column.cell)(row));
        }
        if forces {
            push_cell(html, &row.err_f.map(table::spread).unwrap_or_default());
        }
        match table::verdict(row) {
            Some((true, text)) => {
                let _ =
                    write!(html, "<td><small class=\"reached\">✓ {}</small></td>", escape(&text));
            }
            Some((false, text)) => {
                let _ =
                    write!(html, "<td><small class=\"missed\">✗ {}</small></td>", escape(&text));
            }
            None => html.push_str("<td></td>"),
        }
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table></div>");
}

fn push_cell(html: &mut String, cell: &table::Cell) {
    let _ = write!(html, "<td>{}", cell.value);
    if !cell.note.is_empty() {
        let _ = write!(html, "<small>{}</small>", cell.note);
    }
    html.push_str("</td>");
}

fn push_figure(html: &mut String, figure: &Figure) {
    let maps = figure.panels.iter().all(|panel| matches!(panel, Panel::Map(_)));
    let _ = write!(html, "<h3>{}</h3>", escape(&figure.title));
    if !figure.caption.is_empty() {
        let _ = write!(html, "<p class=\"note\">{}</p>", escape(&figure.caption));
    }
    let _ = write!(html, "<div class=\"{}\">", if maps { "grid4" } else { "grid2" });
    figure.panels.iter().for_each(|panel| html.push_str(&svg::panel(panel)));
    html.push_str("</div>");
}

/// Every restart of the first data set: what the best one was chosen from.
fn push_restarts(html: &mut String, rows: &[Row]) {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.restarts.len() > 1).collect();
    if rows.is_empty() {
        return;
    }
    html.push_str("<details><summary>All restarts on the first data set</summary><div class=\"scroll\"><table class=\"quantiles\"><thead><tr><th>method</th><th>restart</th><th>evaluations</th><th>log evidence</th><th>θ̂</th><th>collapsed</th></tr></thead>");
    for row in rows {
        html.push_str("<tbody>");
        let name =
            format!("{} {} {}", row.label.problem, row.label.method.label(), row.label.setting);
        for (number, end) in row.restarts.iter().enumerate() {
            let theta: Vec<String> = end.theta.iter().map(|value| digits(*value, 4)).collect();
            let _ = write!(
                html,
                "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{:.3}</td><td>{}</td><td>{}</td></tr>",
                if number == 0 { escape(&name) } else { String::new() },
                number + 1,
                end.evaluations,
                end.log_evidence,
                theta.join(", "),
                if end.collapsed { "yes" } else { "no" }
            );
        }
        html.push_str("</tbody>");
    }
    html.push_str("</table></div></details>");
}

fn push_provenance(html: &mut String, report: &GaussianReport) {
    let _ = write!(
        html,
        "<section><h2>How these numbers were made</h2><pre><code>{}</code></pre>{DEFINITIONS}",
        escape(&report.command)
    );
    page::push_configuration(html, &report.config, &report.versions);
    let _ = write!(
        html,
        "<p class=\"note\">The same numbers are in <code>report.json</code> (schema {}).</p></section>",
        report.schema
    );
}

const DEFINITIONS: &str = "<dl class=\"definitions\">\
<dt>err_u</dt><dd>mean |u − û| over a grid of the domain (4.50); û is the posterior mean, or the network.</dd>\
<dt>θ̂</dt><dd>the equation’s parameters at the fit; with several, in the order of the problem.</dd>\
<dt>‖θ − θ̂‖</dt><dd>Euclidean distance from the true values (4.50).</dd>\
<dt>HCGP, PCGP, UCGP</dt><dd>Gaussian process with the boundary conditions built in, with N_b pseudo-observations of them, without them.</dd>\
<dt>HCNN</dt><dd>neural network with the boundary conditions built in.</dd>\
<dt>seconds</dt><dd>one fit on one thread: prior, model, all restarts; with NUTS the sampling too.</dd>\
<dt>evaluations</dt><dd>of evidence (or loss) and gradient, over all restarts; empty where they are not counted.</dd>\
<dt>jitter</dt><dd>largest relative jitter that a covariance needed at the end of a fit.</dd>\
<dt>collapsed</dt><dd>data sets whose fit explains less than a tenth of what was measured and takes the rest for noise.</dd>\
<dt>maps</dt><dd>circles: u observed; crosses: equation imposed.</dd></dl>";
