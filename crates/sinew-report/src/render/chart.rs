//! Curves and points, drawn by kuva in colours of the page's style.

use crate::format::{digits, power_of_ten, trimmed};
use crate::{Block, Chart, Report, Series, Style};
use kuva::plot::annotations::ReferenceLine;
use kuva::prelude::{
    BandPlot, Layout, LegendPosition, LinePlot, LineStyle, MarkerShape, Plot, ScatterPlot,
};
use kuva::render::{layout::TickFormat, theme::Theme};
use maud::{Markup, PreEscaped, html};
use std::cell::Cell;
use std::sync::Arc;

const MARKERS: [MarkerShape; COLOURS] = [
    MarkerShape::Circle,
    MarkerShape::Triangle,
    MarkerShape::Square,
    MarkerShape::Diamond,
    MarkerShape::TriangleDown,
    MarkerShape::Pentagon,
    MarkerShape::Cross,
    MarkerShape::Plus,
];
/// kuva takes what is below 1e-10 on a logarithmic axis for 1e-10; smaller data are scaled up to this.
const LEAST: f64 = 1e-6;
/// Range of a logarithmic axis: scaled values stay finite.
const LOGARITHMIC: std::ops::Range<f64> = 1e-100..1e100;

/// One axis: what can be drawn on it, and by how much it is scaled.
#[derive(Clone, Copy)]
struct Axis {
    logarithmic: bool,
    scale: f64,
    ends: [f64; 2],
}

impl Axis {
    fn over(logarithmic: bool, values: impl Iterator<Item = f64>) -> Option<Self> {
        let all = Self { logarithmic, scale: 1.0, ends: [f64::NEG_INFINITY, f64::INFINITY] };
        let shown = values.filter(|x| all.shows(*x)).map(|x| [x; 2]);
        let [low, high] = shown.reduce(|[low, high], [x, _]| [low.min(x), high.max(x)])?;
        let largest = low.abs().max(high.abs());
        let exponent = match logarithmic {
            true if low < LEAST => -low.log10().floor(),
            // Ticks of the library are made for numbers of usual size.
            false if largest > 0.0 && !(LEAST..1.0 / LEAST).contains(&largest) => {
                -largest.log10().floor()
            }
            _ => 0.0,
        };
        let room = (0.04 * (high - low)).max(1e-3 * largest);
        let room = if room > 0.0 { room } else { 1.0 };
        let ends = match logarithmic {
            true if high < 10.0 * low => [low / 2.0, high * 2.0],
            // Markers at the ends stay whole.
            true => {
                let room = (high / low).powf(0.04);
                [low / room, high * room]
            }
            false => [low - room, high + room],
        };
        Some(Self { logarithmic, scale: 10f64.powf(exponent), ends })
    }

    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.logarithmic || LOGARITHMIC.contains(&value))
    }

    /// Powers of ten by their exponents where there are several, not all where there are many.
    fn format(self) -> TickFormat {
        let decades = if self.logarithmic { (self.ends[1] / self.ends[0]).log10() } else { 0.0 };
        let stride = (decades / 14.0).ceil().max(1.0);
        TickFormat::Custom(Arc::new(move |value| {
            let value = value / self.scale;
            let exponent = value.abs().log10().round();
            let power = (value / 10f64.powf(exponent) - 1.0).abs() < 1e-6;
            match self.logarithmic {
                true if power && exponent % stride != 0.0 => String::new(),
                true if power && decades >= 2.0 => power_of_ten(exponent as i32),
                true => digits(value, 1),
                // Zero but for rounding.
                false if value.abs() < 1e-9 * (self.ends[1] - self.ends[0]) => "0".into(),
                false => trimmed(value, 4),
            }
        }))
    }
}

/// The chart with its title; says what could not be drawn.
pub(super) fn chart(chart: &Chart, palette: &Palette, wide: bool) -> Markup {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let levels =
        |upright| chart.levels.iter().filter(move |l| l.upright == upright).map(|l| l.value);
    // The ends of a band are values of the second axis.
    let bands = chart.series.iter().flat_map(|series| series.band.iter().flatten().copied());
    let x = Axis::over(chart.logarithmic[0], points().map(|p| p[0]).chain(levels(true)));
    let y =
        Axis::over(chart.logarithmic[1], points().map(|p| p[1]).chain(levels(false)).chain(bands));
    let axes = x.zip(y);
    let is_shown = |p: &&[f64; 2]| axes.is_some_and(|(x, y)| x.shows(p[0]) && y.shows(p[1]));
    let total = points().count();
    let hidden = total - points().filter(is_shown).count();
    html! { figure {
        figcaption { (chart.title) }
        @match axes {
            Some((x, y)) => { (PreEscaped(draw(chart, palette, wide, [x, y]))) }
            None => { p.empty { "Nothing to draw." } }
        }
        @if hidden > 0 { p.note {
            (hidden) " of " (total) " points are not drawn: not finite, or not positive on a logarithmic axis."
        } }
    } }
}

