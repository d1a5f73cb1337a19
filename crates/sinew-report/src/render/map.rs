//! Colours over a rectangle.

use crate::Map;
use crate::format::trimmed;
use kuva::prelude::ColorMap;
use maud::{Markup, html};
use std::fmt::Write;

/// Sides of the coloured rectangle and its left and upper end \[px\].
const SIDE: [f64; 2] = [226.0, 190.0];
const CORNER: [f64; 2] = [50.0, 8.0];
/// Colours: few enough that neighbours of one colour join into long rectangles.
const LEVELS: usize = 32;

/// The colour of a level.
fn colour(level: usize) -> String {
    ColorMap::Viridis.map(level as f64 / (LEVELS - 1) as f64)
}

pub(super) fn map(map: &Map) -> Markup {
    let [[left, right], [bottom, top]] = map.ranges;
    // A range without extent still has a place.
    let extent = |[low, high]: [f64; 2]| if high > low { high - low } else { 1.0 };
    let place = |[x, y]: [f64; 2]| {
        let across = (x - left) / extent([left, right]);
        let up = (y - bottom) / extent([bottom, top]);
        (CORNER[0] + SIDE[0] * across, CORNER[1] + SIDE[1] * (1.0 - up))
    };
    let [end, foot] = [0, 1].map(|axis| CORNER[axis] + SIDE[axis]);
    let ends = |axis: usize| map.ranges[axis].map(|end| trimmed(end, 3));
    let middle = CORNER[1] + 0.5 * SIDE[1];
    html! { figure {
        figcaption { (map.title) }
        svg viewBox="0 0 290 272" role="img" aria-label=(map.title) fill="var(--text)" font-size="11" {
            @for (level, path) in rectangles(map).iter().enumerate().filter(|(_, path)| !path.is_empty()) {
                path fill=(colour(level)) shape-rendering="crispEdges" d=(path) {}
            }
            rect x=(CORNER[0]) y=(CORNER[1]) width=(SIDE[0]) height=(SIDE[1]) fill="none" stroke="var(--dim)" {}
            @for (kind, (name, points)) in map.marks.iter().enumerate() { @for point in points {
                @let (x, y) = place(*point);
                @if kind == 0 { circle.mark cx=(x) cy=(y) r="2.5" { title { (name) } } }
                @else {
                    path.halo d={ "M" (x - 3.0) " " (y - 3.0) "l6 6m0 -6l-6 6" } {}
                    path.mark d={ "M" (x - 2.5) " " (y - 2.5) "l5 5m0 -5l-5 5" } { title { (name) } }
                }
            } }
            text x=(CORNER[0]) y=(foot + 14.0) { (ends(0)[0]) }
            text x=(end) y=(foot + 14.0) text-anchor="end" { (ends(0)[1]) }
            text x=(CORNER[0] + 0.5 * SIDE[0]) y=(foot + 14.0) text-anchor="middle" { (map.axes[0]) }
            text x=(CORNER[0] - 5.0) y=(foot) text-anchor="end" { (ends(1)[0]) }
            text x=(CORNER[0] - 5.0) y=(CORNER[1] + 9.0) text-anchor="end" { (ends(1)[1]) }
            text x=(CORNER[0] - 10.0) y=(middle) text-anchor="middle"
                transform={ "rotate(-90 " (CORNER[0] - 10.0) " " (middle) ")" } { (map.axes[1]) }
            // Steps of colour: a gradient's identifier would repeat on the page.
            @for level in 0..LEVELS {
                @let from = SIDE[0] / LEVELS as f64 * level as f64;
                rect x=(CORNER[0] + from) y=(foot + 30.0) width=(SIDE[0] - from) height="10" fill=(colour(level)) {}
            }
            text x=(CORNER[0]) y=(foot + 54.0) { (trimmed(map.scale[0], 3)) }
            text x=(end) y=(foot + 54.0) text-anchor="end" { (trimmed(map.scale[1], 3)) }
        }
    } }
}

/// Rectangles of every level of colour, equal neighbours joined.
fn rectangles(map: &Map) -> Vec<String> {
    let mut paths = vec![String::new(); LEVELS];
    let [low, high] = map.scale;
    let level = |value: &Option<f64>| {
        let share = ((*value)? - low) / (high - low).max(f64::MIN_POSITIVE);
        // `as` cuts off at both ends.
        share.is_finite().then_some(((share * LEVELS as f64) as usize).min(LEVELS - 1))
    };
    let height = SIDE[1] / map.rows.len().max(1) as f64;
    for (number, row) in map.rows.iter().enumerate() {
        let levels: Vec<_> = row.iter().map(level).collect();
        let width = SIDE[0] / row.len().max(1) as f64;
        let y = CORNER[1] + SIDE[1] - height * (number + 1) as f64;
        let mut from = 0;
        for stretch in levels.chunk_by(|a, b| a == b) {
            let (x, long) = (CORNER[0] + width * from as f64, width * stretch.len() as f64);
            if let Some(level) = stretch[0] {
                let _ = write!(paths[level], "M{x:.1} {y:.1}h{long:.1}v{height:.1}h-{long:.1}z");
            }
            from += stretch.len();
        }
    }
    paths
}
