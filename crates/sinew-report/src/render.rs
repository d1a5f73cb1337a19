//! The page: one file, made from the data alone.

mod chart;
mod table;

use crate::format::{digits, seconds};
use crate::viewer::{self, Packed, Quantity, Source, Viewer, ViewerCase};
use crate::{Block, Figure, Report, Section, Surfaces};
use chart::Palette;
use maud::{Markup, Render, html};

const STYLE: &str = include_str!("render/style.css");

/// The whole page.
pub(crate) fn page(report: &Report) -> Markup {
    let palette = Palette::of(report);
    let blocks = || report.sections.iter().flat_map(|section| &section.blocks);
    let turned = blocks().any(|block| matches!(block, Block::Surfaces(of) if is_drawn(of)));
    let main = html! {
        header { h1 { (report.title) } p { (report.about) } (provenance(report)) }
        (summary(report))
        @for section in &report.sections { (self::section(section, &palette)) }
        (making(report))
    };
    let viewer = if turned { viewer::STYLE } else { "" };
    viewer::page(&report.title, "report", [STYLE, viewer], &main, turned)
}

fn facts(facts: impl IntoIterator<Item = (impl Render, impl Render)>) -> Markup {
    html! { dl.facts { @for (name, value) in facts { div { dt { (name) } dd { (value) } } } } }
}

fn provenance(report: &Report) -> Markup {
    let from = &report.provenance;
    let seed = from.seed.map_or("none".into(), |seed| seed.to_string());
    facts([
        ("machine", &from.machine),
        ("threads", &from.threads.to_string()),
        ("wall time", &seconds(from.wall_s)),
        ("seed", &seed),
        ("revision", &from.revision),
        ("finished", &from.finished),
    ])
}

/// Headline, errors above their published figures, notes and warnings.
fn summary(report: &Report) -> Markup {
    let judged = report.sections.iter().flat_map(|section| {
        let verdicts = section.tables().flat_map(crate::Table::verdicts);
        verdicts.map(move |found| (&section.title, found))
    });
    let short: Vec<_> = judged.filter(|(_, found)| !found.3.met).collect();
    let rows = report.tables().flat_map(|table| &table.rows);
    let warned: Vec<_> = rows.filter(|row| !row.warnings.is_empty()).collect();
    let sections = report.sections.len() > 1;
    let quiet = report.headline.is_empty() && report.notes.is_empty() && short.is_empty();
    if quiet && warned.is_empty() && !sections {
        return html! {};
    }
    html! {
        section.summary {
            h2 { "In short" }
            @if !report.headline.is_empty() { p.headline { (report.headline) } }
            @if !short.is_empty() {
                details open[short.len() < 9] {
                    summary.missed { "✗ " (short.len()) " of " (report.verdicts()[0]) " not met" }
                    ul { @for (section, (row, column, cell, verdict)) in short {
                        li { (section) ", " (column.name) " of " (row.name()) ": " (table::value(&cell.value, 2)) ", " (verdict.text) }
                    } }
                }
            }
            @if !report.notes.is_empty() { ul { @for note in &report.notes { li { (note) } } } }
            @if !warned.is_empty() {
                p.missed { "⚠ Not to be trusted before these are read:" }
                ul { @for row in warned { @for warning in &row.warnings { li { b { (row.method) } ": " (warning) } } } }
            }
            @if sections {
                nav aria-label="Sections" { @for section in &report.sections {
                    a href={ "#" (section.name) } { (section.title) } " "
                } }
            }
        }
    }
}

fn section(section: &Section, palette: &Palette) -> Markup {
    html! {
        section aria-labelledby=(section.name) {
            h2 id=(section.name) { (section.title) }
            @for block in &section.blocks { (self::block(block, palette)) }
        }
    }
}

fn block(block: &Block, palette: &Palette) -> Markup {
    match block {
        Block::Text(text) => html! { p { (text) } },
        Block::List(sentences) => html! { ul { @for sentence in sentences { li { (sentence) } } } },
        Block::Facts(list) => facts(list.iter().map(|(name, value)| (name, value))),
        Block::Table(table) => table::table(table, palette),
        Block::Listing { title, head, rows } => html! {
            details { summary { (title) } div.scroll tabindex="0" { table {
                thead { tr { @for name in head { th scope="col" { (name) } } } }
                tbody { @for row in rows { tr { @for cell in row { td { (table::value(&cell.value, 5)) } } } } }
            } } }
        },
        Block::Figure(figure) => self::figure(figure, palette),
        Block::Surfaces(surfaces) => self::surfaces(surfaces),
    }
}

