//! The figures of a scene: densities, curves, scatter and energy traces.

use super::axis::Axis;
use super::chart::{Chart, Marker};
use super::format::{seconds, two_digits};
use super::labels::{Extent, place_labels};
use super::{Method, MethodRow, Metric, SceneReport, TrainingHistory};

/// Size of a plot of which two stand side by side \[px\].
const HALF: (f64, f64) = (470.0, 290.0);
/// Size of a plot that stands alone \[px\].
const WIDE: (f64, f64) = (960.0, 440.0);
/// Densities below this share of the highest are not given room on the axis.
const VISIBLE_DENSITY: f64 = 2e-3;
/// Size of markers \[px\].
const RADIUS: f64 = 4.5;
const SMALL_RADIUS: f64 = 3.2;

/// CSS class that carries the colour and the dashes of a method.
pub(super) fn class(method: Method) -> String {
    format!("m-{}", method.key())
}

/// Path of a method's marker around the origin.
pub(super) fn marker(method: Method, radius: f64) -> String {
    let marker = match method {
        Method::Dd => Marker::Circle,
        Method::Pi => Marker::Triangle,
        Method::Hybrid => Marker::TriangleDown,
        Method::Fdd => Marker::Diamond,
        Method::Pod => Marker::Square,
        Method::FemCold => Marker::Cross,
        Method::FemWarm => Marker::Plus,
    };
    marker.path(radius)
}

/// `err_u \[mm\]` with a subscript, for SVG.
fn axis_name(prefix: &str, metric: Metric) -> String {
    format!(
        r#"{prefix}err<tspan class="sub" dy="3">{}</tspan><tspan dy="-3"> [{}]</tspan>"#,
        metric.subscript(),
        metric.unit()
    )
}

/// Kernel densities of one measure on a logarithmic axis, with medians, as in thesis
/// Figs 3.3 and 3.4; emulators only, for a solver differs by orders of magnitude.
pub(super) fn density(scene: &SceneReport, metric: Metric) -> String {
    let rows: Vec<&MethodRow> = emulators(scene);
    let densities: Vec<_> = rows.iter().map(|row| row.histograms().get(metric).density()).collect();
    let highest = densities.iter().flatten().map(|p| p.1).fold(0.0, f64::max);
    let visible = densities.iter().flatten().filter(|p| p.1 > VISIBLE_DENSITY * highest);
    let thesis = rows.iter().filter_map(|row| thesis_median(scene, row.method(), metric));
    let x = Axis::log(axis_name("", metric), visible.map(|p| 10f64.powf(p.0)).chain(thesis));
    let y = Axis::from_zero("density per decade", densities.iter().flatten().map(|p| p.1));
    let title = format!("Density of the error in {} of {}", metric.quantity(), scene.title);
    let mut chart = Chart::new(HALF, &title, x, y);
    for (row, density) in rows.iter().zip(&densities) {
        let points: Vec<_> = density.iter().map(|&(log, d)| (10f64.powf(log), d)).collect();
        let class = class(row.method());
        chart.area(&class, &points);
        chart.line(&class, &points);
    }
    for row in &rows {
        chart.vertical(&class(row.method()), row.median(metric));
        if let Some(median) = thesis_median(scene, row.method(), metric) {
            let hint = format!("thesis, {}: {}", row.method().label(), two_digits(median));
            chart.pointer(&class(row.method()), median, &hint);
        }
    }
    chart.render()
}

/// Median error over training time, with the thesis' median as a dotted line and
/// methods without steps as one point.
pub(super) fn training_curve(scene: &SceneReport, metric: Metric) -> String {
    let curves: Vec<(&TrainingHistory, Vec<(f64, f64)>)> = histories(scene)
        .map(|history| {
            let point = |p: &super::CurvePoint| p.errors.get(metric).map(|e| (p.train_s, e));
            (history, history.curve.iter().filter_map(point).collect())
        })
        .collect();
    let single: Vec<&MethodRow> = emulators(scene)
        .into_iter()
        .filter(|row| histories(scene).all(|history| history.method != row.method()))
        .collect();
    let thesis: Vec<_> = histories(scene)
        .filter_map(|h| Some((h.method, thesis_median(scene, h.method, metric)?)))
        .collect();
    let points = curves.iter().flat_map(|(_, points)| points.iter().copied());
    let all: Vec<_> =
        points.chain(single.iter().map(|row| (row.times().train_s, row.median(metric)))).collect();
    let x = Axis::log("training time [s]", all.iter().map(|p| p.0));
    let y = Axis::log(
        axis_name("median ", metric),
        all.iter().map(|p| p.1).chain(thesis.iter().map(|t| t.1)),
    );
    let title = format!("Error in {} over training time, {}", metric.quantity(), scene.title);
    let mut chart = Chart::new(HALF, &title, x, y);
    for &(method, median) in &thesis {
        chart.horizontal(&format!("thesis {}", class(method)), median);
    }
    for (history, points) in &curves {
        let method = history.method;
        chart.line(&class(method), points);
        if let Some(&last) = points.last() {
            mark(&mut chart, method, last, metric);
        }
    }
    for row in single {
        let point = (row.times().train_s, row.median(metric));
        mark(&mut chart, row.method(), point, metric);
    }
    chart.render()
}

