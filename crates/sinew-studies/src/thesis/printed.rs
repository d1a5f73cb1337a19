//! Figures that the thesis prints, and where ours are found: `thesis.toml`.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::sync::LazyLock;

/// The data file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thesis {
    /// Runs whose reports hold figures of ours, the cheapest first.
    pub run: Vec<Run>,
    /// Printed figures.
    pub table: Vec<Table>,
    /// Contradictions and misprints.
    pub misprint: Vec<Remark>,
    /// Mistakes of these documents that were mended.
    pub slip: Vec<Remark>,
}

/// A study with its options.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Name of its folder and of what is kept of it.
    pub name: String,
    /// Task of `cargo xtask`.
    pub task: String,
    /// Options.
    pub arguments: String,
    /// Approximate computing time \[CPU min\].
    pub minutes: f64,
    /// Run that this one repeats with another seed; mostly empty.
    #[serde(default)]
    pub repeats: String,
}

/// A sentence about a place in the thesis.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remark {
    /// Place.
    pub place: String,
    /// Finding.
    pub what: String,
}

/// Meaning of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// An error: the less, the better.
    #[default]
    Error,
    /// A time or what it takes: the less, the better.
    Time,
    /// The error of `over` relative to that of a method: the more, the better.
    Gain,
    /// The time of `over` relative to that of a method: the more, the better.
    Speedup,
    /// The figure of a method relative to that of `over`: the less, the better.
    Growth,
}

impl Kind {
    /// Whether it counts among times.
    pub fn is_time(self) -> bool {
        !matches!(self, Self::Error | Self::Gain)
    }

    /// Whether more is better.
    pub fn grows(self) -> bool {
        matches!(self, Self::Gain | Self::Speedup)
    }
}

/// One value for every column of a table, or one for each.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum Each {
    One(String),
    Many(Vec<String>),
}

impl Default for Each {
    fn default() -> Self {
        Self::One(String::new())
    }
}

impl Each {
    fn at(&self, column: usize) -> Result<&str> {
        match self {
            Self::One(value) => Ok(value),
            Self::Many(values) => {
                Ok(values.get(column).with_context(|| format!("{values:?} is too short"))?)
            }
        }
    }
}

/// Our displacement relative to the printed one, by which limits are in proportion.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Name of the fact that tells our mean displacement.
    pub fact: String,
    /// Printed mean displacement.
    pub printed: f64,
    /// Nodes of the mesh, here and in the thesis.
    pub nodes: [usize; 2],
}

/// A printed table, or figures of one place.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Place in the thesis.
    pub place: String,
    /// Chapter or appendix.
    pub chapter: String,
    /// Subject.
    pub about: String,
    /// Meaning of all figures.
    #[serde(default)]
    pub kind: Kind,
    /// Run that ours are of.
    pub run: String,
    /// Run whose methods are rivals, too; may be empty.
    #[serde(default)]
    pub rivals: String,
    /// Section of its report, if it has several.
    #[serde(default)]
    pub section: String,
    /// Limits in proportion to displacements.
    pub scale: Option<Scale>,
    /// Remark below the table.
    #[serde(default)]
    pub note: String,
    /// Row that gains and growths are relative to.
    #[serde(default)]
    over: String,
    heads: Vec<String>,
    printed: Vec<String>,
    #[serde(default)]
    unit: Each,
    column: Each,
    own: Each,
    #[serde(default)]
    best: Each,
    #[serde(default)]
    mark: Each,
}

/// A printed figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Row and column in the thesis.
    pub what: String,
    /// Unit; empty if it has none.
    pub unit: String,
    /// Figure as printed.
    pub printed: String,
    /// Value that it stands for: its own, or the distance of an estimate from the truth and half a digit.
    pub limit: f64,
    /// Digits that are compared, two at least.
    pub digits: usize,
    /// Statistic of samples, by the names of `report.json`.
    pub statistic: &'static str,
    /// Column of our report.
    pub column: String,
    /// Our row of the thesis' kind; empty without one.
    pub own: String,
    /// Word in the names of rows among which the best is sought; empty for all.
    pub best: String,
    /// Row that it is relative to; may be empty.
    pub over: String,
    /// Kind of the printed figure where ours is of another: `GPU`, `solver`, `one case`; mostly empty.
    pub mark: String,
}

