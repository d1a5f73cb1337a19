//! Drawings of what a fit says of u.

use crate::gp::inference::{Inference, Observed};
use crate::gp::row::Row;
use sinew_gp::{Conditional, Domain, Fit, GpError};
use sinew_report::format;
use sinew_report::{Chart, Distribution, Figure, Level, Series, Style};

/// Half-width of a 95 % band in standard deviations.
const BAND: f64 = 1.959_964;
const CURVE_POINTS: usize = 101;
/// Points of a curve in a check.
const FEW_POINTS: usize = 11;

/// Solution and posterior mean with its band: on an interval, else along the first axis through the middle of the domain.
pub(crate) fn posterior<const D: usize>(
    inference: &Inference<D>,
    conditional: &Conditional<D>,
    observed: &Observed<D>,
    fit: &Fit<D>,
) -> Result<Figure, GpError> {
    let (setting, scale) = (&inference.setting, inference.scale);
    let domain = setting.problem.domain();
    let label = inference.approach.method().label();
    let points = along_first(domain, scale.pick(CURVE_POINTS, FEW_POINTS));
    let prediction = conditional.predict(&points)?;
    let exact: Vec<f64> = points.iter().map(|x| (setting.solution)(*x)).collect();
    let title = format!("{label}: u with its 95 % band");
    let band = band(&prediction.mean, &prediction.standard_deviation);
    let marks = observed.collocation.iter().filter(|_| D == 1);
    let marks = marks.map(|x| [x[0], (setting.solution)(*x)]);
    let chart = Chart::new(title, [&domain.names()[0], "u"], [false; 2])
        .with(curve("exact", &points, &exact))
        .with(Series { band, ..curve(label, &points, &prediction.mean) })
        .with(Series::new("equation imposed", Style::Points, marks));
    let at = domain.names().iter().zip(points[0]).skip(1);
    let line: String = at.map(|(name, x)| format!(" at {name} = {x:.3}")).collect();
    let theta: String = setting
        .truth
        .iter()
        .filter_map(|truth| {
            Some(format!(", {} = {:.4}", truth.name, fit.parameter(&truth.name).ok()?))
        })
        .collect();
    Ok(Figure {
        title: format!("{}{line}, {label}{theta}", setting.name),
        caption: String::new(),
        panels: vec![chart],
    })
}

/// Points of a domain along its first axis, through the middle of the others.
fn along_first<const D: usize>(domain: &Domain<D>, count: usize) -> Vec<[f64; D]> {
    let middle = domain.ends().map(|[low, high]| 0.5 * (low + high));
    let [low, high] = domain.ends()[0];
    let point = |k: usize| {
        let mut point = middle;
        point[0] = low + (high - low) * k as f64 / (count - 1) as f64;
        point
    };
    (0..count).map(point).filter(|point| domain.contains(*point)).collect()
}

/// The equation's first parameter after each iteration, from every start (Fig. 4.9).
pub(crate) fn traces<const D: usize>(inference: &Inference<D>, fit: &Fit<D>) -> Figure {
    let method = inference.approach.method();
    let outcomes = fit.restarts.iter().filter_map(|restart| restart.outcome.as_ref().ok());
    let lines = outcomes.map(|outcome| {
        let values = outcome.trace.iter().filter_map(|theta| theta.first());
        Series::new("", Style::Line, values.enumerate().map(|(k, theta)| [k as f64, *theta]))
    });
    let truth = inference.setting.truth.first();
    let level =
        |value| Level { name: "true value".into(), value, upright: false, published: false };
    Figure {
        title: format!("{}, {}: restarts", inference.setting.name, method.label()),
        caption: "Dashed: the true value.".into(),
        panels: vec![Chart {
            series: lines.collect(),
            levels: truth.map(|truth| level(truth.value)).into_iter().collect(),
            ..Chart::new(
                format!("{}: parameter after each iteration", method.label()),
                ["iteration", truth.map_or("θ", |truth| &truth.name)],
                [false, true],
            )
        }],
    }
}

/// A line through values at points of an interval.
pub(crate) fn curve<const D: usize>(name: &str, points: &[[f64; D]], values: &[f64]) -> Series {
    Series::new(name, Style::Line, points.iter().zip(values).map(|(x, y)| [x[0], *y]))
}

/// Number with as many digits as a drawing shows.
fn rounded(value: f64) -> f64 {
    format::rounded(value, 5)
}

fn band(mean: &[f64], deviation: &[f64]) -> Vec<[f64; 2]> {
    let ends = mean.iter().zip(deviation);
    ends.map(|(m, s)| [m - BAND * s, m + BAND * s].map(rounded)).collect()
}

/// An error over the number of data: one line per method through the medians of the rows, within their range.
pub(crate) fn sweep(
    [title, ordinate]: [&str; 2],
    rows: &[Row],
    value: impl Fn(&Row) -> Option<Distribution>,
) -> Chart {
    let title = format!("Advection-diffusion: {title}");
    let mut chart = Chart::new(title, ["N_u + N_f", ordinate], [false, true]);
    for row in rows {
        let (Some(x), Some(found)) = (row.label.abscissa, value(row)) else { continue };
        let name = row.label.method.label();
        let position = chart.series.iter().position(|series| series.name == name);
        let position = position.unwrap_or_else(|| {
            chart.series.push(Series::new(name, Style::Marked, []));
            chart.series.len() - 1
        });
        chart.series[position].points.push([x, found.q50]);
        chart.series[position].band.push([found.q0, found.q100]);
    }
    chart
}
