//! `report.html`: one file without scripts, fonts or links.

use std::fmt::Write;

use super::format::{count, digits, escape, seconds, two_digits};
use super::plots::{self, class, emulators};
use super::{Method, Metric, Report, SceneReport, SurfaceCases, page, shapes, summary, tables};

/// The whole page.
pub fn render(report: &Report) -> String {
    let title = page_title(report);
    let mut html = page::start(&title, "");
    push_head(&mut html, report);
    push_summary(&mut html, report);
    for scene in &report.scenes {
        push_scene(&mut html, scene);
    }
    push_provenance(&mut html, report);
    html.push_str(page::END);
    html
}

fn page_title(report: &Report) -> String {
    let scenes: Vec<_> = report.scenes.iter().map(|s| s.title.as_str()).collect();
    escape(&format!("Emulators against finite elements: {}", scenes.join(", ")))
}

fn push_head(html: &mut String, report: &Report) {
    let scenes: Vec<_> = report.scenes.iter().map(|s| escape(&s.title)).collect();
    let methods: Vec<&str> = Method::ALL
        .into_iter()
        .filter(|&method| report.scenes.iter().any(|scene| scene.row(method).is_some()))
        .map(Method::label)
        .collect();
    let _ = write!(
        html,
        "<header><h1>Emulators against finite elements</h1><p>{} on {}: error and time on the same meshes, parameters and machine.</p>",
        methods.join(", "),
        scenes.join(" and ")
    );
    page::push_facts(
        html,
        &[
            ("machine", report.machine.clone()),
            ("threads", report.threads.to_string()),
            ("wall time", seconds(report.wall_s)),
            ("seed", report.seed.to_string()),
            ("revision", report.revision.clone()),
            ("finished", report.finished.clone()),
        ],
    );
    html.push_str("</header>");
}

fn push_summary(html: &mut String, report: &Report) {
    html.push_str("<section class=\"summary\"><h2>In short</h2>");
    let headline = summary::headline(report);
    if !headline.is_empty() {
        let _ = write!(html, "<p class=\"headline\">{headline}</p>");
    }
    for scene in &report.scenes {
        let _ = write!(html, "<h3>{}</h3><ul>", escape(&scene.title));
        for sentence in summary::scene(scene) {
            let _ = write!(html, "<li>{sentence}</li>");
        }
        html.push_str("</ul>");
        html.push_str(&summary::thesis_table(scene));
    }
    if !report.notes.is_empty() {
        html.push_str("<h3>To be known</h3><ul>");
        for note in &report.notes {
            let _ = write!(html, "<li>{}</li>", escape(note));
        }
        html.push_str("</ul>");
    }
    html.push_str("</section>");
}

fn push_scene(html: &mut String, scene: &SceneReport) {
    let _ = write!(
        html,
        "<section><h2 id=\"{}\">{}</h2><p>{}</p>",
        escape(&scene.name),
        escape(&scene.title),
        escape(&scene.description)
    );
    push_scene_facts(html, scene);
    html.push_str("<h3>Error and time</h3>");
    html.push_str(&tables::overview(scene));
    html.push_str(&tables::references(scene));
    push_scatter(html, scene);
    push_densities(html, scene);
    push_training(html, scene);
    if let Some(surfaces) = &scene.surfaces {
        push_surfaces(html, surfaces);
    }
    html.push_str("<h3>All quantiles</h3>");
    html.push_str(&tables::all_quantiles(scene));
    html.push_str("</section>");
}

