//! Curves and maps as inline SVG.

use crate::gaussian::picture::{Curves, Line, Map, Panel};
use crate::report::axis::Axis;
use crate::report::chart::{Chart, Marker};
use crate::report::colours::{hex, viridis};
use crate::report::format::{escape, two_digits};
use std::fmt::Write;

const CURVES_SIZE: (f64, f64) = (440.0, 300.0);
const MAP_SIZE: (f64, f64) = (300.0, 270.0);
/// Colours of a map: few enough that neighbours of one colour join into long rectangles.
const LEVELS: usize = 32;

/// A drawing with its title as a caption.
pub fn panel(panel: &Panel) -> String {
    let (title, drawing) = match panel {
        Panel::Curves(curves) => (&curves.title, self::curves(curves)),
        Panel::Map(map) => (&map.title, self::map(map)),
    };
    format!("<figure><figcaption>{}</figcaption>{drawing}</figure>", escape(title))
}

fn curves(curves: &Curves) -> String {
    let points = || curves.lines.iter().flat_map(|line| &line.points);
    let bands = curves.lines.iter().flat_map(|line| line.band.iter().flatten().copied());
    let level = curves.level.iter().map(|level| level.1);
    let heights = points().map(|p| p[1]).chain(curves.marks.iter().map(|p| p[1])).chain(level);
    let heights: Vec<f64> = heights.chain(bands).collect();
    let x = Axis::linear(escape(&curves.axes[0]), points().map(|p| p[0]));
    let name = escape(&curves.axes[1]);
    let y = if curves.logarithmic { Axis::log(name, heights) } else { Axis::linear(name, heights) };
    let mut chart = Chart::new(CURVES_SIZE, &curves.title, x, y);
    for line in &curves.lines {
        let band: Vec<(f64, f64, f64)> =
            line.points.iter().zip(&line.band).map(|(p, band)| (p[0], band[0], band[1])).collect();
        chart.band(&class(line), &band);
    }
    for line in &curves.lines {
        let points: Vec<(f64, f64)> = line.points.iter().map(|p| (p[0], p[1])).collect();
        chart.line(&class(line), &points);
    }
    if let Some((_, level)) = &curves.level {
        chart.horizontal("m-exact", *level);
    }
    for [x, y] in &curves.marks {
        chart.marker("dot m-exact", &Marker::Circle.path(2.5), (*x, *y), "data");
    }
    format!("{}{}", legend(curves), chart.render())
}

fn class(line: &Line) -> String {
    format!("m-{}", line.class)
}

fn legend(curves: &Curves) -> String {
    let mut named: Vec<(&str, String)> = curves
        .lines
        .iter()
        .filter(|line| !line.name.is_empty())
        .map(|line| (line.name.as_str(), format!("line {}", class(line))))
        .collect();
    named.extend(curves.level.iter().map(|(name, _)| (name.as_str(), "rule m-exact".to_string())));
    let mut html = String::from("<p class=\"legend\">");
    for (name, class) in named {
        let _ = write!(
            html,
            "<span><svg viewBox=\"0 0 30 12\"><path class=\"{class}\" d=\"M1 6H29\"/></svg>{}</span>",
            escape(name)
        );
    }
    html.push_str("</p>");
    html
}

fn map(map: &Map) -> String {
    let [x, y] = [0, 1].map(|axis| Axis::between(escape(&map.axes[axis]), map.ranges[axis]));
    let mut chart = Chart::new(MAP_SIZE, &map.title, x, y);
    let mut by_level: Vec<Vec<[[f64; 2]; 2]>> = vec![Vec::new(); LEVELS];
    let edges = |axis: usize, count: usize, from: usize, to: usize| {
        let [low, high] = map.ranges[axis];
        let step = (high - low) / (count.max(2) - 1) as f64;
        // Half a cell to each side of a point.
        [low + (from as f64 - 0.5) * step, low + (to as f64 - 0.5) * step]
    };
    for (number, row) in map.rows.iter().enumerate() {
        let levels: Vec<Option<usize>> = row.iter().map(|value| level(map, *value)).collect();
        let mut from = 0;
        for stretch in levels.chunk_by(|a, b| a == b) {
            let to = from + stretch.len();
            if let Some(level) = stretch[0] {
                let ys = edges(1, map.rows.len(), number, number + 1);
                by_level[level].push([edges(0, map.columns, from, to), ys]);
            }
            from = to;
        }
    }
    for (level, rectangles) in by_level.iter().enumerate().filter(|(_, r)| !r.is_empty()) {
        chart.rectangles(&hex(viridis(level as f64 / (LEVELS - 1) as f64)), rectangles);
    }
    for [x, y] in &map.collocation {
        // Light about dark, to be seen on any colour.
        chart.marker("halo", &Marker::Cross.path(3.0), (*x, *y), "");
        chart.marker("collocation", &Marker::Cross.path(2.5), (*x, *y), "equation imposed");
    }
    for [x, y] in &map.observations {
        chart.marker("observation", &Marker::Circle.path(2.5), (*x, *y), "u observed");
    }
    format!("{}{}", chart.render(), bar(map.scale))
}

fn level(map: &Map, value: Option<f64>) -> Option<usize> {
    let [low, high] = map.scale;
    let share = (value? - low) / (high - low).max(f64::MIN_POSITIVE);
    // `as` cuts off at both ends.
    Some(((share * LEVELS as f64) as usize).min(LEVELS - 1))
}

/// The colours with the values at their ends.
fn bar([low, high]: [f64; 2]) -> String {
    let mut svg = String::from(
        r#"<svg class="bar" viewBox="0 0 300 30" role="img" aria-label="Colour bar">"#,
    );
    for level in 0..LEVELS {
        let width = 226.0 / LEVELS as f64;
        let x = 58.0 + width * level as f64;
        let colour = hex(viridis(level as f64 / (LEVELS - 1) as f64));
        // Up to the end, so that no gap shows between neighbours.
        let _ = write!(svg, r#"<path fill="{colour}" d="M{x:.1} 2H284v10H{x:.1}z"/>"#);
    }
    let _ = write!(
        svg,
        r#"<text class="tick" x="58" y="26">{}</text><text class="tick" x="284" y="26" text-anchor="end">{}</text></svg>"#,
        two_digits(low),
        two_digits(high)
    );
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_join_and_the_outside_stays_empty() {
        let drawn = Map {
            title: "a < b".into(),
            axes: ["x".into(), "y".into()],
            ranges: [[0.0, 1.0], [0.0, 1.0]],
            columns: 4,
            rows: vec![vec![Some(0.0), Some(0.0), Some(1.0), None]],
            scale: [0.0, 1.0],
            observations: vec![[0.5, 0.5]],
            collocation: Vec::new(),
        };
        let svg = map(&drawn);
        let body = svg.split("</svg>").next().unwrap();
        assert_eq!(body.matches("<path fill=").count(), 2, "two colours");
        assert_eq!(body.matches("observation").count(), 1);
        assert!(!panel(&Panel::Map(drawn)).contains("a < b"));
    }

    #[test]
    fn curves_have_a_legend_for_named_lines_only() {
        let line = |name: &str| Line {
            name: name.into(),
            class: "hcgp".into(),
            points: vec![[0.0, 1.0], [1.0, 2.0]],
            band: vec![[0.5, 1.5], [1.0, 3.0]],
        };
        let drawn = curves(&Curves { lines: vec![line("HCGP"), line("")], ..Curves::default() });
        assert_eq!(drawn.matches("<span>").count(), 1);
        assert_eq!(drawn.matches("class=\"area m-hcgp\"").count(), 2);
    }
}
