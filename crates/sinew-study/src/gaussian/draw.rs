//! Drawings of what a fit says of u.

use crate::gaussian::inference::{Inference, Observed};
use crate::gaussian::picture::{Curves, Figure, Line, Map, Panel, rounded};
use crate::gaussian::row::Row;
use sinew_gp::{Domain, Fit, GpError, Posterior};

/// Half-width of a 95 % band in standard deviations.
pub const BAND: f64 = 1.959_964;
/// Points per axis of maps, and of curves.
const MAP_POINTS: usize = 41;
const CURVE_POINTS: usize = 101;
/// Of maps and curves in a check.
const FEW_POINTS: usize = 11;

/// Solution, posterior mean, error and band: as curves on an interval, else as maps over the first
/// two axes, the others at their upper ends.
///
/// # Errors
/// If the posterior cannot be evaluated.
pub fn posterior<const D: usize>(
    inference: &Inference<D>,
    posterior: &Posterior<D>,
    observed: &Observed<D>,
    fit: &Fit<D>,
) -> Result<Figure, GpError> {
    let setting = &inference.setting;
    let domain = setting.problem.domain();
    let label = inference.approach.method().label();
    let panels = if D == 1 {
        let points = line(domain, inference.scale.pick(CURVE_POINTS, FEW_POINTS));
        let prediction = posterior.predict(&points)?;
        let exact: Vec<f64> = points.iter().map(|x| (setting.solution)(*x)).collect();
        vec![Panel::Curves(Curves {
            title: format!("{label}: u with its 95 % band"),
            axes: [domain.names()[0].clone(), "u".into()],
            lines: vec![
                curve("exact", "exact", &points, &exact),
                Line {
                    band: band(&prediction.mean, &prediction.deviation),
                    ..curve(label, inference.approach.method().key(), &points, &prediction.mean)
                },
            ],
            marks: observed.collocation.iter().map(|x| [x[0], (setting.solution)(*x)]).collect(),
            ..Curves::default()
        })]
    } else {
        let slice = Slice::of(domain, inference.scale.pick(MAP_POINTS, FEW_POINTS));
        let prediction = posterior.predict(&slice.points)?;
        let exact: Vec<f64> = slice.points.iter().map(|x| (setting.solution)(*x)).collect();
        let error: Vec<f64> =
            exact.iter().zip(&prediction.mean).map(|(u, m)| (u - m).abs()).collect();
        let width: Vec<f64> = prediction.deviation.iter().map(|s| BAND * s).collect();
        let shared = Map::range(&slice.rows(&exact));
        let with_data = |map: Map| Map {
            observations: observed.places.iter().map(|x| [x[0], x[1]]).collect(),
            collocation: observed.collocation.iter().map(|x| [x[0], x[1]]).collect(),
            ..map
        };
        [
            slice.map("u exact", &exact, Some(shared)),
            with_data(slice.map(&format!("{label}: û and data"), &prediction.mean, Some(shared))),
            slice.map(&format!("{label}: |u − û|"), &error, None),
            slice.map(&format!("{label}: half-width of the 95 % band"), &width, None),
        ]
        .map(Panel::Map)
        .to_vec()
    };
    let at = domain.names().iter().zip(domain.upper()).skip(2);
    let slice: String = at.map(|(name, end)| format!(" at {name} = {end}")).collect();
    let theta: String = setting
        .truth
        .iter()
        .filter_map(|truth| {
            Some(format!(", {} = {:.4}", truth.name, fit.parameter(&truth.name).ok()?))
        })
        .collect();
    Ok(Figure {
        title: format!("{}{slice}, {label}{theta}", setting.name),
        caption: String::new(),
        panels,
    })
}

/// The equation's first parameter after each iteration, from every start (Fig. 4.9).
pub fn traces<const D: usize>(inference: &Inference<D>, fit: &Fit<D>) -> Figure {
    let method = inference.approach.method();
    let outcomes = fit.restarts.iter().filter_map(|restart| restart.outcome.as_ref().ok());
    let lines = outcomes.map(|outcome| {
        let values = outcome.trace.iter().filter_map(|theta| theta.first());
        Line {
            class: format!("{} trace", method.key()),
            points: values.enumerate().map(|(k, theta)| [k as f64, rounded(*theta)]).collect(),
            ..Line::default()
        }
    });
    let truth = inference.setting.truth.first();
    Figure {
        title: format!("{}, {}: restarts", inference.setting.name, method.label()),
        caption: String::new(),
        panels: vec![Panel::Curves(Curves {
            title: format!("{}: parameter after each iteration", method.label()),
            axes: ["iteration".into(), truth.map_or("θ", |truth| &truth.name).into()],
            logarithmic: true,
            lines: lines.collect(),
            level: truth.map(|truth| ("true value".into(), truth.value)),
            ..Curves::default()
        })],
    }
}

