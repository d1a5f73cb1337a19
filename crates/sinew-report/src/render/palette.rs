//! Colours and dashes of names.

use crate::{Block, Panel, Report};
use maud::{Markup, html};
use std::cell::Cell;

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
        let drawn =
            report.sections.iter().flat_map(|section| &section.blocks).flat_map(names_drawn);
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

fn names_drawn(block: &Block) -> Vec<&str> {
    let Block::Figure(figure) = block else { return Vec::new() };
    let charts = figure.panels.iter().filter_map(|panel| match panel {
        Panel::Chart(chart) => Some(chart),
        Panel::Map(_) => None,
    });
    charts.flat_map(|chart| &chart.series).map(|series| series.name.as_str()).collect()
}
