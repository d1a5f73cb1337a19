//! Methods with errors beside times. There is no row without both.

use crate::format::{digits, factor, rounded};
use crate::{Distribution, ReportError};
use serde::{Deserialize, Serialize};

/// Content of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Empty: not measured, or without meaning for this row.
    #[default]
    Nothing,
    /// A single number.
    Number(f64),
    /// Words.
    Text(String),
    /// Many samples, of an error or over several seeds.
    Distribution(Distribution),
    /// One value per component.
    Several(Vec<Value>),
}

impl Value {
    /// The number that stands for it: the median of many. None for words and nothing.
    pub fn median(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Distribution(found) => Some(found.q50),
            Self::Several(values) => values.first()?.median(),
            Self::Nothing | Self::Text(_) => None,
        }
    }

    /// All numbers in it, in the order of the fields.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Number(value) => vec![*value],
            Self::Distribution(found) => found.values().to_vec(),
            Self::Several(values) => values.iter().flat_map(Self::numbers).collect(),
            Self::Nothing | Self::Text(_) => Vec::new(),
        }
    }
}

macro_rules! value_from {
    ($($kind:ty => $value:expr),+) => {
        $(impl From<$kind> for Value {
            fn from(value: $kind) -> Self {
                $value(value)
            }
        })+
    };
}
value_from!(f64 => Self::Number, String => Self::Text, Distribution => Self::Distribution,
    Vec<Value> => Self::Several, &str => |text: &str| Self::Text(text.into()));

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, Into::into)
    }
}

/// Comparison of a value with a published figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Whether it is.
    pub met: bool,
    /// The largest value that meets it.
    pub limit: f64,
    /// Both in words: `0.69× the thesis’ 6.5×10⁻³`.
    pub text: String,
}

impl Verdict {
    /// The one rule for published figures: ours is at or below what is printed, in the two digits that are printed. A
    /// NaN is not.
    pub fn against_printed(source: &str, ours: f64, printed: f64) -> Self {
        let text = format!("{} {source} {}", factor(ours / printed), digits(printed, 2));
        Self { met: rounded(ours, 2) <= printed * (1.0 + 1e-9), limit: printed, text }
    }
}

/// A value, how it is judged, and what is written small below it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Cell {
    /// The value.
    pub value: Value,
    /// Comparison with a published figure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// A remark.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl<T: Into<Value>> From<T> for Cell {
    fn from(value: T) -> Self {
        Self { value: value.into(), ..Self::default() }
    }
}

impl Cell {
    /// Compared with a published figure, where there is one ([`Verdict::against_printed`]).
    pub fn against(mut self, source: &str, printed: Option<f64>) -> Self {
        let pair = self.value.median().zip(printed);
        self.verdict = pair.map(|(ours, printed)| Verdict::against_printed(source, ours, printed));
        self
    }
}

/// A method on a problem, with its errors beside its times.
///
/// ```
/// use sinew_report::{Row, Table, Column};
/// let mut table = Table::new([Column::new("err_u", "mm")], [Column::new("predict", "s")], []);
/// table.push(Row::new("emulator", 4.5e-3, 4.3e-4)?)?;
/// // A time that is NaN is refused, and the message names it.
/// let refused = Row::new("emulator", 4.5e-3, f64::NAN).unwrap_err().to_string();
/// assert!(refused.contains("emulator: the first time is NaN"));
/// # Ok::<(), sinew_report::ReportError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The problem or quantity; empty in tables of one problem.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub subject: String,
    /// The method, by which colours are chosen: one name, one colour on the whole page.
    pub method: String,
    /// Description or settings, in a line.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// Reference of its errors. Rows with another reference than the first are not ranked.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reference: String,
    /// Reasons not to trust it, shown below its name and at the head of the page.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Errors in the order of the table's columns.
    pub errors: Vec<Cell>,
    /// Times \[s\] in the order of the table's columns.
    pub times: Vec<Cell>,
    /// Further values, in the order of the table's columns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<Cell>,
}

impl Row {
    /// A row with the first error and the first time \[s\] of its table.
    ///
    /// # Errors
    /// [`ReportError::Number`] or [`ReportError::Missing`] if one of them is not a finite number from 0 on.
    pub fn new(
        method: impl Into<String>,
        error: impl Into<Cell>,
        time: impl Into<Cell>,
    ) -> Result<Self, ReportError> {
        let row = Self {
            method: method.into(),
            errors: vec![error.into()],
            times: vec![time.into()],
            ..Self::default()
        };
        row.check(&["the first error"], &["the first time"])?;
        Ok(row)
    }

