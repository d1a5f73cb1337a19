//! Double-logarithmic plots as inline SVG, coloured by the page's style.

use crate::case::Formulation;
use crate::format::{escape, power_of_ten, significant};
use std::fmt::Write;

/// Size of a plot \[px\].
const SIZE: [f64; 2] = [470.0, 310.0];
/// Left, right, top and bottom end of the axes \[px\].
const FRAME: [f64; 4] = [58.0, 456.0, 12.0, 264.0];
/// Below this many decades ticks between the powers of ten are labelled too.
const FINE_DECADES: f64 = 1.7;

/// Errors of one formulation, by what they took.
pub(crate) struct Series {
    pub formulation: Formulation,
    /// Abscissa, error and a hint under the pointer.
    pub points: Vec<(f64, f64, String)>,
}

/// An axis over the logarithms of positive numbers.
struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis over the numbers, at least a decade long.
    fn over(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut ends = None;
        for log in values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10) {
            let (low, high) = ends.unwrap_or((log, log));
            ends = Some((log.min(low), log.max(high)));
        }
        let (low, high) = ends?;
        let margin = 0.5 * (1.0 - (high - low)).max(0.0) + 0.05 * (high - low);
        Some(Self { low: low - margin, high: high + margin })
    }

    fn fraction(&self, value: f64) -> f64 {
        (value.log10() - self.low) / (self.high - self.low)
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        let decades = self.high - self.low;
        let stride = (decades / 7.0).ceil().max(1.0) as i32;
        let powers = self.low.floor() as i32..=self.high.ceil() as i32;
        let mut ticks = Vec::new();
        for exponent in powers.filter(|e| e.rem_euclid(stride) == 0) {
            let power = 10f64.powi(exponent);
            ticks.push((power, power_of_ten(exponent)));
            if decades < FINE_DECADES {
                let between = [2.0, 5.0].map(|m| (m * power, significant(m * power, 1)));
                ticks.extend(between);
            }
        }
        ticks.retain(|(value, _)| (0.0..=1.0).contains(&self.fraction(*value)));
        ticks
    }
}

/// SVG path of a formulation's marker around the origin.
fn marker(formulation: Formulation) -> &'static str {
    match formulation {
        Formulation::P1 => "M0 -5.5L5.3 4L-5.3 4Z",
        Formulation::P2 => "M4.5 0A4.5 4.5 0 1 1 -4.5 0A4.5 4.5 0 1 1 4.5 0Z",
        Formulation::Mixed => "M0 -5.8L5.8 0L0 5.8L-5.8 0Z",
        Formulation::FBar => "M-5.3 -4L5.3 -4L0 5.5Z",
        Formulation::Q1 => "M-4.2 -4.2H4.2V4.2H-4.2Z",
        Formulation::Q1FBar => "M-5.5 -1.7H-1.7V-5.5H1.7V-1.7H5.5V1.7H1.7V5.5H-1.7V1.7H-5.5Z",
    }
}

/// CSS class that colours a formulation.
pub(crate) fn class(formulation: Formulation) -> &'static str {
    match formulation {
        Formulation::P1 => "f-p1",
        Formulation::P2 => "f-p2",
        Formulation::Mixed => "f-mixed",
        Formulation::FBar => "f-fbar",
        Formulation::Q1 => "f-q1",
        Formulation::Q1FBar => "f-q1fbar",
    }
}

/// An entry of a legend.
pub(crate) fn legend(formulation: Formulation) -> String {
    format!(
        r#"<span><svg class="key" viewBox="-8 -8 16 16"><path class="dot {}" d="{}"/></svg>{}</span>"#,
        class(formulation),
        marker(formulation),
        formulation.label()
    )
}

/// A plot of errors, `None` when no point can be drawn. Errors of zero have no place on it.
pub(crate) fn plot(title: &str, [x_name, y_name]: [&str; 2], series: &[Series]) -> Option<String> {
    let points = || series.iter().flat_map(|s| &s.points);
    let x = Axis::over(points().map(|p| p.0))?;
    let y = Axis::over(points().map(|p| p.1))?;
    let [left, right, top, bottom] = FRAME;
    let across = |value: f64| left + x.fraction(value) * (right - left);
    let upward = |value: f64| bottom + y.fraction(value) * (top - bottom);
    let [width, height] = SIZE;
    let mut svg = format!(
        r#"<svg class="chart" viewBox="0 0 {width} {height}" role="img" aria-label="{}">"#,
        escape(title)
    );
    for (value, label) in x.ticks() {
        let at = across(value);
        let _ = write!(
            svg,
            r#"<path class="grid" d="M{at:.1} {top}V{bottom}"/><text class="tick" x="{at:.1}" y="{}" text-anchor="middle">{label}</text>"#,
            bottom + 16.0
        );
    }
    for (value, label) in y.ticks() {
        let at = upward(value);
        let _ = write!(
            svg,
            r#"<path class="grid" d="M{left} {at:.1}H{right}"/><text class="tick" x="{}" y="{:.1}" text-anchor="end">{label}</text>"#,
            left - 8.0,
            at + 4.0
        );
    }
    let _ = write!(
        svg,
        r#"<path class="axis" d="M{left} {top}V{bottom}H{right}"/><text class="name" x="{:.1}" y="{}" text-anchor="middle">{}</text><text class="name" transform="translate(13 {:.1}) rotate(-90)" text-anchor="middle">{}</text>"#,
        0.5 * (left + right),
        height - 8.0,
        escape(x_name),
        0.5 * (top + bottom),
        escape(y_name)
    );
    for Series { formulation, points } in series {
        let drawn = || points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0);
        let mut path = String::new();
        for (px, py, _) in drawn() {
            let to = if path.is_empty() { 'M' } else { 'L' };
            let _ = write!(path, "{to}{:.1} {:.1}", across(*px), upward(*py));
        }
        let _ = write!(svg, r#"<path class="line {}" d="{path}"/>"#, class(*formulation));
        for (px, py, hint) in drawn() {
            let _ = write!(
                svg,
                r#"<path class="dot {}" transform="translate({:.1} {:.1})" d="{}"><title>{}</title></path>"#,
                class(*formulation),
                across(*px),
                upward(*py),
                marker(*formulation),
                escape(hint)
            );
        }
    }
    svg.push_str("</svg>");
    Some(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_have_no_logarithm_are_left_out() {
        let hint = String::new;
        let points = vec![(10.0, 1e-2, hint()), (100.0, 0.0, hint()), (1e3, 1e-5, hint())];
        let series = [Series { formulation: Formulation::P1, points }];
        let svg = plot("t", ["x", "y"], &series).unwrap();
        assert_eq!(svg.matches("class=\"dot ").count(), 2);
        assert!(svg.contains("10⁻³") && svg.contains("10²"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(plot("t", ["x", "y"], &[]), None);
    }
}