fn figure(figure: &Figure, palette: &Palette) -> Markup {
    let wide = figure.panels.len() == 1;
    html! {
        h3 { (figure.title) }
        @if !figure.caption.is_empty() { p.note { (figure.caption) } }
        div.panels.wide[wide] { @for chart in &figure.panels { (chart::chart(chart, palette, wide)) } }
    }
}

/// Command, definitions, configuration and versions.
fn making(report: &Report) -> Markup {
    let from = &report.provenance;
    let columns = report.tables().flat_map(|t| t.errors.iter().chain(&t.times).chain(&t.others));
    let own = report.definitions.iter().map(|(term, text)| (term.as_str(), text.as_str()));
    let mut terms: Vec<(&str, &str)> =
        columns.map(|c| (c.name.as_str(), c.about.as_str())).chain(own).collect();
    let mut seen = std::collections::HashSet::new();
    terms.retain(|(term, text)| !text.is_empty() && seen.insert(*term));
    html! {
        section {
            h2 { "How these numbers were made" }
            pre { code { (from.command) } }
            dl.definitions { @for (term, text) in terms { dt { (term) } dd { (text) } } }
            @if !from.config.is_empty() {
                details { summary { "Configuration" } pre { code { (from.config) } } }
            }
            @if !from.versions.is_empty() {
                details { summary { "Versions" } (facts(&from.versions)) }
            }
            p.note { "The same numbers are in " code { "report.json" } ", schema " (report.schema) "." }
        }
    }
}

/// Colours span this many decades below the largest value; smaller values share the lowest colour, or clamped nodes
/// would use up the scale.
const DECADES: i32 = 3;

/// Whether there is something to be turned, which the page's script draws.
fn is_drawn(surfaces: &Surfaces) -> bool {
    !surfaces.cases.is_empty() && !surfaces.reference.is_empty()
}

/// All cases with one view and one scale of colours, so that they can be compared.
fn surfaces(surfaces: &Surfaces) -> Markup {
    let values = surfaces.cases.iter().flat_map(|case| case.values.iter().flatten());
    let end = surfaces.scale().unwrap_or(0.0);
    let above = values.clone().filter(|value| f64::from(**value) > end).count();
    let above = 100.0 * above as f64 / values.count().max(1) as f64;
    html! { @if is_drawn(surfaces) {
        h3 { (surfaces.quantity) }
        p.note {
            "Deformed shapes to scale, coloured on one " (if surfaces.linear { "linear" } else { "logarithmic" })
            " scale for all; lines: the body at rest; grey: no value."
            @if above > 0.0 {
                " The scale ends where nearly all values lie below: " (digits(above, 2)) " % are larger and have the last colour."
            }
        }
        (viewer(surfaces, end).embedded())
    } }
}

fn viewer(surfaces: &Surfaces, end: f64) -> Viewer {
    let case = |case: &crate::SurfaceCase| {
        let largest = case.values.iter().flatten().copied().fold(0.0, f32::max);
        let largest = format!("largest {} {}", digits(largest.into(), 2), surfaces.unit);
        let (deformed, rest) = (case.deformed.as_flattened(), surfaces.reference.as_flattened());
        ViewerCase {
            title: format!("{}, {}, {largest}", case.method, case.title),
            displacement: Packed::f32(deformed.iter().zip(rest).map(|(x, at)| x - at)),
            values: Packed::f32(case.values.iter().map(|value| value.unwrap_or(f32::NAN))),
        }
    };
    let quantity = Quantity {
        name: surfaces.quantity.clone(),
        unit: surfaces.unit.clone(),
        source: Source::Case,
        scale: [if surfaces.linear { 0.0 } else { end * 10f64.powi(-DECADES) }, end],
        logarithmic: !surfaces.linear && end > 0.0,
        model: None,
    };
    Viewer {
        length: surfaces.length.clone(),
        points: Packed::f32(surfaces.reference.as_flattened().iter().copied()),
        triangles: Packed::u32(surfaces.triangles.as_flattened().iter().map(|&node| node as u32)),
        quantities: vec![quantity],
        cases: surfaces.cases.iter().map(case).collect(),
        ..Viewer::default()
    }
}