impl Cell {
    /// Whether it is neither met nor missed: a time of other hardware, or of a solver and no emulator.
    pub fn is_beside(&self) -> bool {
        ["GPU", "solver"].contains(&&*self.mark)
    }
}

impl Table {
    /// All figures, row by row.
    ///
    /// # Errors
    /// A row with another number of figures than columns, or a figure that is no number.
    pub fn cells(&self) -> Result<Vec<Cell>> {
        let mut cells = Vec::new();
        for line in &self.printed {
            let (row, figures) = line.split_once(": ").context("a row without a name")?;
            let figures: Vec<_> = figures.split(' ').filter(|figure| !figure.is_empty()).collect();
            ensure!(figures.len() == self.heads.len(), "{}: `{line}`", self.place);
            let printed = figures.into_iter().zip(&self.heads).enumerate();
            for (column, (printed, head)) in printed.filter(|(_, (printed, _))| *printed != "-") {
                let (limit, digits) = limit(printed).with_context(|| self.place.clone())?;
                let named =
                    |each: &Each| Ok::<_, anyhow::Error>(each.at(column)?.replace("{}", head));
                cells.push(Cell {
                    what: format!("{head}, {row}"),
                    unit: named(&self.unit)?,
                    printed: printed.split('@').next().unwrap_or_default().into(),
                    limit,
                    digits,
                    statistic: statistic(row)?,
                    column: named(&self.column)?,
                    own: named(&self.own)?,
                    best: named(&self.best)?,
                    over: self.over.clone(),
                    mark: named(&self.mark)?,
                });
            }
        }
        Ok(cells)
    }
}

/// Value that a printed figure stands for, and the digits that are compared.
fn limit(printed: &str) -> Result<(f64, usize)> {
    let number = |text: &str| text.parse::<f64>().with_context(|| format!("`{printed}`"));
    let Some((estimates, truths)) = printed.split_once('@') else {
        let mantissa = printed.split('e').next().unwrap_or_default();
        let digits = mantissa.replace('.', "");
        return Ok((number(printed)?, digits.trim_start_matches('0').len().max(2)));
    };
    let mut squares = 0.0;
    for (estimate, truth) in estimates.split(',').zip(truths.split(',')) {
        let decimals = estimate.split_once('.').map_or(0, |(_, digits)| digits.len());
        let half = 0.5 * 0.1f64.powi(decimals as i32);
        squares += ((number(estimate)? - number(truth)?).abs() + half).powi(2);
    }
    Ok((squares.sqrt(), 2))
}

/// Statistic of samples that a row of the thesis has; where it is one number, the median of ours over repetitions.
fn statistic(row: &str) -> Result<&'static str> {
    match row {
        "25 %" => Ok("q25"),
        "75 %" => Ok("q75"),
        "largest" => Ok("q100"),
        "mean" => Ok("mean"),
        "50 %" | "median" | "error" | "time" | "factor" | "loss" | "u" | "HCGP" | "UCGP"
        | "mean of the slice" => Ok("q50"),
        other => bail!("`{other}` names no statistic"),
    }
}

static THESIS: LazyLock<Thesis> = LazyLock::new(|| {
    toml::from_str(include_str!("../../thesis.toml")).expect("the data file is part of the program")
});

/// The data file.
pub fn thesis() -> &'static Thesis {
    &THESIS
}

/// Least median that the thesis prints of a method of ours, in a column of a section of its report; of any section for none.
pub fn printed_median([section, method, column]: [&str; 3]) -> Option<Cell> {
    let wanted = |table: &&Table| section.is_empty() || table.section == section;
    let tables = THESIS.table.iter().filter(|table| table.kind == Kind::Error).filter(wanted);
    let cells = tables.filter_map(|table| table.cells().ok()).flatten();
    let of =
        |own: &str| own.strip_suffix(method).is_some_and(|s| s.is_empty() || s.ends_with(", "));
    let medians =
        cells.filter(|cell| cell.statistic == "q50" && cell.column == column && of(&cell.own));
    medians.min_by(|a, b| a.limit.total_cmp(&b.limit))
}