/// A regular row of points on an interval.
pub fn line<const D: usize>(domain: &Domain<D>, count: usize) -> Vec<[f64; D]> {
    let [from, to] = [domain.lower(), domain.upper()];
    (0..count)
        .map(|k| {
            let share = k as f64 / (count.max(2) - 1) as f64;
            std::array::from_fn(|d| from[d] + share * (to[d] - from[d]))
        })
        .collect()
}

/// A line through values at points of an interval.
pub fn curve<const D: usize>(name: &str, class: &str, points: &[[f64; D]], values: &[f64]) -> Line {
    let pairs = points.iter().zip(values);
    Line {
        name: name.into(),
        class: class.into(),
        points: pairs.map(|(x, y)| [rounded(x[0]), rounded(*y)]).collect(),
        band: Vec::new(),
    }
}

fn band(mean: &[f64], deviation: &[f64]) -> Vec<[f64; 2]> {
    let ends = mean.iter().zip(deviation);
    ends.map(|(m, s)| [m - BAND * s, m + BAND * s].map(rounded)).collect()
}

/// A grid over the first two axes.
struct Slice<const D: usize> {
    points: Vec<[f64; D]>,
    /// Number of the point at each place of the grid, row by row along the second axis.
    places: Vec<Vec<Option<usize>>>,
    names: [String; 2],
    ranges: [[f64; 2]; 2],
}

impl<const D: usize> Slice<D> {
    fn of(domain: &Domain<D>, count: usize) -> Self {
        let (from, to) = (domain.lower(), domain.upper());
        let coordinate = |axis: usize, k: usize| {
            from[axis] + (to[axis] - from[axis]) * k as f64 / (count - 1) as f64
        };
        let mut points = Vec::new();
        let places = (0..count)
            .map(|row| {
                (0..count)
                    .map(|column| {
                        let mut point = to;
                        (point[0], point[1]) = (coordinate(0, column), coordinate(1, row));
                        domain.contains(point).then(|| {
                            points.push(point);
                            points.len() - 1
                        })
                    })
                    .collect()
            })
            .collect();
        Self {
            points,
            places,
            names: [0, 1].map(|axis| domain.names()[axis].clone()),
            ranges: [0, 1].map(|axis| [from[axis], to[axis]]),
        }
    }

    fn rows(&self, values: &[f64]) -> Vec<Vec<Option<f64>>> {
        let value = |place: &Option<usize>| place.map(|number| rounded(values[number]));
        self.places.iter().map(|row| row.iter().map(value).collect()).collect()
    }

    fn map(&self, title: &str, values: &[f64], scale: Option<[f64; 2]>) -> Map {
        let rows = self.rows(values);
        Map {
            title: title.into(),
            axes: self.names.clone(),
            ranges: self.ranges,
            columns: self.places.len(),
            // Errors and widths are seen against zero.
            scale: scale.unwrap_or([0.0, Map::range(&rows)[1]]),
            rows,
            observations: Vec::new(),
            collocation: Vec::new(),
        }
    }
}

/// One line per method through the medians of a sweep's rows of one problem, within their range.
pub fn sweep(
    title: &str,
    axes: [&str; 2],
    rows: &[&Row],
    value: impl Fn(&Row) -> Option<crate::gaussian::row::Spread>,
) -> Panel {
    let mut lines: Vec<Line> = Vec::new();
    for row in rows {
        let (Some(x), Some(spread)) = (row.label.abscissa, value(row)) else { continue };
        let method = row.label.method;
        let position = lines.iter().position(|line| line.class == method.key());
        let position = position.unwrap_or_else(|| {
            let (name, class) = (method.label().into(), method.key().into());
            lines.push(Line { name, class, ..Line::default() });
            lines.len() - 1
        });
        lines[position].points.push([x, spread.median]);
        lines[position].band.push([spread.low, spread.high]);
    }
    Panel::Curves(Curves {
        title: title.into(),
        axes: axes.map(String::from),
        logarithmic: true,
        lines,
        ..Curves::default()
    })
}
