//! Drawings of what a fit says of u.

use crate::gp::inference::{Inference, Observed};
use crate::gp::row::Row;
use crate::program;
use sinew_gp::{Conditional, Domain, Fit, GpError, Prediction};
use sinew_report::format;
use sinew_report::{Chart, Distribution, Figure, Level, Map, Panel, Series, Style};

/// Half-width of a 95 % band in standard deviations.
pub(crate) const BAND: f64 = 1.959_964;
/// Points per axis of maps, and of curves.
const MAP_POINTS: usize = 41;
const CURVE_POINTS: usize = 101;
/// Size of maps and curves in a check.
const FEW_POINTS: usize = 11;

/// Solution, posterior mean, error and band: as curves on an interval, else as maps over the first
/// two axes, the others at their upper ends.
pub(crate) fn posterior<const D: usize>(
    inference: &Inference<D>,
    conditional: &Conditional<D>,
    observed: &Observed<D>,
    fit: &Fit<D>,
) -> Result<Figure, GpError> {
    let (setting, scale) = (&inference.setting, inference.scale);
    let domain = setting.problem.domain();
    let label = inference.approach.method().label();
    let slice = (D > 1).then(|| Slice::of(domain, scale.pick(MAP_POINTS, FEW_POINTS)));
    let curve_points = || domain.grid(scale.pick(CURVE_POINTS, FEW_POINTS));
    let points = slice.as_ref().map_or_else(curve_points, |slice| slice.points.clone());
    let prediction = conditional.predict(&points)?;
    let exact: Vec<f64> = points.iter().map(|x| (setting.solution)(*x)).collect();
    let panels = match slice {
        None => {
            let title = format!("{label}: u with its 95 % band");
            let chart = Chart::new(title, [&domain.names()[0], "u"], [false; 2]);
            let band = band(&prediction.mean, &prediction.standard_deviation);
            let marks = observed.collocation.iter().map(|x| [x[0], (setting.solution)(*x)]);
            vec![Panel::Chart(
                chart
                    .with(curve("exact", &points, &exact))
                    .with(Series { band, ..curve(label, &points, &prediction.mean) })
                    .with(Series::new("equation imposed", Style::Points, marks)),
            )]
        }
        Some(slice) => maps(label, &slice, (&exact, &prediction), observed),
    };
    let at = domain.names().iter().zip(domain.ends().map(|[_, upper]| upper)).skip(2);
    let above: String = at.map(|(name, end)| format!(" at {name} = {end}")).collect();
    let theta: String = setting
        .truth
        .iter()
        .filter_map(|truth| {
            Some(format!(", {} = {:.4}", truth.name, fit.parameter(&truth.name).ok()?))
        })
        .collect();
    Ok(Figure {
        title: format!("{}{above}, {label}{theta}", setting.name),
        caption: String::new(),
        panels,
    })
}

/// Maps of the solution, its mean, error and band over two axes.
fn maps<const D: usize>(
    label: &str,
    slice: &Slice<D>,
    (exact, Prediction { mean, standard_deviation }): (&[f64], &Prediction),
    observed: &Observed<D>,
) -> Vec<Panel> {
    let error: Vec<f64> = exact.iter().zip(mean).map(|(u, m)| (u - m).abs()).collect();
    let width: Vec<f64> = standard_deviation.iter().map(|s| BAND * s).collect();
    let shared = program::range(&slice.rows(exact));
    let places = [("u observed", &observed.places), ("equation imposed", &observed.collocation)];
    let marks = places
        .map(|(name, places)| (name.into(), places.iter().map(|x| [x[0], x[1]]).collect()))
        .to_vec();
    [
        slice.map("u exact", exact, Some(shared)),
        Map { marks, ..slice.map(&format!("{label}: û and data"), mean, Some(shared)) },
        slice.map(&format!("{label}: |u − û|"), &error, None),
        slice.map(&format!("{label}: half-width of the 95 % band"), &width, None),
    ]
    .map(Panel::Map)
    .to_vec()
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
        panels: vec![Panel::Chart(Chart {
            series: lines.collect(),
            levels: truth.map(|truth| level(truth.value)).into_iter().collect(),
            ..Chart::new(
                format!("{}: parameter after each iteration", method.label()),
                ["iteration", truth.map_or("θ", |truth| &truth.name)],
                [false, true],
            )
        })],
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

/// A grid over the first two axes.
struct Slice<const D: usize> {
    points: Vec<[f64; D]>,
    /// Number of the point at each place of the grid, row by row along the second axis.
    places: Vec<Option<usize>>,
    /// Places in a row.
    count: usize,
    names: [String; 2],
    ranges: [[f64; 2]; 2],
}

impl<const D: usize> Slice<D> {
    fn of(domain: &Domain<D>, count: usize) -> Self {
        let [from, to] = [0, 1].map(|end| domain.ends().map(|ends| ends[end]));
        let coordinate = |axis: usize, k: usize| {
            from[axis] + (to[axis] - from[axis]) * k as f64 / (count - 1) as f64
        };
        let mut points = Vec::new();
        let mut place = |at: usize| {
            let mut point = to;
            (point[0], point[1]) = (coordinate(0, at % count), coordinate(1, at / count));
            domain.contains(point).then(|| {
                points.push(point);
                points.len() - 1
            })
        };
        let places = (0..count * count).map(&mut place).collect();
        let names = [0, 1].map(|axis| domain.names()[axis].clone());
        let ranges = [0, 1].map(|axis| [from[axis], to[axis]]);
        Self { points, places, count, names, ranges }
    }

    fn rows(&self, values: &[f64]) -> Vec<Vec<Option<f64>>> {
        let value = |place: &Option<usize>| place.map(|number| rounded(values[number]));
        self.places.chunks(self.count).map(|row| row.iter().map(value).collect()).collect()
    }

    fn map(&self, title: &str, values: &[f64], scale: Option<[f64; 2]>) -> Map {
        let rows = self.rows(values);
        Map {
            title: title.into(),
            axes: self.names.clone(),
            ranges: self.ranges,
            // Errors and widths are seen against zero.
            scale: scale.unwrap_or([0.0, program::range(&rows)[1]]),
            rows,
            marks: Vec::new(),
        }
    }
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