fn draw(chart: &Chart, palette: &Palette, wide: bool, axes: [Axis; 2]) -> String {
    let mut plots: Vec<Plot> = Vec::new();
    for (at, series) in chart.series.iter().enumerate() {
        let first = chart.series[..at].iter().all(|other| other.name != series.name);
        push(&mut plots, series, palette, axes, first);
    }
    let size = if wide { (940.0, 400.0) } else { (470.0, 320.0) };
    let [[left, right], [bottom, top]] = axes.map(|axis| axis.ends.map(|end| end * axis.scale));
    let mut layout = Layout::auto_from_plots(&plots).with_theme(theme());
    (layout.log_x, layout.log_y) = (axes[0].logarithmic, axes[1].logarithmic);
    layout = layout
        .with_width(size.0)
        .with_height(size.1)
        .with_x_label(chart.axes[0].as_str())
        .with_y_label(chart.axes[1].as_str())
        .with_x_tick_format(axes[0].format())
        .with_y_tick_format(axes[1].format())
        .with_x_axis_min(left)
        .with_x_axis_max(right)
        .with_y_axis_min(bottom)
        .with_y_axis_max(top)
        .with_x_label_overlap(kuva::render::layout::AxisLabelOverlap::Thin)
        .with_legend_position(LegendPosition::OutsideBottomColumns)
        .with_label_size(12)
        .with_tick_size(11)
        .with_body_size(12);
    for level in
        chart.levels.iter().filter(|level| axes[usize::from(!level.upright)].shows(level.value))
    {
        let line = match level.upright {
            true => ReferenceLine::vertical(level.value * axes[0].scale),
            false => ReferenceLine::horizontal(level.value * axes[1].scale),
        };
        let dashes = if level.published { "2 4" } else { "5 3" };
        layout = layout.with_reference_line(
            line.with_color(palette.colour(&level.name))
                .with_dasharray(dashes)
                .with_stroke_width(1.5),
        );
    }
    inline(&kuva::render_to_svg(plots, layout), size, &chart.title, palette)
}

/// Descent of letters below their line, and a margin.
const BELOW: f64 = 8.0;

/// Lines are broken where a point cannot be drawn.
fn push(plots: &mut Vec<Plot>, series: &Series, palette: &Palette, axes: [Axis; 2], first: bool) {
    let colour = palette.colour(&series.name);
    let number = palette.number(&series.name).unwrap_or(0);
    let place = |[x, y]: [f64; 2]| (x * axes[0].scale, y * axes[1].scale);
    let shown = |[x, y]: &[f64; 2]| axes[0].shows(*x) && axes[1].shows(*y);
    let named = !series.name.is_empty();
    let band = series.points.iter().zip(&series.band);
    let band: Vec<_> =
        band.filter(|(p, b)| shown(p) && shown(&[p[0], b[0]]) && b[1].is_finite()).collect();
    if !band.is_empty() {
        let end = |side: usize| band.iter().map(move |(_, b)| b[side] * axes[1].scale);
        let places = band.iter().map(|(p, _)| p[0] * axes[0].scale);
        plots.push(
            BandPlot::new(places, end(0), end(1)).with_color(&colour).with_opacity(0.18).into(),
        );
    }
    let mut legend = first && named;
    if series.style != Style::Points {
        for run in series.points.split(|point| !shown(point)).filter(|run| !run.is_empty()) {
            let mut line =
                LinePlot::new().with_data(run.iter().map(|p| place(*p))).with_color(&colour);
            line = line.with_stroke_width(if named { 2.0 } else { 1.0 });
            if let Some(dashes) = palette.dashes(&series.name) {
                line = line.with_line_style(LineStyle::Custom(dashes.into()));
            }
            if series.style == Style::Area {
                line = line.with_fill().with_fill_opacity(0.12);
            }
            if std::mem::take(&mut legend) && series.style != Style::Marked {
                line = line.with_legend(&series.name);
            }
            plots.push(line.into());
        }
    }
    let marked: Vec<usize> =
        (0..series.points.len()).filter(|&i| shown(&series.points[i])).collect();
    let has_markers = matches!(series.style, Style::Marked | Style::Points);
    // A line that is one point would not be seen.
    if marked.len() == 1 || has_markers && !marked.is_empty() {
        let mut points = ScatterPlot::new()
            .with_data(marked.iter().map(|&i| place(series.points[i])))
            .with_color(&colour)
            .with_size(4.0)
            .with_marker(MARKERS[(number + number / COLOURS) % MARKERS.len()]);
        if !series.hints.is_empty() {
            points = points.with_tooltip_labels(marked.iter().map(|&i| series.hints[i].clone()));
        }
        if first && named && has_markers {
            points = points.with_legend(&series.name);
        }
        plots.push(points.into());
    }
}

