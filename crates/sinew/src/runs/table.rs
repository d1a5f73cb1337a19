//! A CSV table of runs.

use crate::case::advise;
use crate::theta::{ThetaText, cells, head, is_comment, table_text};
use std::path::Path;

/// Advice about runs that failed.
const OMIT: &str = "mend it, or leave failed runs out: delete their lines, or begin them with #";

/// Whether a column says which runs failed.
pub(super) fn is_flag(head: &str) -> bool {
    let flags = ["failure", "failed", "converged", "success", "status"];
    flags.iter().any(|flag| head.eq_ignore_ascii_case(flag))
}

/// Whether a cell says that its run failed: a reason in `failure`, as [`crate::output::Results`] writes it, or a flag or word of other programs.
fn has_failed(head: &str, cell: &str) -> bool {
    let cell = cell.to_ascii_lowercase();
    let number = cell.parse::<f64>().ok();
    let is_no = number == Some(0.0) || ["false", "no", "none"].contains(&&*cell);
    match &*head.to_ascii_lowercase() {
        "failure" | "failed" => {
            !cell.is_empty() && !is_no && number.is_none_or(|number| number == 1.0)
        }
        "converged" | "success" => is_no,
        "status" => {
            ["fail", "diverg", "error", "abort", "not "].iter().any(|word| cell.contains(word))
        }
        _ => false,
    }
}

/// A table with names in its first line.
pub(super) struct Table<'a> {
    file: &'a Path,
    /// Line of the names.
    pub(super) first: usize,
    pub(super) heads: Vec<String>,
    /// Cells of each row, with the number of its line.
    pub(super) rows: Vec<(usize, Vec<String>)>,
    /// Lines of failed runs, with the column that says so.
    pub(super) failed: Vec<(usize, String)>,
}

impl<'a> Table<'a> {
    pub(super) fn read(file: &'a Path) -> Result<Self, ThetaText> {
        let (heads, rows, failed) = (Vec::new(), Vec::new(), Vec::new());
        let mut table = Self { file, first: 0, heads, rows, failed };
        let text = table_text(file).map_err(|reason| table.error(0, reason))?;
        for (line, text) in (1..).zip(text.lines()).filter(|(_, line)| !is_comment(line)) {
            let cells = cells(text);
            match table.heads.len() {
                0 => (table.first, table.heads) = (line, cells),
                count if count == cells.len() => {
                    let mut pairs = table.heads.iter().zip(&cells);
                    match pairs.find(|(head, cell)| has_failed(head, cell)) {
                        Some((head, _)) => table.failed.push((line, head.clone())),
                        None => table.rows.push((line, cells)),
                    }
                }
                count => {
                    let reason = format!("{} values for {count} columns; {OMIT}", cells.len());
                    return Err(table.error(line, reason));
                }
            }
        }
        match table.heads.is_empty() {
            true => Err(table.error(0, "the table is empty".into())),
            false => Ok(table),
        }
    }

    /// An error of a line, of the whole table if that is 0.
    pub(super) fn error(&self, line: usize, reason: String) -> ThetaText {
        let line = if line > 0 { format!(", line {line}") } else { String::new() };
        ThetaText { place: format!("{}{line}", self.file.display()), reason }
    }

    /// Name and unit.
    pub(super) fn head(&self, column: usize) -> (&str, &str) {
        head(&self.heads[column])
    }

    /// Places of the columns of a list.
    pub(super) fn columns(&self, list: &str) -> Result<Vec<usize>, ThetaText> {
        let names: Vec<&str> = self.heads.iter().map(|text| head(text).0).collect();
        let place = |name: String| {
            let mut found = (0..names.len()).filter(|&column| names[column] == name);
            let reason = match (found.next(), found.next()) {
                (Some(column), None) => return Ok(column),
                (Some(_), Some(_)) => format!("`{name}` is there twice; rename one"),
                (None, _) => {
                    let advice = advise(&name, names.iter().copied(), "the columns are");
                    let other = names.iter().any(|name| name.contains([';', '\t']));
                    let commas = "; separate columns by commas, with points in decimals";
                    format!(
                        "there is no column `{name}`{advice}{}",
                        if other { commas } else { "" }
                    )
                }
            };
            Err(self.error(self.first, reason))
        };
        cells(list).into_iter().map(place).collect()
    }

    pub(super) fn numbers(&self, columns: &[usize]) -> Result<Vec<Vec<f64>>, ThetaText> {
        let value = |(line, cells): &(usize, Vec<String>), column: usize| {
            let (cell, (name, _)) = (&cells[column], self.head(column));
            let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
            let reason = || format!("`{cell}` in the column `{name}` is not a finite number");
            value.ok_or_else(|| (*line, reason()))
        };
        let row = |row| columns.iter().map(|&column| value(row, column)).collect();
        let rows: Vec<Result<Vec<f64>, _>> = self.rows.iter().map(row).collect();
        let also = match rows.iter().filter(|row| row.is_err()).count() {
            0 | 1 => String::new(),
            2 => " (one more line has such a cell)".into(),
            failed => format!(" (and {} more lines have such cells)", failed - 1),
        };
        let told = |(line, reason)| self.error(line, format!("{reason}{also}; {OMIT}"));
        rows.into_iter().collect::<Result<_, _>>().map_err(told)
    }
}
