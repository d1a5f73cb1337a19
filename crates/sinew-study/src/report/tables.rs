//! Tables of errors and times.

use std::fmt::Write;

use super::format::{digits, escape, factor, seconds, two_digits};
use super::plots::{class, emulators, thesis_median};
use super::summary::Verdict;
use super::{Method, MethodRow, Metric, SceneReport};

/// `err<sub>u</sub>`
pub(super) fn symbol(metric: Metric) -> String {
    format!("err<sub>{}</sub>", metric.subscript())
}

/// Median errors and times side by side.
pub(super) fn overview(scene: &SceneReport) -> String {
    let mut html = String::from(
        r#"<div class="scroll"><table class="overview"><thead><tr><th rowspan="2">method</th><th colspan="4" class="group">median error</th><th colspan="3" class="group">once</th><th colspan="3" class="group">per prediction</th></tr><tr>"#,
    );
    for metric in Metric::ALL {
        let _ = write!(html, "<th>{} <small>[{}]</small></th>", symbol(metric), metric.unit());
    }
    html.push_str(
        "<th>prepare</th><th>train</th><th>steps</th><th>full</th><th>decoder</th><th>in a batch</th></tr></thead><tbody>",
    );
    let best = Best::of(scene);
    let mut solvers = false;
    for row in scene.ordered_rows() {
        let first_solver = !row.method().is_emulator() && !solvers;
        solvers |= first_solver;
        html.push_str(if first_solver { "<tr class=\"solver\">" } else { "<tr>" });
        push_overview_row(&mut html, scene, row, &best);
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table></div>");
    html
}

fn push_overview_row(html: &mut String, scene: &SceneReport, row: &MethodRow, best: &Best) {
    let emulator = row.method().is_emulator();
    let cell = |is_best: bool| {
        if is_best && emulator { "<td class=\"best\">" } else { "<td>" }
    };
    let _ = write!(html, "<th scope=\"row\">{}</th>", name(row));
    for (metric, least) in Metric::ALL.into_iter().zip(best.errors) {
        let median = row.median(metric);
        let _ = write!(html, "{}{}", cell(median == least), two_digits(median));
        if let Some(thesis) = thesis_median(scene, row.method(), metric) {
            let verdict = Verdict::of(median, thesis);
            let _ = write!(
                html,
                "<small class=\"{}\">{} {} thesis</small>",
                verdict.class(),
                verdict.sign(),
                factor(median / thesis)
            );
        }
        html.push_str("</td>");
    }
    let times = row.times();
    let steps = match times.steps {
        0 => "–".to_owned(),
        steps => super::format::count(steps),
    };
    let once =
        [times.prepare_s, times.train_s].map(|t| if t == 0.0 { "–".into() } else { seconds(t) });
    let _ = write!(html, "<td>{}</td><td>{}</td><td>{steps}</td>", once[0], once[1]);
    let fem = scene.row(Method::FemWarm).map(prediction_times);
    for (column, time) in prediction_times(row).into_iter().enumerate() {
        let _ = write!(html, "{}{}", cell(time == best.times[column]), seconds(time));
        if let Some(fem) = fem.filter(|_| row.method() != Method::FemWarm) {
            let _ = write!(html, "<small>{}</small>", against(fem[column] / time));
        }
        html.push_str("</td>");
    }
}

/// How often a prediction fits into a warm finite-element solve.
fn against(ratio: f64) -> String {
    match ratio {
        ratio if !ratio.is_finite() || ratio <= 0.0 => String::new(),
        ratio if ratio >= 1.0 => format!("{} faster", factor(ratio)),
        ratio => format!("<span class=\"missed\">{} slower</span>", factor(1.0 / ratio)),
    }
}

fn prediction_times(row: &MethodRow) -> [f64; 3] {
    let times = row.times();
    [times.predict_full_s, times.predict_decoder_s, times.predict_batch_per_theta_s]
}

/// Least error and time of every column among the emulators.
struct Best {
    errors: [f64; 4],
    times: [f64; 3],
}

impl Best {
    fn of(scene: &SceneReport) -> Self {
        let rows = emulators(scene);
        let least = |value: &dyn Fn(&MethodRow) -> f64| {
            rows.iter().map(|row| value(row)).fold(f64::INFINITY, f64::min)
        };
        Self {
            errors: Metric::ALL.map(|metric| least(&|row| row.median(metric))),
            times: [0, 1, 2].map(|column| least(&|row| prediction_times(row)[column])),
        }
    }
}

fn name(row: &MethodRow) -> String {
    format!(
        "<span class=\"key {}\"></span>{}<small>{}</small>",
        class(row.method()),
        row.method().label(),
        escape(row.description())
    )
}

/// What every error is measured against: one line per reference.
pub(super) fn references(scene: &SceneReport) -> String {
    let rows = scene.ordered_rows();
    let mut references: Vec<&str> = rows.iter().map(|row| row.reference()).collect();
    let mut seen = Vec::new();
    references.retain(|text| {
        !seen.contains(text) && {
            seen.push(*text);
            true
        }
    });
    let mut html = String::from("<p class=\"note\">Errors are measured ");
    let parts: Vec<String> = references
        .iter()
        .map(|reference| {
            let methods: Vec<&str> = rows
                .iter()
                .filter(|row| row.reference() == *reference)
                .map(|row| row.method().label())
                .collect();
            format!("for <b>{}</b> against {}", methods.join(", "), escape(reference))
        })
        .collect();
    html.push_str(&parts.join("; "));
    html.push_str(
        ". The best emulator of every column is marked; solvers have another reference and take no part. Faster and slower: than the same column of FEM warm.</p>",
    );
    html
}

/// All quantiles of all measures.
pub(super) fn all_quantiles(scene: &SceneReport) -> String {
    let mut html = String::from(
        "<div class=\"scroll\"><table class=\"quantiles\"><thead><tr><th>error</th><th>method</th><th>2.5 %</th><th>25 %</th><th>median</th><th>75 %</th><th>97.5 %</th><th>largest</th><th>mean</th></tr></thead>",
    );
    let rows = scene.ordered_rows();
    for metric in Metric::ALL {
        html.push_str("<tbody>");
        for (index, row) in rows.iter().enumerate() {
            html.push_str("<tr>");
            if index == 0 {
                let _ = write!(
                    html,
                    "<th rowspan=\"{}\">{} <small>[{}], per {}</small></th>",
                    rows.len(),
                    symbol(metric),
                    metric.unit(),
                    metric.sampled_per()
                );
            }
            let (class, label) = (class(row.method()), row.method().label());
            let _ =
                write!(html, "<th scope=\"row\"><span class=\"key {class}\"></span>{label}</th>");
            for (name, value) in row.errors().get(metric).entries() {
                let tag = if name == "q50" { "<td class=\"median\">" } else { "<td>" };
                let _ = write!(html, "{tag}{}</td>", digits(value, 3));
            }
            html.push_str("</tr>");
        }
        html.push_str("</tbody>");
    }
    html.push_str("</table></div>");
    html
}
