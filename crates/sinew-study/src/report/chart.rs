//! Lines, areas and markers between two axes, as inline SVG.
//!
//! Colours are CSS classes of the page, not attributes, so that one drawing serves
//! light, dark and print. (A plotting library would fix them when it draws.)

use std::fmt::Write;

use super::axis::Axis;
use super::format::escape;

/// Room for tick labels and axis names around the plot \[px\].
const MARGIN: Margin = Margin { left: 58.0, right: 16.0, top: 12.0, bottom: 44.0 };
struct Margin {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Outline of a marker; every method has its own, as it has its colour.
#[derive(Clone, Copy)]
pub(crate) enum Marker {
    Circle,
    Triangle,
    TriangleDown,
    Diamond,
    Square,
    Cross,
    Plus,
}

impl Marker {
    /// SVG path around the origin, `r` in pixels.
    pub(crate) fn path(self, r: f64) -> String {
        match self {
            Self::Circle => format!("M{r} 0A{r} {r} 0 1 1 -{r} 0A{r} {r} 0 1 1 {r} 0Z"),
            Self::Triangle => {
                let (x, y) = (1.15 * r, 0.85 * r);
                format!("M0 -{:.2}L{x:.2} {y:.2}L-{x:.2} {y:.2}Z", 1.2 * r)
            }
            Self::TriangleDown => {
                let (x, y) = (1.15 * r, 0.85 * r);
                format!("M0 {:.2}L{x:.2} -{y:.2}L-{x:.2} -{y:.2}Z", 1.2 * r)
            }
            Self::Diamond => {
                let d = 1.3 * r;
                format!("M0 -{d:.2}L{d:.2} 0L0 {d:.2}L-{d:.2} 0Z")
            }
            Self::Square => {
                let h = 0.9 * r;
                format!("M-{h:.2} -{h:.2}H{h:.2}V{h:.2}H-{h:.2}Z")
            }
            Self::Cross => format!("M-{r} -{r}L{r} {r}M-{r} {r}L{r} -{r}"),
            Self::Plus => format!("M0 -{r}V{r}M-{r} 0H{r}"),
        }
    }
}

/// A plot under construction. Values outside of the axes are not drawn.
pub(crate) struct Chart {
    size: (f64, f64),
    x: Axis,
    y: Axis,
    body: String,
    title: String,
}

impl Chart {
    /// An empty plot; `title` is plain text for screen readers.
    pub(crate) fn new(size: (f64, f64), title: &str, x: Axis, y: Axis) -> Self {
        Self { size, x, y, body: String::new(), title: escape(title) }
    }

    /// Left, right, top and bottom of the plot \[px\].
    fn frame(&self) -> (f64, f64, f64, f64) {
        let left = if self.y.numbered { MARGIN.left } else { 30.0 };
        let (width, height) = self.size;
        (left, width - MARGIN.right, MARGIN.top, height - MARGIN.bottom)
    }

    /// Pixel of a point, if it lies on both axes.
    pub(crate) fn pixel(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let (left, right, top, bottom) = self.frame();
        let (x, y) = (self.x.fraction(x)?, self.y.fraction(y)?);
        Some((left + x * (right - left), bottom + y * (top - bottom)))
    }

