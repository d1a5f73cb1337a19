//! Benchmarks, and the rows that they give.

use anyhow::{Result, ensure};
use std::time::Instant;

/// A benchmark: one file in [`crate::verify::cases`].
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Short name for `--only`, in lower case with hyphens.
    pub name: &'static str,
    /// Problem, in a line.
    pub title: &'static str,
    /// Source of the reference values.
    pub provenance: &'static str,
    /// Solves and compares; rows given before an error count, and the case counts as failed.
    pub run: fn(Effort, &mut Rows) -> Result<()>,
}

/// Amount of time that a run may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// The coarse meshes of each case.
    Quick,
    /// Everything.
    Full,
}

impl Effort {
    /// The first `quick` of some rising levels, or all.
    pub(crate) fn levels<T>(self, quick: usize, all: &[T]) -> &[T] {
        match self {
            Self::Quick => &all[..quick.min(all.len())],
            Self::Full => all,
        }
    }
}

/// Discretisation of a body; each has its own colour and marker in plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Formulation {
    /// Linear simplices.
    P1,
    /// Quadratic simplices.
    P2,
    /// Quadratic displacement and continuous linear pressure (Taylor and Hood).
    Mixed,
    /// Linear simplices with one volume ratio per patch (F-bar).
    FBar,
    /// Trilinear hexahedra.
    Q1,
    /// Trilinear hexahedra with one volume ratio each (F-bar).
    Q1FBar,
}

impl Formulation {
    /// All of them, in the order of legends.
    pub(crate) const ALL: [Self; 6] =
        [Self::P1, Self::P2, Self::Mixed, Self::FBar, Self::Q1, Self::Q1FBar];

    pub(crate) const fn label(self) -> &'static str {
        ["P1", "P2", "P2–P1", "F-bar", "Q1", "Q1 F-bar"][self as usize]
    }
}

/// Subject of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The element.
    pub formulation: Formulation,
    /// Mesh and parameters.
    pub setup: String,
    /// The quantity, with its unit in brackets. Rows of one quantity on several meshes make a plot.
    pub quantity: String,
}

impl Label {
    /// A label.
    pub fn new(
        formulation: Formulation,
        setup: impl Into<String>,
        quantity: impl Into<String>,
    ) -> Self {
        Self { formulation, setup: setup.into(), quantity: quantity.into() }
    }
}

/// Band of an error. A lower end larger than zero states a known weakness, such as locking: a
/// smaller error would mean that the benchmark no longer measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Smallest error.
    pub least: f64,
    /// Largest error.
    pub most: f64,
}

impl Band {
    /// Errors up to `most`.
    pub const fn below(most: f64) -> Self {
        Self { least: 0.0, most }
    }

    /// Errors of a known weakness.
    pub const fn between(least: f64, most: f64) -> Self {
        Self { least, most }
    }

    /// Whether an error lies in the band; a NaN does not.
    pub(crate) fn contains(self, error: f64) -> bool {
        self.least <= error && error <= self.most
    }
}

/// Measure of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// |value − reference| / |reference|.
    Relative,
    /// |value − reference|, in the unit of the quantity.
    Absolute,
}

/// Cost of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Unknowns of the linear systems, pressures included.
    pub unknowns: usize,
    /// Wall-clock time of preparing and solving \[s\].
    pub seconds: f64,
}

impl Cost {
    pub(crate) fn since(start: Instant, unknowns: usize) -> Self {
        Self { unknowns, seconds: start.elapsed().as_secs_f64() }
    }
}

/// A value beside its reference. Cannot be made without error, band and cost, all finite.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Row {
    /// Subject.
    pub label: Label,
    /// Value of the solver.
    pub value: f64,
    /// Reference value.
    pub reference: f64,
    /// Measure of `error`.
    pub measure: Measure,
    /// Distance of both.
    pub error: f64,
    /// Band of the error.
    pub band: Band,
    /// Cost of the value.
    pub cost: Cost,
}

impl Row {
    /// Error of a value and its reference.
    ///
    /// # Errors
    /// Numbers that are not finite, and a relative error beside a reference of zero.
    pub fn new(
        label: Label,
        measure: Measure,
        [value, reference]: [f64; 2],
        band: Band,
        cost: Cost,
    ) -> Result<Self> {
        let error = match measure {
            Measure::Relative => ((value - reference) / reference).abs(),
            Measure::Absolute => (value - reference).abs(),
        };
        for (what, number) in [
            ("value", value),
            ("reference", reference),
            ("error", error),
            ("time", cost.seconds),
            ("band's upper end", band.most),
        ] {
            ensure!(
                number.is_finite(),
                "{} ({}): the {what} is {number}; rows need finite numbers, and references other than 0 for relative errors",
                label.quantity,
                label.setup
            );
        }
        Ok(Self { label, value, reference, measure, error, band, cost })
    }

    /// Whether the error lies in the band.
    pub fn passes(&self) -> bool {
        self.band.contains(self.error)
    }
}

/// The rows of a running case.
#[derive(Default)]
pub struct Rows(pub(crate) Vec<Row>);

impl Rows {
    /// Adds a row whose error is relative to the reference.
    pub fn relative(&mut self, label: Label, pair: [f64; 2], band: Band, cost: Cost) -> Result<()> {
        self.0.push(Row::new(label, Measure::Relative, pair, band, cost)?);
        Ok(())
    }

    /// Adds a row whose error has the unit of the quantity.
    pub(crate) fn absolute(
        &mut self,
        label: Label,
        pair: [f64; 2],
        band: Band,
        cost: Cost,
    ) -> Result<()> {
        self.0.push(Row::new(label, Measure::Absolute, pair, band, cost)?);
        Ok(())
    }
}
