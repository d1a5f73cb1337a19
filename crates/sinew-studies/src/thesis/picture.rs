//! The × of every row of the page in one drawing, `docs/thesis.svg`.

use super::compare::{Ours, Runs, Standing};
use super::page::{CHAPTERS, chapter_name, compared};
use anyhow::{Context, Result};
use sinew_report::{Block, Chart, Level, Report, Section, Series, Style};

/// Draws ours over the printed figure, row by row: the own kind of every chapter, the best, and times that are neither met nor missed.
///
/// # Errors
/// A table of the thesis that is not well formed.
pub fn picture(runs: &Runs) -> Result<String> {
    let found = compared(runs)?;
    let axes = ["row of this page", "ours over the thesis' (×)"];
    let mut chart = Chart::new("Ours over the thesis'", axes, [false, true]);
    let (mut best, mut beside, mut own, mut row) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
    let line = |value, upright| Level { name: String::new(), value, upright, published: upright };
    chart.levels.push(line(1.0, false));
    for chapter in CHAPTERS {
        let tables = found.iter().filter(|(table, _)| table.chapter == chapter);
        let mut points = Vec::new();
        for cell in tables.flat_map(|(_, cells)| cells) {
            row += 1.0;
            let point = |ours: &Ours| ours.found.as_ref().map(|_| [row, ours.ratio]);
            match cell.own.standing {
                Standing::Beside => beside.extend(point(&cell.own)),
                _ => points.extend(point(&cell.own)),
            }
            best.extend(point(&cell.best).filter(|_| cell.best.standing != Standing::Beside));
        }
        let name = format!("own kind, {}", chapter_name(chapter));
        own.push(Series::new(name, Style::Points, points));
        chart.levels.push(line(row + 0.5, true));
    }
    let others = [("best of all emulators", best), ("GPU or solver: no ✓ or ✗", beside)];
    let others = others.map(|(name, points)| Series::new(name, Style::Points, points));
    chart.series = others.into_iter().chain(own).collect();
    drawing(chart).context("the page of a report has no drawing")
}

/// A chart as a file of its own, in the colours of a report's page.
fn drawing(chart: Chart) -> Option<String> {
    let section = Section { blocks: vec![Block::charts("", "", [chart])], ..Section::default() };
    let page = Report { sections: vec![section], ..Report::default() }.to_html();
    let colours = page.split_once("<style>")?.1.split_once("* {")?.0;
    let (head, body) =
        page.split_once("<svg viewBox")?.1.split_once("</svg>")?.0.split_once('>')?;
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox{head}><style>{colours}svg {{ background: var(--card); font-family: sans-serif; }}</style>{body}</svg>\n"
    ))
}
