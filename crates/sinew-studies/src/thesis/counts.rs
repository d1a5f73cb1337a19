//! Counts of figures by chapter, and what they hold.

use super::compare::{Compared, NEAR, Ours, Runs, Standing};
use super::page::{CHAPTERS, Tables, chapter_name, plain};
use super::printed::Table;
use super::stored::Stored;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Picture, remarks and counts at the head of the page.
pub(super) fn in_short(found: &Tables, runs: &Runs) -> String {
    let mut text = "\n## In short\n\n![× of every row, by chapter](thesis.svg)\n\n".to_string();
    for remark in [scaled(found), single(found), uncommitted(found, runs), behind(found)] {
        text += &remark.map_or(String::new(), |remark| format!("- {remark}\n"));
    }
    text + &summary(found)
}

/// Number of figures.
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