fn theme() -> Theme {
    let [dim, grid, text, none] =
        ["var(--dim)", "var(--grid)", "var(--text)", "none"].map(String::from);
    Theme {
        background: none.clone(),
        axis_color: dim.clone(),
        grid_color: grid,
        tick_color: dim,
        text_color: text,
        legend_bg: none.clone(),
        legend_border: none,
        ..Theme::light()
    }
}

/// Chart as part of a page: of any width, named for screen readers, with identifiers that are the chart's own.
fn inline(svg: &str, (width, height): (f64, f64), title: &str, palette: &Palette) -> String {
    let number = palette.charts.replace(palette.charts.get() + 1);
    let body = svg.split_once('>').map_or("", |parts| parts.1);
    // The library keeps room for two rows of a legend.
    let texts = body.split("<text ").skip(1);
    let lines =
        texts.filter_map(|text| text.split_once(" y=\"")?.1.split_once('"')?.0.parse().ok());
    let height = lines.fold(height, |height: f64, line: f64| height.max(line + BELOW));
    let head = html! {
        svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(title) fill="var(--text)" {}
    };
    let mut text = head.into_string().replace("></svg>", ">") + body;
    // The library numbers its clipping areas over the life of the process.
    if let Some(id) = svg.split_once("id=\"kuva-clip-").and_then(|found| found.1.split_once('"')) {
        text = text.replace(&format!("kuva-clip-{}", id.0), &format!("clip-{number}"));
    }
    text
}

/// Colours of the style sheet.
pub(super) const COLOURS: usize = 8;
/// Lines of the first names, of as many more, and so on: 32 names differ.
const DASHES: [Option<&str>; 4] = [None, Some("6 3"), Some("2 2"), Some("8 2 2 2")];

/// Colours by name, and the number of charts drawn.
pub(super) struct Palette<'a> {
    names: Vec<&'a str>,
    pub(super) charts: Cell<usize>,
}

impl<'a> Palette<'a> {
    /// Names in the order in which a reader meets them, those of tables first.
    pub(super) fn of(report: &'a Report) -> Self {
        let methods = report.tables().flat_map(|table| &table.rows).map(|row| &row.method);
        let mut names: Vec<&str> = Vec::new();
        let blocks = report.sections.iter().flat_map(|section| &section.blocks);
        let figures = blocks.filter_map(|b| if let Block::Figure(f) = b { Some(f) } else { None });
        let series = figures.flat_map(|figure| &figure.panels).flat_map(|chart| &chart.series);
        let drawn = series.map(|series| series.name.as_str());
        for name in methods.map(String::as_str).chain(drawn) {
            if !name.is_empty() && !names.contains(&name) {
                names.push(name);
            }
        }
        Self { names, charts: Cell::new(0) }
    }

    pub(super) fn number(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| *known == name)
    }

    pub(super) fn colour(&self, name: &str) -> String {
        self.number(name).map_or("var(--dim)".into(), |n| format!("var(--c{})", n % COLOURS))
    }

    /// Dashes of the lines of a name: beyond the colours, they tell names apart. None for a solid line.
    pub(super) fn dashes(&self, name: &str) -> Option<&'static str> {
        let round = self.number(name)? / COLOURS;
        DASHES[round % DASHES.len()]
    }

    /// A piece of the line that a name has in charts.
    pub(super) fn key(&self, name: &str) -> Markup {
        html! { svg.key viewBox="0 0 22 10" aria-hidden="true" {
            path d="M0 5h22" style={ "stroke:" (self.colour(name)) } stroke-dasharray=[self.dashes(name)] {}
        } }
    }
}
