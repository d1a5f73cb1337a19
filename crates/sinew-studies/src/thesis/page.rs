//! The page of all figures, in Markdown, the × of its rows in one drawing, and counts of figures by chapter.

use super::compare::{Compared, NEAR, Ours, Runs, Standing, compare};
use super::printed::{Remark, Table, thesis};
use super::stored::Stored;
use anyhow::{Context, Result};
use sinew_report::{Block, Chart, Level, Report, Section, Series, Style};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

const HEAD: &str = include_str!("head.md.in");

/// Writes the page from what is kept of the runs.
///
/// # Errors
/// A table of the thesis that is not well formed.
pub fn page(runs: &Runs) -> Result<String> {
    let found = compared(runs)?;
    let mut text = HEAD.to_string();
    text += &in_short(&found, runs);
    text += &self::runs(runs);
    for chapter in CHAPTERS {
        let _ = write!(text, "\n## {}\n", chapter_name(chapter));
        for (table, cells) in found.iter().filter(|(table, _)| table.chapter == chapter) {
            text += &self::table(table, cells, runs);
        }
    }
    text += &remarks("Contradictions and misprints of the thesis", &thesis().misprint);
    text += &remarks("Slips of these documents, mended", &thesis().slip);
    Ok(text)
}

/// Tables of the thesis with figures of ours.
pub(super) type Tables = Vec<(&'static Table, Vec<Compared>)>;

/// All tables in the order of the file.
pub(super) fn compared(runs: &Runs) -> Result<Tables> {
    thesis().table.iter().map(|table| Ok((table, compare(table, runs)?))).collect()
}

/// Chapters and appendices in the order of the page.
pub(super) const CHAPTERS: [&str; 6] = ["1", "2", "A", "3", "B", "4"];

pub(super) fn chapter_name(chapter: &str) -> String {
    let name = if chapter.parse::<u32>().is_ok() { "Chapter" } else { "Appendix" };
    format!("{name} {chapter}")
}

fn runs(runs: &Runs) -> String {
    let mut text = "\n## Runs\n\n| run | command | CPU min | seed | finished | revision |\n|---|---|---|---|---|---|\n".to_string();
    let mut machines = BTreeSet::new();
    for run in &thesis().run {
        let Some(Stored { command, cpu_s, report }) = runs.get(&run.name) else {
            let command = run.command();
            let _ = writeln!(
                text,
                "| {} | `{command}` | not run, about {} | | | |",
                run.name, run.minutes
            );
            continue;
        };
        let from = &report.provenance;
        let minutes = cpu_s.map_or("–".into(), |seconds| plain(seconds / 60.0, 2));
        let seed = from.seed.map_or(String::new(), |seed| seed.to_string());
        let resumed = if from.command.contains("--resume") { ", last part" } else { "" };
        let _ = writeln!(
            text,
            "| {} | `{command}` | {minutes} | {seed} | {} | {}{resumed} |",
            run.name, from.finished, from.revision
        );
        machines.insert(&*from.machine);
    }
    if !machines.is_empty() {
        let machines = machines.into_iter().collect::<Vec<_>>().join("; ");
        let _ = writeln!(
            text,
            "\nA revision with `-dirty` had changes that no commit holds; of a run that was interrupted the revision is that of the last part. Machine: {machines}, shared with other programs."
        );
    }
    text
}

fn table(table: &Table, cells: &[Compared], runs: &Runs) -> String {
    let dirty = runs.get(&table.run).is_some_and(Stored::is_uncommitted);
    let tree = if dirty { ", of an uncommitted tree" } else { "" };
    let about = capital(&table.about);
    let mut text = format!("\n### {}\n\n{about}. Run `{}`{tree}.", table.place, table.run);
    if !table.note.is_empty() {
        let _ = write!(text, " {}", table.note);
    }
    text += "\n\n| | thesis | own kind | × | s | best | × | s | by |\n|---|---|---|---|---|---|---|---|---|\n";
    for Compared { cell, limit, own, best } in cells {
        let unit = if cell.unit.is_empty() { String::new() } else { format!(" {}", cell.unit) };
        let scaled = match (limit / cell.limit - 1.0).abs() > 1e-9 {
            true => format!(" → {}", plain(*limit, cell.digits)),
            false => String::new(),
        };
        let mark = if cell.mark.is_empty() { String::new() } else { format!(" ({})", cell.mark) };
        let by = best.found.as_ref().map_or("", |found| &found.method);
        let _ = writeln!(
            text,
            "| {} | {}{scaled}{unit}{mark} | {} | {} | {by} |",
            cell.what,
            cell.printed,
            columns(own, cell.digits),
            columns(best, cell.digits)
        );
    }
    text
}

fn columns(ours: &Ours, digits: usize) -> String {
    let Some(found) = &ours.found else { return format!("{} | | ", ours.standing.name()) };
    let mark = match ours.standing {
        Standing::Met => " ✓",
        Standing::Missed => " ✗",
        _ => "",
    };
    let before = found.before_s.filter(|seconds| *seconds > 0.0);
    let before = before.map_or(String::new(), |seconds| plain(seconds, 2));
    let again: String = ours.again.iter().map(|x| format!(" ({})", plain(*x, 2))).collect();
    format!("{}{mark} | {}{again} | {before}", plain(found.value, digits), plain(ours.ratio, 2))
}

fn remarks(title: &str, remarks: &[Remark]) -> String {
    let lines = remarks.iter().map(|remark| format!("- **{}**: {}\n", remark.place, remark.what));
    format!("\n## {title}\n\n{}", lines.collect::<String>())
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A number in so many digits, with a power of ten below 0.01 and from 10 000 on: `0.42`, `6.5e-3`.
pub(super) fn plain(value: f64, digits: usize) -> String {
    let scientific = format!("{:.*e}", digits - 1, value);
    let exponent: i32 = scientific.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    match exponent {
        -2..4 => format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize),
        _ => scientific,
    }
}

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

/// Picture, remarks and counts at the head of the page.
pub(super) fn in_short(found: &Tables, runs: &Runs) -> String {
    let mut text = "\n## In short\n\n![× of every row, by chapter](thesis.svg)\n\n".to_string();
    for remark in [scaled(found), single(found), uncommitted(found, runs), behind(found)] {
        text += &remark.map_or(String::new(), |remark| format!("- {remark}\n"));
    }
    text + &summary(found)
}

fn count(found: &Tables, wanted: impl Fn(&Table, &Compared) -> bool) -> usize {
    let of = |(table, cells): &(&Table, Vec<Compared>)| {
        cells.iter().filter(|cell| wanted(table, cell)).count()
    };
    found.iter().map(of).sum()
}

/// Limits that are no printed figures.
fn scaled(found: &Tables) -> Option<String> {
    let (scale, cells) = found.iter().find_map(|(table, c)| Some((table.scale.as_ref()?, c)))?;
    let factor = Some(cells[0].limit / cells[0].cell.limit).filter(|factor| *factor != 1.0)?;
    let factor = plain(factor, 2);
    let all = count(found, |table, _| table.scale.is_some());
    let [own, best] = [|cell: &Compared| cell.own.standing, |cell: &Compared| cell.best.standing]
        .map(|of| count(found, |table, cell| table.scale.is_some() && of(cell) == Standing::Met));
    let [here, there] = scale.nodes;
    Some(format!(
        "{all} limits are not the printed figures but {factor} of them, written behind an arrow. They are in proportion to the mean displacement, which is smaller on our meshes of {here} nodes than on those of {there}. Own kind meets {own} of these limits, best {best}."
    ))
}

/// Figures that chance may carry over a limit.
fn single(found: &Tables) -> Option<String> {
    let near = |cell: &Compared| NEAR.contains(&cell.own.ratio);
    Some(format!(
        "{} figures are of single test cases. {} figures of our own kind have a × between {} and {}, where another seed may change the mark. {} of them have a second seed.",
        count(found, |_, cell| cell.cell.mark == "one case"),
        count(found, |_, cell| near(cell)),
        NEAR.start(),
        NEAR.end(),
        count(found, |_, cell| !cell.own.again.is_empty())
    ))
}

/// Figures of runs that cannot be repeated from a commit.
fn uncommitted(found: &Tables, runs: &Runs) -> Option<String> {
    let dirty = |name: &str| runs.get(name).is_some_and(Stored::is_uncommitted);
    let names: Vec<&str> = runs.keys().map(String::as_str).filter(|name| dirty(name)).collect();
    let figures = count(found, |table, _| dirty(&table.run));
    let names = (!names.is_empty()).then(|| names.join(","))?;
    Some(format!(
        "{figures} figures are of runs with changes that no commit holds. `cargo xtask thesis --again --only {names}` repeats them."
    ))
}

/// Rows of the fits and trainings that stand most often as the best.
fn behind(found: &Tables) -> Option<String> {
    let mut rows: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let cells = found.iter().flat_map(|(_, cells)| cells);
    for best in cells.filter_map(|cell| cell.best.found.as_ref()) {
        *rows.entry(best.made()).or_default() += 1;
    }
    let mut rows: Vec<_> = rows.into_iter().map(|(made, count)| (count, made)).collect();
    rows.sort_by(|a, b| b.cmp(a));
    let [(first, one), (second, other), ..] = rows[..] else { return None };
    Some(format!(
        "*By* counts the fits and trainings behind the figures. Of the best, `{}` alone stands in {first} rows, `{}` in {second}.",
        one.1, other.1
    ))
}

/// Numbers of figures by chapter and standing, and of fits and trainings behind them.
fn summary(found: &Tables) -> String {
    let names = Standing::ALL.map(Standing::name).join(" | ");
    let rule = "|---".repeat(4 + 2 * Standing::ALL.len());
    let mut text =
        format!("\n| | figures | own kind: {names} | by | best: {names} | by |\n{rule}|\n");
    let mut line = |name: String, wanted: &dyn Fn(&Table) -> bool| {
        let tables = found.iter().filter(|(table, _)| wanted(table));
        let cells: Vec<&Compared> = tables.flat_map(|(_, cells)| cells).collect();
        let (own, best) = (counts(&cells, |cell| &cell.own), counts(&cells, |cell| &cell.best));
        if !cells.is_empty() {
            let _ = writeln!(text, "| {name} | {} | {own} | {best} |", cells.len());
        }
    };
    for chapter in CHAPTERS {
        for (times, what) in [(false, "errors"), (true, "times")] {
            let name = format!("{}, {what}", chapter_name(chapter));
            line(name, &|table| table.chapter == chapter && table.kind.is_time() == times);
        }
    }
    line("**Errors**".into(), &|table| !table.kind.is_time());
    line("**Times**".into(), &|table| table.kind.is_time());
    line("**All**".into(), &|_| true);
    text
}

/// Numbers of each standing, and of fits and trainings.
fn counts(cells: &[&Compared], of: impl Fn(&Compared) -> &Ours) -> String {
    let with = |standing| cells.iter().filter(|cell| of(cell).standing == standing).count();
    let counts = Standing::ALL.map(|standing| with(standing).to_string()).join(" | ");
    let made = cells.iter().filter_map(|cell| Some((of(cell).found.as_ref()?.made(), ())));
    format!("{counts} | {}", made.collect::<BTreeMap<_, _>>().len())
}