fn push_scene_facts(html: &mut String, scene: &SceneReport) {
    let mesh = &scene.mesh;
    let theta: Vec<String> = scene
        .theta
        .iter()
        .map(|t| {
            let range = format!("{} ∈ [{}, {}]", t.name, t.low, t.high);
            format!("{range} {}", t.unit).trim_end().to_owned()
        })
        .collect();
    let displacement = &scene.displacement;
    let mut size = format!(
        "mean {} mm, largest {} mm",
        digits(displacement.mean_mm, 3),
        digits(displacement.max_mm, 3)
    );
    if let Some(thesis) = scene.thesis.as_ref().and_then(|thesis| thesis.displacement) {
        let (mean, max) = (digits(thesis.mean_mm, 3), digits(thesis.max_mm, 3));
        let _ = write!(size, " (thesis: {mean} and {max} mm)");
    }
    page::push_facts(
        html,
        &[
            (
                "mesh",
                format!(
                    "{} nodes, {} elements, {} unknowns",
                    count(mesh.nodes as u64),
                    count(mesh.elements as u64),
                    count(mesh.unknowns as u64)
                ),
            ),
            ("parameters", theta.join(", ")),
            ("displacement", size),
            ("samples", format!("{} training, {} test", scene.train_samples, scene.test_samples)),
            ("units", scene.units.clone()),
        ],
    );
}

fn push_scatter(html: &mut String, scene: &SceneReport) {
    let _ = write!(
        html,
        "<h3>Speed against error</h3><figure>{}<figcaption>Median displacement error and time of one prediction. Filled: one prediction on the known geometry. Open: everything from scratch; small: per prediction in a batch. Lower left is better. The error of a solver is measured against the reference named under the table.</figcaption></figure>",
        plots::scatter(scene)
    );
}

fn push_densities(html: &mut String, scene: &SceneReport) {
    if emulators(scene).is_empty() {
        return;
    }
    let methods: Vec<Method> = emulators(scene).iter().map(|row| row.method()).collect();
    let _ = write!(html, "<h3>Error densities</h3>{}<div class=\"grid2\">", legend(&methods));
    for metric in Metric::ALL {
        let _ = write!(
            html,
            "<figure><figcaption>Error in {} {}</figcaption>{}</figure>",
            metric.quantity(),
            per(metric),
            plots::density(scene, metric)
        );
    }
    html.push_str("</div>");
    let outside = emulators(scene)
        .iter()
        .map(|row| row.histograms().err_u_mm.share_outside())
        .fold(0.0, f64::max);
    html.push_str("<p class=\"note\">Kernel densities of log₁₀ of all test errors. Dashed lines are medians of all samples; triangles on the axis are the thesis’ medians (for the hybrid the better of its two methods).");
    if outside > 0.0 {
        let _ = write!(
            html,
            " Errors that are exactly zero, as at clamped nodes ({} % of the nodes), have no place on a logarithmic axis; medians and quantiles include them.",
            two_digits(100.0 * outside)
        );
    }
    push_solver_note(html, scene);
    html.push_str("</p>");
}

/// Where the solver would be, which the densities leave out.
fn push_solver_note(html: &mut String, scene: &SceneReport) {
    let solver = scene.row(Method::FemCold).or_else(|| scene.row(Method::FemWarm));
    if let Some(row) = solver {
        let _ = write!(
            html,
            " {} is left out: its median displacement error is {} mm, measured against {}.",
            row.method().label(),
            two_digits(row.median(Metric::ErrU)),
            escape(row.reference())
        );
    }
}

fn per(metric: Metric) -> String {
    let each = metric.sampled_per();
    match metric {
        Metric::ErrPi => format!("(per {each})"),
        _ => format!("(per {each} and test case)"),
    }
}

fn push_training(html: &mut String, scene: &SceneReport) {
    if scene.training.iter().all(|history| history.curve.is_empty()) {
        return;
    }
    let methods: Vec<Method> = emulators(scene).iter().map(|row| row.method()).collect();
    let _ =
        write!(html, "<h3>Error over training time</h3>{}<div class=\"grid2\">", legend(&methods));
    for metric in Metric::ALL {
        let _ = write!(
            html,
            "<figure><figcaption>Error in {}</figcaption>{}</figure>",
            metric.quantity(),
            plots::training_curve(scene, metric)
        );
    }
    html.push_str("</div><p class=\"note\">Medians over the validation cases. Time is that of training; the evaluations themselves are not counted. Dotted lines are the thesis’ medians. A single marker is a method without training steps.");
    push_preparation(html, scene);
    html.push_str("</p>");
    if let Some(svg) = plots::energy_traces(scene) {
        let _ = write!(
            html,
            "<h3>Energy during training</h3>{}<figure>{svg}<figcaption>Mean of (Π(û) − Π(u)) / |Π(u)| over the validation cases, u from the finite-element solver. The solution is a minimum, so the excess tends to zero from above; values at or below zero (rounding) are not drawn.</figcaption></figure>",
            legend(&scene.training.iter().map(|h| h.method).collect::<Vec<_>>())
        );
    }
}

