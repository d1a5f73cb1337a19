//! What the numbers say, in sentences made from the numbers.

use super::format::{count, digits_rounded, escape, factor, seconds, two_digits};
use super::plots::{emulators, thesis_median};
use super::tables::symbol;
use super::{Method, MethodRow, Metric, Report, SceneReport};

/// A median up to this factor above the thesis' counts as reached: networks trained for
/// minutes on two cores against a million steps on a GPU.
pub(super) const REACHED_FACTOR: f64 = 3.0;

/// How a median compares with the thesis'.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Better,
    Reached,
    Missed,
}

impl Verdict {
    pub(super) fn of(ours: f64, thesis: f64) -> Self {
        match ours / thesis {
            ratio if ratio <= 1.0 => Self::Better,
            ratio if ratio <= REACHED_FACTOR => Self::Reached,
            _ => Self::Missed,
        }
    }

    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Reached => "reached",
            Self::Missed => "missed",
        }
    }

    pub(super) fn sign(self) -> &'static str {
        match self {
            Self::Better | Self::Reached => "✓",
            Self::Missed => "✗",
        }
    }
}

/// One of our medians beside the thesis'.
struct Comparison {
    method: Method,
    metric: Metric,
    ours: f64,
    thesis: f64,
}

impl Comparison {
    fn verdict(&self) -> Verdict {
        Verdict::of(self.ours, self.thesis)
    }

    /// `err_u of DD-GNN 7.1×10⁻³ mm, 1.1× the thesis' 6.5×10⁻³`
    fn sentence(&self) -> String {
        let ratio = self.ours / self.thesis;
        format!(
            "{} of {} {} {}, {} the thesis’ {}",
            symbol(self.metric),
            self.method.label(),
            two_digits(self.ours),
            self.metric.unit(),
            factor(ratio),
            two_digits(self.thesis)
        )
    }

    fn cell(&self) -> String {
        let verdict = self.verdict();
        format!(
            "<td>{} {}<small class=\"{}\">{} {} the thesis’ {}</small></td>",
            two_digits(self.ours),
            self.metric.unit(),
            verdict.class(),
            verdict.sign(),
            factor(self.ours / self.thesis),
            two_digits(self.thesis)
        )
    }
}

fn comparisons(scene: &SceneReport) -> Vec<Comparison> {
    let mut found = Vec::new();
    for row in emulators(scene) {
        for metric in Metric::ALL {
            if let Some(thesis) = thesis_median(scene, row.method(), metric) {
                found.push(Comparison {
                    method: row.method(),
                    metric,
                    ours: row.median(metric),
                    thesis,
                });
            }
        }
    }
    found
}

/// One sentence over all scenes; empty if nothing is compared with the thesis.
pub(super) fn headline(report: &Report) -> String {
    let all: Vec<Comparison> = report.scenes.iter().flat_map(comparisons).collect();
    let reached = all.iter().filter(|c| c.verdict() != Verdict::Missed).count();
    let better = all.iter().filter(|c| c.verdict() == Verdict::Better).count();
    let total = all.len();
    let factor = REACHED_FACTOR;
    match total {
        0 => String::new(),
        _ if reached == total => format!(
            "All {total} medians that the thesis prints are reached within {factor}×; {better} are better than the thesis’."
        ),
        _ => format!(
            "{reached} of {total} medians that the thesis prints are reached within {factor}× ({better} are better than the thesis’); <b class=\"missed\">{} {} not</b>.",
            total - reached,
            if total - reached == 1 { "is" } else { "are" }
        ),
    }
}

/// Paragraphs on one scene: who is most accurate, the thesis, speed, when it pays.
pub(super) fn scene(scene: &SceneReport) -> Vec<String> {
    [accuracy(scene), against_thesis(scene), speed(scene), payback(scene)]
        .into_iter()
        .flatten()
        .collect()
}

fn accuracy(scene: &SceneReport) -> Option<String> {
    let rows = emulators(scene);
    if rows.len() < 2 {
        return None;
    }
    let parts: Vec<String> = Metric::ALL
        .into_iter()
        .map(|metric| {
            let mut ranked = rows.clone();
            ranked.sort_by(|a, b| a.median(metric).total_cmp(&b.median(metric)));
            let (first, second) = (ranked[0], ranked[1]);
            format!(
                "{} <b>{}</b> ({} {}; {} {})",
                symbol(metric),
                first.method().label(),
                two_digits(first.median(metric)),
                metric.unit(),
                second.method().label(),
                behind(second.median(metric) / first.median(metric))
            )
        })
        .collect();
    Some(format!("<b>Most accurate by median:</b> {}.", parts.join(", ")))
}