    /// Adds an error.
    pub fn error(mut self, cell: impl Into<Cell>) -> Self {
        self.errors.push(cell.into());
        self
    }

    /// Adds a time \[s\].
    pub fn time(mut self, cell: impl Into<Cell>) -> Self {
        self.times.push(cell.into());
        self
    }

    /// Adds a further value.
    pub fn other(mut self, cell: impl Into<Cell>) -> Self {
        self.others.push(cell.into());
        self
    }

    /// Problem, method and setting in words.
    pub fn name(&self) -> String {
        let parts = [&self.subject, &self.method, &self.about];
        let skip = usize::from(self.subject.is_empty());
        let used = parts[skip..3 - skip].iter().filter(|part| !part.is_empty());
        used.map(|part| part.as_str()).collect::<Vec<_>>().join(", ")
    }

    fn check(&self, errors: &[&str], times: &[&str]) -> Result<(), ReportError> {
        for (cells, names) in [(&self.errors, errors), (&self.times, times)] {
            if cells.len() != names.len() {
                let what = format!("{}: errors or times", self.method);
                return Err(ReportError::Length(what, cells.len(), names.len()));
            }
            for (index, (cell, name)) in cells.iter().zip(names).enumerate() {
                let (field, numbers) = (format!("{}: {name}", self.method), cell.value.numbers());
                if let Some(&value) = numbers.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
                    return Err(ReportError::Number(field, value));
                } else if index == 0 && numbers.is_empty() {
                    return Err(ReportError::Missing(field));
                }
            }
        }
        Ok(())
    }
}

/// Head of a column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit; empty if it has none.
    pub unit: String,
    /// Definition, shown at the end of the page; may be empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// Whether a time is paid once, before the first prediction.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub once: bool,
}

impl Column {
    /// A column.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), ..Self::default() }
    }

    /// Adds a definition.
    pub fn about(self, about: impl Into<String>) -> Self {
        Self { about: about.into(), ..self }
    }

    /// A time that is paid once, before the first prediction.
    pub fn once(self) -> Self {
        Self { once: true, ..self }
    }

    /// `err_u [mm]`
    pub fn head(&self) -> String {
        match self.unit.as_str() {
            "" => self.name.clone(),
            unit => format!("{} [{unit}]", self.name),
        }
    }
}

/// Rows under the heads of their columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Errors, at least one.
    pub errors: Vec<Column>,
    /// Times \[s\], at least one.
    pub times: Vec<Column>,
    /// Further columns.
    #[serde(default)]
    pub others: Vec<Column>,
    /// The method whose times the others are compared with, such as a solver.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Table {
    /// Without rows.
    pub fn new(
        errors: impl IntoIterator<Item = Column>,
        times: impl IntoIterator<Item = Column>,
        others: impl IntoIterator<Item = Column>,
    ) -> Self {
        let [errors, times] = [errors.into_iter().collect(), times.into_iter().collect()];
        Self { errors, times, others: others.into_iter().collect(), ..Self::default() }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If its cells do not fit the columns, or an error or a time is not a finite number from 0 on.
    pub fn push(&mut self, row: Row) -> Result<(), ReportError> {
        self.check(&row)?;
        self.rows.push(row);
        Ok(())
    }

    pub(crate) fn check(&self, row: &Row) -> Result<(), ReportError> {
        let [errors, times] = [&self.errors, &self.times]
            .map(|columns| columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>());
        row.check(&errors, &times)?;
        let (found, expected) = (row.others.len(), self.others.len());
        match found == expected {
            true => Ok(()),
            false => Err(ReportError::Length(format!("{}: others", row.method), found, expected)),
        }
    }

    /// The first row of a method.
    pub fn row(&self, method: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.method == method)
    }

    /// Rows that can be ranked: those measured against the same reference as the first.
    pub fn ranked(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.reference == self.rows[0].reference)
    }

    /// Every judged error with its row and column.
    pub fn verdicts(&self) -> impl Iterator<Item = (&Row, &Column, &Cell, &Verdict)> {
        self.rows.iter().flat_map(|row| {
            let cells = row.errors.iter().zip(&self.errors);
            cells
                .filter_map(move |(cell, column)| Some((row, column, cell, cell.verdict.as_ref()?)))
        })
    }
}