    /// A line through the points; broken where a point is not on the axes.
    pub(crate) fn line(&mut self, class: &str, points: &[(f64, f64)]) {
        let mut path = String::new();
        let mut connected = false;
        for &point in points {
            let Some((x, y)) = self.pixel(point) else {
                connected = false;
                continue;
            };
            let _ = write!(path, "{}{x:.1} {y:.1}", if connected { 'L' } else { 'M' });
            connected = true;
        }
        if !path.is_empty() {
            let _ = write!(self.body, r#"<path class="line {class}" d="{path}"/>"#);
        }
    }

    /// The area between the points and the lower axis.
    pub(crate) fn area(&mut self, class: &str, points: &[(f64, f64)]) {
        let pixels: Vec<_> = points.iter().filter_map(|&p| self.pixel(p)).collect();
        let (Some(first), Some(last)) = (pixels.first(), pixels.last()) else {
            return;
        };
        let bottom = self.frame().3;
        let mut path = format!("M{:.1} {bottom:.1}", first.0);
        for (x, y) in &pixels {
            let _ = write!(path, "L{x:.1} {y:.1}");
        }
        let _ = write!(path, "L{:.1} {bottom:.1}Z", last.0);
        let _ = write!(self.body, r#"<path class="area {class}" d="{path}"/>"#);
    }

    /// The area between two curves, given as (x, low, high).
    pub(crate) fn band(&mut self, class: &str, points: &[(f64, f64, f64)]) {
        let (left, right, top, bottom) = self.frame();
        let pixel = |x: f64, y: f64| {
            let across = left + self.x.clamped(x) * (right - left);
            (across, bottom + self.y.clamped(y) * (top - bottom))
        };
        let there = points.iter().map(|(x, _, high)| pixel(*x, *high));
        let back = points.iter().rev().map(|(x, low, _)| pixel(*x, *low));
        let mut path = String::new();
        for (x, y) in there.chain(back) {
            let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' });
        }
        if !path.is_empty() {
            let _ = write!(self.body, r#"<path class="area {class}" d="{path}Z"/>"#);
        }
    }

    /// Rectangles of one colour, each from its ends in x and in y; what is beyond the axes is cut off.
    pub(crate) fn rectangles(&mut self, colour: &str, rectangles: &[[[f64; 2]; 2]]) {
        let (left, right, top, bottom) = self.frame();
        let mut path = String::new();
        for [xs, ys] in rectangles {
            let [from, to] = xs.map(|x| left + self.x.clamped(x) * (right - left));
            let [low, high] = ys.map(|y| bottom + self.y.clamped(y) * (top - bottom));
            let _ = write!(path, "M{from:.1} {low:.1}H{to:.1}V{high:.1}H{from:.1}z");
        }
        let _ =
            write!(self.body, r#"<path fill="{colour}" shape-rendering="crispEdges" d="{path}"/>"#);
    }

    /// A line across the plot at `x`.
    pub(crate) fn vertical(&mut self, class: &str, x: f64) {
        let (left, right, top, bottom) = self.frame();
        if let Some(fraction) = self.x.fraction(x) {
            let at = left + fraction * (right - left);
            let _ =
                write!(self.body, r#"<path class="rule {class}" d="M{at:.1} {top}V{bottom}"/>"#);
        }
    }

    /// A line across the plot at `y`.
    pub(crate) fn horizontal(&mut self, class: &str, y: f64) {
        let (left, right, top, bottom) = self.frame();
        if let Some(fraction) = self.y.fraction(y) {
            let at = bottom + fraction * (top - bottom);
            let _ =
                write!(self.body, r#"<path class="rule {class}" d="M{left} {at:.1}H{right}"/>"#);
        }
    }

    /// A tick mark of a method below the plot at `x`.
    pub(crate) fn pointer(&mut self, class: &str, x: f64, hint: &str) {
        let (left, right, _, bottom) = self.frame();
        if let Some(fraction) = self.x.fraction(x) {
            let at = left + fraction * (right - left);
            let _ = write!(
                self.body,
                r#"<path class="dot {class}" d="M{at:.1} {:.1}l5 9h-10z"><title>{}</title></path>"#,
                bottom - 9.0,
                escape(hint)
            );
        }
    }

    /// A marker (a path around the origin) at a point, with a hint that appears under the pointer.
    pub(crate) fn marker(&mut self, class: &str, marker: &str, point: (f64, f64), hint: &str) {
        if let Some((x, y)) = self.pixel(point) {
            let _ = write!(
                self.body,
                r#"<path class="{class}" transform="translate({x:.1} {y:.1})" d="{marker}"><title>{}</title></path>"#,
                escape(hint)
            );
        }
    }

    /// Text at a pixel; `anchor` is `start`, `middle` or `end`.
    pub(crate) fn text(&mut self, class: &str, (x, y): (f64, f64), anchor: &str, text: &str) {
        let _ = write!(
            self.body,
            r#"<text class="{class}" x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{}</text>"#,
            escape(text)
        );
    }

    /// A thin line between two pixels, e.g. from a label to its marker.
    pub(crate) fn leader(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        let _ = write!(
            self.body,
            r#"<path class="leader {class}" d="M{:.1} {:.1}L{:.1} {:.1}"/>"#,
            from.0, from.1, to.0, to.1
        );
    }

    /// Right and lower end of the plot \[px\].
    pub(crate) fn plot_size(&self) -> (f64, f64) {
        let (_, right, _, bottom) = self.frame();
        (right, bottom)
    }

    /// The finished SVG element.
    pub(crate) fn render(self) -> String {
        let (width, height) = self.size;
        let (left, right, top, bottom) = self.frame();
        let mut svg = format!(
            r#"<svg viewBox="0 0 {width} {height}" role="img" aria-label="{}">"#,
            self.title
        );
        self.push_grid(&mut svg);
        svg.push_str(&self.body);
        let _ = write!(svg, r#"<path class="axis" d="M{left} {top}V{bottom}H{right}"/>"#);
        let _ = write!(
            svg,
            r#"<text class="name" x="{:.1}" y="{:.1}" text-anchor="middle">{}</text>"#,
            0.5 * (left + right),
            height - 6.0,
            self.x.name
        );
        let _ = write!(
            svg,
            r#"<text class="name" transform="translate(13 {:.1}) rotate(-90)" text-anchor="middle">{}</text></svg>"#,
            0.5 * (top + bottom),
            self.y.name
        );
        svg
    }

    fn push_grid(&self, svg: &mut String) {
        let (left, right, top, bottom) = self.frame();
        for (value, label) in self.x.ticks() {
            let Some(fraction) = self.x.fraction(value) else {
                continue;
            };
            let x = left + fraction * (right - left);
            match label {
                Some(label) => {
                    let _ = write!(svg, r#"<path class="grid" d="M{x:.1} {top}V{bottom}"/>"#);
                    let y = bottom + 16.0;
                    let _ = write!(
                        svg,
                        r#"<text class="tick" x="{x:.1}" y="{y}" text-anchor="middle">{label}</text>"#
                    );
                }
                None => {
                    let _ = write!(svg, r#"<path class="axis" d="M{x:.1} {bottom}v4"/>"#);
                }
            }
        }
        for (value, label) in self.y.ticks() {
            let Some(fraction) = self.y.fraction(value) else {
                continue;
            };
            let y = bottom + fraction * (top - bottom);
            match label {
                Some(label) => {
                    let _ = write!(svg, r#"<path class="grid" d="M{left} {y:.1}H{right}"/>"#);
                    let _ = write!(
                        svg,
                        r#"<text class="tick" x="{:.1}" y="{:.1}" text-anchor="end">{label}</text>"#,
                        left - 8.0,
                        y + 4.0
                    );
                }
                None => {
                    let _ = write!(svg, r#"<path class="axis" d="M{left} {y:.1}h-4"/>"#);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_at_values_that_cannot_be_drawn() {
        let axes = || (Axis::log("x", [1.0, 100.0]), Axis::log("y", [1.0, 100.0]));
        let (x, y) = axes();
        let mut chart = Chart::new((400.0, 300.0), "t", x, y);
        let points = [(1.0, 1.0), (10.0, f64::NAN), (20.0, 2.0), (100.0, 100.0)];
        chart.line("c", &points);
        assert_eq!(chart.body.matches('M').count(), 2);
        assert_eq!(chart.body.matches('L').count(), 1);
    }
}