fn mark(chart: &mut Chart, method: Method, point: (f64, f64), metric: Metric) {
    let (time, error) = (seconds(point.0), two_digits(point.1));
    let hint = format!("{}: {error} {} after {time}", method.label(), metric.unit());
    chart.marker(&format!("dot {}", class(method)), &marker(method, RADIUS), point, &hint);
}

/// Time of a prediction against median displacement error; every method has up to
/// three points, joined by a line: one θ from scratch, one θ on a known geometry, batch.
pub(super) fn scatter(scene: &SceneReport) -> String {
    let rows = scene.ordered_rows();
    let metric = Metric::ErrU;
    let times = |row: &MethodRow| {
        let times = row.times();
        [
            ("from scratch", times.predict_full_s),
            ("known geometry", times.predict_decoder_s),
            ("in a batch", times.predict_batch_per_theta_s),
        ]
    };
    let x = Axis::log(
        "time per prediction [s]",
        // Room for labels on the right.
        rows.iter()
            .flat_map(|row| times(row).map(|t| t.1))
            .chain(rows.iter().map(|row| 2.5 * row.times().predict_full_s)),
    );
    let y = Axis::log(axis_name("median ", metric), rows.iter().map(|row| row.median(metric)));
    let title = format!("Time per prediction against error, {}", scene.title);
    let mut chart = Chart::new(WIDE, &title, x, y);
    let mut labels = Vec::new();
    for row in &rows {
        let (method, error) = (row.method(), row.median(metric));
        let points = times(row).map(|(_, time)| (time, error));
        chart.line(&class(method), &points);
        let styles = [("ring", RADIUS), ("dot", RADIUS), ("ring", SMALL_RADIUS)];
        for ((what, time), (style, radius)) in times(row).into_iter().zip(styles) {
            let hint = format!("{}, {what}: {}", method.label(), seconds(time));
            let style = format!("{style} {}", class(method));
            chart.marker(&style, &marker(method, radius), (time, error), &hint);
        }
        let pixels = points.iter().filter_map(|&point| chart.pixel(point));
        labels.extend(Extent::around(pixels, RADIUS).map(|extent| (method, extent)));
    }
    place_labels(&mut chart, labels);
    chart.render()
}

/// Mean energy above the finite-element minimum during training; `None` without data.
pub(super) fn energy_traces(scene: &SceneReport) -> Option<String> {
    let traces: Vec<(Method, Vec<(f64, f64)>)> = histories(scene)
        .map(|history| {
            let points = history.energy.iter();
            let drawn = points.filter_map(|p| Some((p.train_s, p.excess_pct?)));
            (history.method, drawn.collect())
        })
        .collect();
    let all = || traces.iter().flat_map(|(_, points)| points).filter(|p| p.1 > 0.0);
    all().next()?;
    let x = Axis::log("training time [s]", all().map(|p| p.0));
    let y = Axis::log("mean energy above FEM [%]", all().map(|p| p.1));
    let title = format!("Energy during training, {}", scene.title);
    let mut chart = Chart::new((WIDE.0, 320.0), &title, x, y);
    for (method, points) in &traces {
        chart.line(&class(*method), points);
        if let Some(&last) = points.iter().rev().find(|p| p.1 > 0.0) {
            let hint = format!("{}: {} %", method.label(), two_digits(last.1));
            chart.marker(&format!("dot {}", class(*method)), &marker(*method, RADIUS), last, &hint);
        }
    }
    Some(chart.render())
}

/// Rows of the methods that approximate the finite-element solution.
pub(super) fn emulators(scene: &SceneReport) -> Vec<&MethodRow> {
    let mut rows = scene.ordered_rows();
    rows.retain(|row| row.method().is_emulator());
    rows
}

fn histories(scene: &SceneReport) -> impl Iterator<Item = &TrainingHistory> {
    scene.training.iter().filter(|history| !history.curve.is_empty())
}

/// What the thesis reached in place of a method, if it prints it.
pub(super) fn thesis_median(scene: &SceneReport, method: Method, metric: Metric) -> Option<f64> {
    scene.thesis.as_ref()?.median(method, metric)
}
