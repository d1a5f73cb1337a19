//! Drawings as data: charts of curves and points, maps of colours.

use crate::format::{digits, rounded, seconds};
use crate::{Cell, Column, Table};
use serde::{Deserialize, Deserializer, Serialize};

/// Drawings that belong together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// Caption; may be empty.
    pub caption: String,
    /// Drawings of the figure.
    pub panels: Vec<Panel>,
}

/// One drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Panel {
    /// Curves and points between two axes.
    Chart(Chart),
    /// Colours over a rectangle.
    Map(Map),
}

/// Curves and points between two axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Names of the axes, with units.
    pub axes: [String; 2],
    /// Whether each axis is logarithmic.
    pub logarithmic: [bool; 2],
    /// The curves.
    pub series: Vec<Series>,
    /// Values to compare with.
    pub levels: Vec<Level>,
}

/// A curve. Points that are not finite, or not positive on a logarithmic axis, are gaps; the page counts them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Series {
    /// Name, which chooses the colour; empty for a thin line without an entry in the legend.
    pub name: String,
    /// Drawing style.
    pub style: Style,
    /// (x, y); `null` in the file where a number is not finite.
    #[serde(deserialize_with = "nullable")]
    pub points: Vec<[f64; 2]>,
    /// Lower and upper end of a band at each point; may be empty.
    #[serde(deserialize_with = "nullable", skip_serializing_if = "Vec::is_empty")]
    pub band: Vec<[f64; 2]>,
    /// Label of each point under the pointer; may be empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hints: Vec<String>,
}

/// Drawing style of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// A line, with a marker at its end.
    #[default]
    Line,
    /// A line with a marker at every point.
    Marked,
    /// Markers only.
    Points,
    /// A line over a filled area.
    Area,
}

/// A value to compare with, such as a published one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// The series whose colour it has; any other name makes it grey.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Whether it lies on the first axis instead of the second.
    pub upright: bool,
    /// Whether it is dotted, as published values are, instead of dashed.
    pub published: bool,
}

impl Series {
    /// A curve of a style.
    pub fn new(
        name: impl Into<String>,
        style: Style,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        let points = points.into_iter().map(|point| point.map(|x| rounded(x, 6))).collect();
        Self { name: name.into(), style, points, ..Self::default() }
    }
}

impl Chart {
    /// An empty chart.
    pub fn new(title: impl Into<String>, axes: [&str; 2], logarithmic: [bool; 2]) -> Self {
        Self { title: title.into(), axes: axes.map(String::from), logarithmic, ..Self::default() }
    }

    /// Adds a curve.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Time against one error of a table, all its rows: every time that is not paid once is a point.
    pub fn speed_against_error(table: &Table, error: usize) -> Self {
        let name = format!("median {}", table.errors[error].head());
        let mut chart = Self::new("Time against error", ["time [s]", &name], [true; 2]);
        for row in &table.rows {
            let Some(height) = row.errors[error].value.median() else { continue };
            let point = |(cell, column): (&Cell, &Column)| {
                let time = cell.value.median().filter(|_| !column.once)?;
                let (told, error) = (seconds(time), digits(height, 2));
                let hint = format!("{}, {}: {told}, error {error}", row.method, column.name);
                Some(([time, height], hint))
            };
            let (points, hints): (Vec<_>, Vec<_>) =
                row.times.iter().zip(&table.times).filter_map(point).unzip();
            let series = Series { hints, ..Series::new(&row.method, Style::Marked, points) };
            chart.series.push(series);
        }
        chart
    }
}

/// Values on a grid over a rectangle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Title.
    pub title: String,
    /// Names of the axes.
    pub axes: [String; 2],
    /// Ends of the axes.
    pub ranges: [[f64; 2]; 2],
    /// Values at points of the second axis from low to high, each over the first axis; none outside of the domain.
    pub rows: Vec<Vec<Option<f64>>>,
    /// Values of the lowest and highest colour.
    pub scale: [f64; 2],
    /// Named points: the first with circles, the others with crosses.
    pub marks: Vec<(String, Vec<[f64; 2]>)>,
}

/// Pairs of numbers, of which those that are not finite are `null` in the file and NaN when read back.
fn nullable<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Vec<[f64; 2]>, D::Error> {
    let pairs = Vec::<[Option<f64>; 2]>::deserialize(deserializer)?;
    Ok(pairs.into_iter().map(|pair| pair.map(|x| x.unwrap_or(f64::NAN))).collect())
}
