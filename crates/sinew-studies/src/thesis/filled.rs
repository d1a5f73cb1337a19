//! Tables of the other pages, filled from kept reports between `<!-- table … -->` and `<!-- end -->`.

use super::compare::Runs;
use super::page::plain;
use super::stored::{Stored, cell, number};
use anyhow::{Context, Result};
use sinew_report::format::seconds;
use sinew_report::{Row, Table, Value};
use std::fmt::Write;

/// Pages under `docs` that have such tables.
pub const PAGES: [&str; 4] =
    ["results.md", "emulators.md", "populations.md", "gaussian-processes.md"];

const START: &str = "<!-- table ";
const END: &str = "<!-- end -->";

/// Page with all of its tables written anew.
///
/// A marker is `<!-- table RUN/SECTION, … | METHOD; … | COLUMN, … -->`. All methods are named by `*`. A column's largest value is `COLUMN max`.
/// A method's rows are those of the first table that names it. One column puts the methods side by side. Brackets hold the thesis' figure.
///
/// # Errors
/// A marker without an end; a run, section, method or column that no kept report has.
pub fn fill(page: &str, runs: &Runs) -> Result<String> {
    let mut parts = page.split(START);
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (marker, rest) = part.split_once(" -->\n").context("a marker has no ` -->`")?;
        let (_, rest) = rest.split_once(END).with_context(|| format!("no {END} after {marker}"))?;
        let filled = table(marker, runs).with_context(|| format!("table {marker}"))?;
        let _ = write!(text, "{START}{marker} -->\n\n{filled}\n{END}{rest}");
    }
    Ok(text)
}

/// A row with its table and its name in the page.
struct Named<'a> {
    name: String,
    table: &'a Table,
    row: &'a Row,
}

impl Named<'_> {
    /// Method, with its remark if it has several rows of the table under this name.
    fn method(&self, rows: &[Named]) -> String {
        let Row { method, about, .. } = self.row;
        let of_table = rows.iter().filter(|other| std::ptr::eq(other.table, self.table));
        let same = of_table.filter(|other| other.name == self.name && other.row.method == *method);
        match about.is_empty() || same.count() == 1 {
            true => method.clone(),
            false => format!("{method}, {about}"),
        }
    }

    /// Cell of a column, empty where its table has no such column.
    fn cell(&self, column: &str) -> String {
        let (name, statistic) = split(column);
        let Some(cell) = cell(self.table, self.row, name) else { return String::new() };
        let is_time = self.table.times.iter().any(|found| found.name == name);
        let thesis = cell.verdict.as_ref().filter(|verdict| verdict.text.contains("thesis"));
        match (number(&cell.value, statistic), &cell.value, thesis) {
            (Some(value), ..) if is_time => seconds(value),
            (Some(value), _, Some(verdict)) if statistic == "q50" => {
                format!("{} ({})", plain(value, 2), plain(verdict.limit, 2))
            }
            (Some(value), ..) => plain(value, 2),
            (None, Value::Text(words), _) => words.clone(),
            (None, Value::Number(_), _) => "not stored".into(),
            _ => String::new(),
        }
    }
}

fn split(column: &str) -> (&str, &str) {
    column.strip_suffix(" max").map_or((column, "q50"), |name| (name, "q100"))
}

