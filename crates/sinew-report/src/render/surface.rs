//! Deformed surfaces coloured by a value, in orthographic projection.

use super::map::{bar, colour};
use super::palette::Palette;
use crate::format::{digits, rounded, trimmed};
use crate::{SurfaceCase, Surfaces};
use maud::{Markup, html};
use std::collections::HashMap;
use std::fmt::Write;

/// Rotation of the view about the vertical axis, and above the horizon \[degrees\].
const VIEW: [f64; 2] = [24.0, 18.0];
/// Width of a drawing and margin around it \[px\].
const WIDTH: f64 = 470.0;
const MARGIN: f64 = 14.0;
/// Colours span this many decades below the largest value; smaller values share the lowest colour, or clamped nodes
/// would use up the scale.
const DECADES: i32 = 3;
/// Steps between the numbers below the colours: one per decade.
const TICKS: i32 = DECADES;
/// Cosine of the angle between faces from which their edge outlines the shape: 30°.
const FLAT: f64 = 0.866;

/// All cases with one view and one scale of colours, so that they can be compared.
pub(super) fn surfaces(surfaces: &Surfaces, palette: &Palette) -> Markup {
    let values = surfaces.cases.iter().flat_map(|case| case.values.iter().flatten());
    let scale = Scale { end: surfaces.scale().unwrap_or(0.0), linear: surfaces.linear };
    let above = values.clone().filter(|value| f64::from(**value) > scale.end).count();
    let above = 100.0 * above as f64 / values.count().max(1) as f64;
    let view = View::around(surfaces);
    let outline = outline(surfaces);
    html! { @if !surfaces.cases.is_empty() && !surfaces.reference.is_empty() {
        h3 { (surfaces.quantity) }
        p.note {
            "Deformed shapes to scale, coloured on one " (if scale.linear { "linear" } else { "logarithmic" })
            " scale for all; dashed: the body at rest; grey: no value."
            @if above > 0.0 {
                " The scale ends where nearly all values lie below: " (digits(above, 2)) " % are larger and have the last colour."
            }
        }
        svg.bar viewBox="0 0 470 32" role="img" aria-label="Scale of colours" fill="var(--text)" font-size="11" {
            (bar([MARGIN, 2.0], WIDTH - 2.0 * MARGIN))
            @for tick in 0..=TICKS {
                @let x = MARGIN + (WIDTH - 2.0 * MARGIN) * f64::from(tick) / f64::from(TICKS);
                text x=(x) y="26" text-anchor=(["start", "middle", "middle", "end"][tick as usize]) {
                    (if tick == 0 && !scale.linear { "≤ " } else { "" })
                    (if tick == TICKS && above > 0.0 { "≥ " } else { "" })
                    (digits(scale.value(f64::from(tick) / f64::from(TICKS)), 2))
                    (if tick == TICKS { format!(" {}", surfaces.unit) } else { String::new() })
                }
            }
        }
        div.panels { @for case in &surfaces.cases { figure {
            figcaption {
                (palette.key(&case.method)) b { (case.method) } ", " (case.title) ", largest "
                (digits(f64::from(case.values.iter().flatten().copied().fold(0.0, f32::max)), 2)) " " (surfaces.unit)
            }
            (drawing(surfaces, case, &view, &outline, scale))
        } } }
    } }
}

/// Colour of each value.
#[derive(Clone, Copy)]
struct Scale {
    /// Value of the last colour.
    end: f64,
    linear: bool,
}

impl Scale {
    /// The value at a position from 0 to 1.
    fn value(self, position: f64) -> f64 {
        match self.linear {
            true => position * self.end,
            false => self.end * 10f64.powf(f64::from(DECADES) * (position - 1.0)),
        }
    }

    /// The position of a value. Zero has the lowest; that nothing differs from zero leaves no scale.
    fn position(self, value: f64) -> f64 {
        match value > 0.0 {
            true if self.linear => value / self.end,
            true => 1.0 + (value / self.end).log10() / f64::from(DECADES),
            false => 0.0,
        }
    }
}

/// Orthographic view of the reference and all deformed shapes.
struct View {
    left: f64,
    top: f64,
    height: f64,
    /// Pixels per length.
    scale: f64,
}

