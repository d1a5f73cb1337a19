//! Kept results of a run: tables and facts of its report, command and cost.

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use sinew_emulate::store;
use sinew_report::{Block, Cell, Column, Report, Row, Section, Table, Value};
use std::path::Path;

/// Digits that are kept of every number.
const DIGITS: usize = 4;

/// A run's report without drawings, with what it took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stored {
    /// Command that repeats it.
    pub command: String,
    /// CPU time of all of its processes \[s\], where it was measured.
    pub cpu_s: Option<f64>,
    /// Tables and facts.
    pub report: Report,
}

/// A value in a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Value in the unit of its column, times in s.
    pub value: f64,
    /// Section of its report, which is the body that it is on.
    pub section: String,
    /// Method, with its subject if it has one.
    pub method: String,
    /// Everything before the first answer \[s\], where the table has it.
    pub before_s: Option<f64>,
}

impl Found {
    /// Fit or training behind it: section and method, without Newton steps.
    pub fn made(&self) -> (&str, &str) {
        let raw = self.method.strip_suffix(" Newton").and_then(|name| name.rsplit_once(" + "));
        (&self.section, raw.map_or(&*self.method, |(name, _)| name))
    }
}

/// Methods that are no emulators, by how their names begin: solvers, also on a coarse mesh, and the noise of the data.
const NO_EMULATORS: [&str; 5] =
    ["solver", "coarse solution", "frozen stiffness", "fem_", "noise floor"];

impl Stored {
    /// Whether it is of a tree with changes that no commit holds.
    pub fn is_uncommitted(&self) -> bool {
        self.report.provenance.revision.ends_with("-dirty")
    }

    /// Part of a report that is kept.
    pub fn new(command: String, cpu_s: Option<f64>, mut report: Report) -> Self {
        let kept = |block: &Block| matches!(block, Block::Table(_) | Block::Facts(_));
        for section in &mut report.sections {
            section.blocks.retain(kept);
            for block in &mut section.blocks {
                if let Block::Table(table) = block {
                    table.rows.iter_mut().for_each(shorten);
                }
            }
        }
        report.provenance.versions.clear();
        report.definitions.clear();
        Self { command, cpu_s, report }
    }

    /// Reads the kept report of a run, if there is one.
    ///
    /// # Errors
    /// A file that holds something else.
    pub fn read(folder: &Path, run: &str) -> Result<Option<Self>> {
        Ok(store::read_json(&folder.join(format!("{run}.json")))?)
    }