fn table(marker: &str, runs: &Runs) -> Result<String> {
    let fields: Vec<&str> = marker.split(" | ").collect();
    let [places, methods, columns] = fields[..] else {
        anyhow::bail!("a marker has three fields, divided by ` | `; this has {}", fields.len())
    };
    let columns: Vec<&str> = columns.split(", ").collect();
    let (mut rows, mut used): (Vec<Named>, Vec<(&str, &Stored)>) = (Vec::new(), Vec::new());
    for place in places.split(", ") {
        let (run, section) = place.split_once('/').context("a place is RUN/SECTION")?;
        let stored = runs.get(run).with_context(|| format!("no report of run {run} is kept"))?;
        let first = rows.len();
        rows.extend(stored.rows_of(section).map(|(table, row)| Named {
            name: if row.subject.is_empty() { section.into() } else { row.subject.clone() },
            table,
            row,
        }));
        anyhow::ensure!(rows.len() > first, "run {run} has no rows in a section {section}");
        if !used.iter().any(|(found, _)| *found == run) {
            used.push((run, stored));
        }
    }
    let wanted: Vec<&str> = methods.split("; ").filter(|method| *method != "*").collect();
    for method in &wanted {
        let there = rows.iter().any(|found| found.row.method == *method);
        anyhow::ensure!(there, "no row has the method {method}");
    }
    let measured = |table: &Table| {
        let mut errors = table.errors.iter().chain(&table.others);
        errors.any(|error| columns.iter().any(|column| split(column).0 == error.name))
    };
    rows.retain(|found| wanted.is_empty() || wanted.contains(&&*found.row.method));
    rows.retain(|found| measured(found.table));
    let rows = of_first_tables(rows);
    let heads = columns.iter().map(|column| head(column, &rows)).collect::<Result<Vec<_>>>()?;
    let mut text = match (&columns[..], &heads[..]) {
        ([column], [head]) if !wanted.is_empty() => side_by_side(&rows, &wanted, column, head),
        _ => listed(&rows, &columns, &heads),
    };
    text.push('\n');
    used.iter().for_each(|(run, stored)| text += &source(run, stored));
    Ok(text)
}

/// Rows without those whose method an earlier table has under the same name.
fn of_first_tables(rows: Vec<Named>) -> Vec<Named> {
    let mut kept: Vec<Named> = Vec::new();
    for row in rows {
        let same = |other: &&Named| other.name == row.name && other.row.method == row.row.method;
        if kept.iter().find(same).is_none_or(|first| std::ptr::eq(first.table, row.table)) {
            kept.push(row);
        }
    }
    kept
}

/// Column's name with its unit: `err_u max [mm]`; a time has its unit beside it.
fn head(column: &str, rows: &[Named]) -> Result<String> {
    let name = split(column).0;
    let tables = || rows.iter().map(|row| row.table);
    if tables().flat_map(|table| &table.times).any(|found| found.name == name) {
        return Ok(column.into());
    }
    let all = tables().flat_map(|table| table.errors.iter().chain(&table.others));
    let found = all.into_iter().find(|found| found.name == name);
    let unit = &found.with_context(|| format!("no table has a column {name}"))?.unit;
    Ok(if unit.is_empty() { column.into() } else { format!("{column} \\[{unit}\\]") })
}

fn line<'a>(cells: impl IntoIterator<Item = &'a str>) -> String {
    format!("| {} |\n", cells.into_iter().collect::<Vec<_>>().join(" | "))
}

/// One line a row.
fn listed(rows: &[Named], columns: &[&str], heads: &[String]) -> String {
    let mut text = line(["", "method"].into_iter().chain(heads.iter().map(String::as_str)));
    text += &format!("{}|\n", "|---".repeat(columns.len() + 2));
    let mut before = "";
    for found in rows {
        let name = if found.name == before { "" } else { &*found.name };
        before = &found.name;
        let cells: Vec<String> = columns.iter().map(|column| found.cell(column)).collect();
        text += &line([name, &*found.method(rows)].into_iter().chain(cells.iter().map(|c| &**c)));
    }
    text
}

/// One line a body, one column a method.
fn side_by_side(rows: &[Named], methods: &[&str], column: &str, head: &str) -> String {
    let mut text = line([head].into_iter().chain(methods.iter().copied()));
    text += &format!("{}|\n", "|---".repeat(methods.len() + 1));
    let mut names: Vec<&str> = rows.iter().map(|found| &*found.name).collect();
    names.dedup();
    for name in names {
        let of = |method: &&str| rows.iter().find(|r| r.name == name && r.row.method == **method);
        let cells =
            methods.iter().map(|method| of(method).map_or(String::new(), |r| r.cell(column)));
        let cells: Vec<String> = cells.collect();
        text += &line([name].into_iter().chain(cells.iter().map(String::as_str)));
    }
    text
}

fn source(run: &str, Stored { command, cpu_s, report }: &Stored) -> String {
    let from = &report.provenance;
    let cost = cpu_s.map_or(String::new(), |s| format!(", {} CPU min", plain(s / 60.0, 2)));
    let date = from.finished.split(' ').next().unwrap_or_default();
    format!("Run `{run}`: `{command}`{cost}, {}, {date}.\n", from.machine)
}