impl View {
    fn around(surfaces: &Surfaces) -> Self {
        let deformed = surfaces.cases.iter().flat_map(|case| &case.deformed);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in surfaces.reference.iter().chain(deformed) {
            let seen = project(*point);
            low = std::array::from_fn(|axis| low[axis].min(seen[axis]));
            high = std::array::from_fn(|axis| high[axis].max(seen[axis]));
        }
        // A tall body is made smaller, so that it is not higher than wide.
        let size = (high[0] - low[0]).max(high[1] - low[1]).max(1e-12);
        let scale = (WIDTH - 2.0 * MARGIN) / size;
        let height = scale * (high[1] - low[1]) + 2.0 * MARGIN + 26.0;
        Self { left: low[0], top: high[1], height, scale }
    }

    fn pixel(&self, point: [f32; 3]) -> [f64; 2] {
        let [right, up, _] = project(point);
        [MARGIN + self.scale * (right - self.left), MARGIN + self.scale * (self.top - up)]
    }

    fn edges<'a>(
        &self,
        edges: impl Iterator<Item = &'a [usize; 2]>,
        points: &[[f32; 3]],
    ) -> String {
        edges.fold(String::new(), |mut path, edge| {
            let [[x, y], [u, v]] = edge.map(|node| self.pixel(points[node]));
            let _ = write!(path, "M{x:.1} {y:.1}L{u:.1} {v:.1}");
            path
        })
    }
}

/// Coordinates to the right, upward and towards the viewer; z is up.
fn project(point: [f32; 3]) -> [f64; 3] {
    let [(sin_turn, cos_turn), (sin_lift, cos_lift)] =
        VIEW.map(|angle| angle.to_radians().sin_cos());
    let [x, y, z] = point.map(f64::from);
    let away = -x * sin_turn + y * cos_turn;
    [x * cos_turn + y * sin_turn, z * cos_lift + away * sin_lift, z * sin_lift - away * cos_lift]
}

/// Painter's algorithm: the farthest triangle first.
fn drawing(
    surfaces: &Surfaces,
    case: &SurfaceCase,
    view: &View,
    outline: &[[usize; 2]],
    scale: Scale,
) -> Markup {
    let depth = |triangle: &&[usize; 3]| {
        triangle.iter().map(|&n| project(case.deformed[n])[2]).sum::<f64>()
    };
    let mut order: Vec<&[usize; 3]> = surfaces.triangles.iter().collect();
    order.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    let path = |triangle: &[usize; 3]| {
        let [a, b, c] = triangle.map(|node| view.pixel(case.deformed[node]));
        format!("M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}z", a[0], a[1], b[0], b[1], c[0], c[1])
    };
    let fill = |triangle: &[usize; 3]| {
        let sum: Option<f32> = triangle.iter().map(|&node| case.values[node]).sum();
        sum.map_or("var(--rule)".into(), |sum| colour(scale.position(f64::from(sum) / 3.0)))
    };
    let bar = rounded(0.15 * WIDTH / view.scale, 1);
    html! {
        svg viewBox={ "0 0 " (WIDTH) " " (view.height.ceil()) } role="img"
            aria-label={ (surfaces.quantity) ", " (case.method) ", " (case.title) } fill="var(--text)" font-size="11" {
            path.ghost d=(view.edges(outline.iter(), &surfaces.reference)) {}
            @for triangle in order { path.face color=(fill(triangle)) d=(path(triangle)) {} }
            path.axis d={ "M" (MARGIN) " " (view.height - 15.0) "v6h" (view.scale * bar) "v-6" } {}
            text x=(MARGIN + view.scale * bar + 6.0) y=(view.height - 9.0) { (trimmed(bar, 1)) " " (surfaces.length) }
        }
    }
}

/// Edges of one triangle only, and edges where faces meet at an angle.
fn outline(surfaces: &Surfaces) -> Vec<[usize; 2]> {
    let mut faces: HashMap<[usize; 2], Vec<[f64; 3]>> = HashMap::new();
    for &[a, b, c] in &surfaces.triangles {
        let [p, q, r] = [a, b, c].map(|node| surfaces.reference[node].map(f64::from));
        let [u, v] = [q, r].map(|end| [end[0] - p[0], end[1] - p[1], end[2] - p[2]]);
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            faces.entry([from.min(to), from.max(to)]).or_default().push(n.map(|x| x / length));
        }
    }
    // Faces may be turned either way, so the sign of the cosine does not count.
    let flat = |a: &[f64; 3], b: &[f64; 3]| (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).abs() >= FLAT;
    let mut edges: Vec<_> = faces
        .into_iter()
        .filter(|(_, normals)| !matches!(&normals[..], [a, b] if flat(a, b)))
        .map(|(edge, _)| edge)
        .collect();
    edges.sort_unstable();
    edges
}