    /// Writes it into a folder.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, run: &str) -> Result<()> {
        // In one line a row, so that a change of one shows.
        let text = serde_json::to_string(self)?.replace("},{\"method\"", "},\n{\"method\"");
        let text = text.replace("},{\"subject\"", "},\n{\"subject\"") + "\n";
        Ok(store::write_bytes(&folder.join(format!("{run}.json")), text.as_bytes())?)
    }

    fn sections<'a>(&'a self, section: &'a str) -> impl Iterator<Item = &'a Section> {
        let wanted = move |found: &&Section| section.is_empty() || found.name == section;
        self.report.sections.iter().filter(wanted)
    }

    /// Rows of all tables of a section.
    pub fn rows_of<'a>(&'a self, section: &'a str) -> impl Iterator<Item = (&'a Table, &'a Row)> {
        let tables = self.sections(section).flat_map(Section::tables);
        tables.flat_map(|table| table.rows.iter().map(move |row| (table, row)))
    }

    /// Rows of a section that have a column, with their sections and tables.
    fn rows<'a>(
        &'a self,
        section: &'a str,
        column: &'a str,
    ) -> impl Iterator<Item = (&'a Section, &'a Table, &'a Row)> {
        let sections = self.sections(section);
        let tables = sections.flat_map(|section| section.tables().map(move |t| (section, t)));
        let tables = tables.filter(move |(_, table)| cell(table, &table.rows[0], column).is_some());
        tables.flat_map(|(section, table)| table.rows.iter().map(move |row| (section, table, row)))
    }

    /// Value of a row, which is named by method, subject and method, or all of its name.
    pub fn value(&self, [section, row, column]: [&str; 3], statistic: &str) -> Option<Found> {
        let whole = self.rows(section, column).find(|(.., found)| found.name() == row);
        let named = || self.rows(section, column).find(|(.., found)| is_named(found, row));
        whole.or_else(named).and_then(|place| found_in(place, column, statistic))
    }

    /// Least value of all rows on the same subject whose names hold a word, raw or after one Newton step; not of a solver.
    pub fn least(
        &self,
        [section, subject, column]: [&str; 3],
        word: &str,
        (statistic, step): (&str, bool),
    ) -> Option<Found> {
        let rows = self.rows(section, column).filter(|(_, table, row)| {
            let solves = table.baseline.as_ref() == Some(&row.method)
                || NO_EMULATORS.iter().any(|name| row.method.starts_with(name));
            let wanted = match step {
                true => row.method.ends_with("+ 1 Newton"),
                false => !row.method.ends_with("Newton"),
            };
            wanted && !solves && row.subject == subject && row.name().contains(word)
        });
        let values = rows.filter_map(|place| found_in(place, column, statistic));
        values.min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Subject of a row, or of others that its name begins with.
    pub fn subject<'a>(&'a self, [section, row, column]: [&'a str; 3]) -> Option<&'a str> {
        let rows = || self.rows(section, column).map(|(.., found)| found);
        let alike = |found: &&Row| !found.subject.is_empty() && row.starts_with(&found.subject);
        let own = rows().find(|found| is_named(found, row)).or_else(|| rows().find(alike));
        own.map(|found| &*found.subject)
    }

    /// Whether a section has a row, whatever its columns.
    pub fn has(&self, section: &str, row: &str) -> bool {
        let rows = self.sections(section).flat_map(Section::tables).flat_map(|table| &table.rows);
        rows.into_iter().any(|found| is_named(found, row))
    }

    /// Number after `mean` in a fact.
    ///
    /// # Errors
    /// No such fact.
    pub fn mean_of_fact(&self, name: &str) -> Result<f64> {
        let blocks = self.report.sections.iter().flat_map(|section| &section.blocks);
        let facts = blocks.filter_map(|block| match block {
            Block::Facts(facts) => Some(facts),
            _ => None,
        });
        let text = facts.flatten().find(|(found, _)| found == name).map(|(_, text)| text);
        let words = text.and_then(|text| text.split_once("mean "));
        let number = words.and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
        number.with_context(|| format!("there is no mean in a fact `{name}`"))
    }
}

/// Whether a row goes by a name: its method, with its subject, or with its setting too.
fn is_named(row: &Row, is: &str) -> bool {
    row.method == is || name(row) == is || row.name() == is
}

/// Subject and method.
fn name(row: &Row) -> String {
    if row.subject.is_empty() {
        row.method.clone()
    } else {
        format!("{}, {}", row.subject, row.method)
    }
}

/// Cell of a row in a column of its table.
pub(super) fn cell<'a>(table: &Table, row: &'a Row, column: &str) -> Option<&'a Cell> {
    let parts =
        [(&table.errors, &row.errors), (&table.times, &row.times), (&table.others, &row.others)];
    parts.into_iter().find_map(|(columns, cells)| {
        cells.get(columns.iter().position(|found| found.name == column)?)
    })
}

fn found_in(
    (section, table, row): (&Section, &Table, &Row),
    column: &str,
    statistic: &str,
) -> Option<Found> {
    let value = number(&cell(table, row, column)?.value, statistic)?;
    let before = |column: &Column| column.once || column.name == "seconds";
    let once = table.times.iter().zip(&row.times).filter(|(column, _)| before(column));
    let once: Vec<f64> = once.filter_map(|(_, cell)| cell.value.median()).collect();
    let before_s = (!once.is_empty()).then(|| once.iter().sum());
    let method = if row.subject.is_empty() { name(row) } else { row.name() };
    Some(Found { value, section: section.name.clone(), method, before_s })
}

/// Statistic of a value, `q50` or another; None for words. A number alone stands for the median and tells no other statistic.
pub(super) fn number(value: &Value, statistic: &str) -> Option<f64> {
    match value {
        Value::Distribution(found) => match statistic {
            "q25" => Some(found.q25),
            "q50" => Some(found.q50),
            "q75" => Some(found.q75),
            "q100" => Some(found.q100),
            "mean" => Some(found.mean),
            _ => None,
        },
        Value::Several(values) => number(values.first()?, statistic),
        other => other.median().filter(|_| statistic == "q50"),
    }
}

/// Leaves out densities and digits beyond [`DIGITS`].
fn shorten(row: &mut Row) {
    let cells = row.errors.iter_mut().chain(&mut row.times).chain(&mut row.others);
    cells.for_each(|cell| shorten_value(&mut cell.value));
}

fn shorten_value(value: &mut Value) {
    let short = |number: &mut f64| *number = sinew_report::format::rounded(*number, DIGITS);
    match value {
        Value::Number(number) => short(number),
        Value::Several(values) => values.iter_mut().for_each(shorten_value),
        Value::Distribution(found) => {
            found.density.clear();
            let quantiles = [&mut found.q0, &mut found.q2_5, &mut found.q25, &mut found.q50];
            quantiles.into_iter().for_each(short);
            let others = [&mut found.q75, &mut found.q97_5, &mut found.q100, &mut found.mean];
            others.into_iter().for_each(short);
        }
        Value::Text(_) | Value::Nothing => {}
    }
}