/// `3.1× as much`, for the second in rank.
fn behind(ratio: f64) -> String {
    match ratio {
        ratio if !ratio.is_finite() => "more".into(),
        ratio if ratio < 1.05 => "the same".into(),
        ratio => format!("{} as much", factor(ratio)),
    }
}

fn against_thesis(scene: &SceneReport) -> Option<String> {
    let all = comparisons(scene);
    if all.is_empty() {
        return None;
    }
    let missed: Vec<String> = all
        .iter()
        .filter(|comparison| comparison.verdict() == Verdict::Missed)
        .map(Comparison::sentence)
        .collect();
    let mut text = format!(
        "<b>Against the thesis:</b> {} of {} medians reached within {REACHED_FACTOR}×.",
        all.len() - missed.len(),
        all.len()
    );
    if !missed.is_empty() {
        let list = missed.join("; ");
        text.push_str(&format!(" <b class=\"missed\">✗ Not reached:</b> {list}."));
    }
    Some(text)
}

/// All our medians beside the thesis'; empty if there is nothing to compare.
pub(super) fn thesis_table(scene: &SceneReport) -> String {
    let all = comparisons(scene);
    if all.is_empty() {
        return String::new();
    }
    let mut html =
        String::from("<div class=\"scroll\"><table class=\"thesis\"><thead><tr><th>median</th>");
    for metric in Metric::ALL {
        html.push_str(&format!("<th>{}</th>", symbol(metric)));
    }
    html.push_str("</tr></thead><tbody>");
    for method in Method::ALL {
        let of_method = |metric| all.iter().find(|c| c.method == method && c.metric == metric);
        if Metric::ALL.iter().all(|&metric| of_method(metric).is_none()) {
            continue;
        }
        html.push_str(&format!("<tr><th scope=\"row\">{}</th>", method.label()));
        for metric in Metric::ALL {
            html.push_str(&of_method(metric).map_or("<td>–</td>".into(), Comparison::cell));
        }
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table></div>");
    html
}

fn speed(scene: &SceneReport) -> Option<String> {
    let (cold, warm) = (scene.row(Method::FemCold), scene.row(Method::FemWarm));
    let fem: Vec<String> = [cold, warm]
        .into_iter()
        .flatten()
        .map(|row| format!("{} {}", row.method().label(), seconds(row.times().predict_decoder_s)))
        .collect();
    let baseline = warm.or(cold);
    let ours: Vec<String> = emulators(scene)
        .into_iter()
        .map(|row| {
            let time = row.times().predict_decoder_s;
            let against = baseline.map(|fem| fem.times().predict_decoder_s / time);
            let comparison = match against {
                Some(ratio) if ratio.is_finite() && ratio >= 1.0 => {
                    format!(" ({} faster)", factor(ratio))
                }
                Some(ratio) if ratio > 0.0 && ratio < 1.0 => {
                    format!(" (<b class=\"missed\">{} slower</b>)", factor(1.0 / ratio))
                }
                _ => String::new(),
            };
            format!("{} {}{comparison}", row.method().label(), seconds(time))
        })
        .collect();
    if ours.is_empty() {
        return None;
    }
    let against =
        baseline.map_or(String::new(), |row| format!(", compared with {}", row.method().label()));
    let all = fem.into_iter().chain(ours).collect::<Vec<_>>().join(", ");
    Some(format!("<b>One prediction on this geometry{against}:</b> {all}."))
}

/// After how many predictions preparation and training have paid off.
fn payback(scene: &SceneReport) -> Option<String> {
    let fem = scene.row(Method::FemWarm).or_else(|| scene.row(Method::FemCold))?;
    let parts: Vec<String> = emulators(scene)
        .into_iter()
        .map(|row| {
            let after = predictions_to_pay(row, fem);
            let label = row.method().label();
            match after {
                Some(number) => format!("{label} after {} predictions", count(number)),
                None => format!("<b class=\"missed\">{label} never</b>"),
            }
        })
        .collect();
    (!parts.is_empty()).then(|| {
        format!(
            "<b>Preparation and training pay off</b> against {}: {}.",
            escape(fem.method().label()),
            parts.join(", ")
        )
    })
}

fn predictions_to_pay(row: &MethodRow, fem: &MethodRow) -> Option<u64> {
    let saved = fem.times().predict_decoder_s - row.times().predict_decoder_s;
    let spent = row.times().prepare_s + row.times().train_s;
    (saved > 0.0).then(|| digits_rounded((spent / saved).ceil(), 2) as u64)
}