/// Training time is not all: some methods need simulations before.
fn push_preparation(html: &mut String, scene: &SceneReport) {
    let rows = emulators(scene);
    let parts: Vec<String> = rows
        .iter()
        .filter(|row| row.times().prepare_s > 0.0)
        .map(|row| format!("{} {}", row.method().label(), seconds(row.times().prepare_s)))
        .collect();
    if !parts.is_empty() {
        let _ = write!(html, " Preparation comes on top: {}.", parts.join(", "));
    }
}

fn push_surfaces(html: &mut String, surfaces: &SurfaceCases) {
    if surfaces.cases().is_empty() {
        return;
    }
    let _ = write!(
        html,
        "<h3>Where the errors are</h3><p class=\"note\">Predicted deformed shapes, coloured by the displacement error per node on one logarithmic scale for all; dashed: the undeformed body. Deformations are to scale.</p>{}",
        shapes::render(surfaces)
    );
}

/// Colours and names of methods.
fn legend(methods: &[Method]) -> String {
    let mut html = String::from("<p class=\"legend\">");
    for &method in methods {
        let _ = write!(
            html,
            "<span><svg viewBox=\"0 0 30 12\"><path class=\"line {0}\" d=\"M1 6H29\"/><path class=\"dot {0}\" transform=\"translate(15 6)\" d=\"{1}\"/></svg>{2}</span>",
            class(method),
            plots::marker(method, 4.0),
            method.label()
        );
    }
    html.push_str("</p>");
    html
}

fn push_provenance(html: &mut String, report: &Report) {
    let _ = write!(
        html,
        "<section><h2>How these numbers were made</h2><pre><code>{}</code></pre>",
        escape(&report.command)
    );
    html.push_str(DEFINITIONS);
    page::push_configuration(html, &report.config, &report.versions);
    let _ = write!(
        html,
        "<p class=\"note\">The same numbers are in <code>report.json</code> (schema {}), those of every test case in <code>samples.csv</code>.</p></section>",
        report.schema
    );
}

const DEFINITIONS: &str = "<dl class=\"definitions\">\
<dt>err<sub>u</sub></dt><dd>‖u − û‖₂ at every node [mm]; u is the reference, û the prediction.</dd>\
<dt>err<sub>F</sub></dt><dd>‖F − F̂‖<sub>F</sub> / ‖F‖<sub>F</sub> in every element [%].</dd>\
<dt>err<sub>I₁</sub></dt><dd>|I₁ − Î₁| / I₁ in every element [%].</dd>\
<dt>err<sub>Π</sub></dt><dd>|Π − Π̂| / |Π| of every test case [%].</dd>\
<dt>quantiles</dt><dd>over all nodes or elements of all test cases together, linearly interpolated.</dd>\
<dt>densities</dt><dd>Gaussian kernel on log₁₀ of the error, bandwidth 0.9 min(σ, IQR/1.34) n<sup>−1/5</sup> and at least 0.08 decades, from a histogram with 32 bins per decade.</dd>\
<dt>prepare</dt><dd>everything before training: simulations for training data, graph, basis.</dd>\
<dt>train</dt><dd>training or regression, without the evaluations that make the curves.</dd>\
<dt>full</dt><dd>one prediction for one θ from mesh and θ (emulators: message passing and decoder).</dd>\
<dt>decoder</dt><dd>one prediction for one θ on a geometry whose part is computed already; for a solver the same as full.</dd>\
<dt>in a batch</dt><dd>time per θ when many are predicted at once.</dd></dl>";
