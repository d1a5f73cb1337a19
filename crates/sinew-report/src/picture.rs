//! Drawings as data: charts of curves and points, surfaces of a body.

use crate::format::{digits, rounded, seconds};
use crate::{Cell, Column, ReportError, Table};
use serde::{Deserialize, Deserializer, Serialize};

/// Drawings that belong together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// Caption; may be empty.
    pub caption: String,
    /// Charts, side by side.
    pub panels: Vec<Chart>,
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

/// Pairs of numbers, of which those that are not finite are `null` in the file and NaN when read back.
fn nullable<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Vec<[f64; 2]>, D::Error> {
    let pairs = Vec::<[Option<f64>; 2]>::deserialize(deserializer)?;
    Ok(pairs.into_iter().map(|pair| pair.map(|x| x.unwrap_or(f64::NAN))).collect())
}

/// One drawing of the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceCase {
    /// Name of the case.
    pub title: String,
    /// The method it belongs to.
    pub method: String,
    /// Deformed position per node, in the unit of length.
    pub deformed: Vec<[f32; 3]>,
    /// Value per node; `null` in the file and not coloured where it is not finite.
    pub values: Vec<Option<f32>>,
}

/// A surface and the cases drawn on it, with one view and one scale of colours for all.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Surfaces {
    /// Name of the values.
    pub quantity: String,
    /// Unit of the values.
    pub unit: String,
    /// Unit of positions.
    pub length: String,
    /// Whether colours are linear in the value, from 0 on, instead of its logarithm.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub linear: bool,
    /// Triangles over the nodes.
    pub triangles: Vec<[usize; 3]>,
    /// Undeformed position per node.
    pub reference: Vec<[f32; 3]>,
    /// The drawings.
    pub cases: Vec<SurfaceCase>,
    /// Row of each node in the mesh that cases are given on.
    #[serde(skip)]
    nodes: Vec<usize>,
}

impl Surfaces {
    /// The surface of a mesh: `triangles` name rows of `points`, the undeformed positions of all its nodes.
    ///
    /// # Errors
    /// [`ReportError::Triangle`] if a triangle names a node that does not exist.
    pub fn new(triangles: &[[usize; 3]], points: &[[f64; 3]]) -> Result<Self, ReportError> {
        check_triangles(triangles, points.len())?;
        let mut nodes: Vec<usize> = triangles.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let rank = |node| nodes.partition_point(|&other| other < node);
        Ok(Self {
            triangles: triangles.iter().map(|t| t.map(rank)).collect(),
            reference: nodes.iter().map(|&node| points[node].map(|x| x as f32)).collect(),
            nodes,
            ..Self::default()
        })
    }

    /// Adds a case: deformed positions and values of all mesh nodes, of which those of the surface are kept.
    ///
    /// # Errors
    /// [`ReportError::Length`] if a list does not cover the surface, [`ReportError::Number`] for a position that is not
    /// finite.
    pub fn push(
        &mut self,
        method: impl Into<String>,
        title: impl Into<String>,
        deformed: &[[f64; 3]],
        values: &[f64],
    ) -> Result<(), ReportError> {
        let expected = self.nodes.last().map_or(0, |last| last + 1);
        for (what, found) in [("deformed", deformed.len()), ("values", values.len())] {
            if found < expected {
                return Err(ReportError::Length(what.into(), found, expected));
            }
        }
        let coordinates = self.nodes.iter().flat_map(|&node| deformed[node]);
        if let Some(value) = coordinates.into_iter().find(|x| !x.is_finite()) {
            return Err(ReportError::Number("a deformed position".into(), value));
        }
        let value = |&node: &usize| Some(values[node] as f32).filter(|value| value.is_finite());
        self.cases.push(SurfaceCase {
            title: title.into(),
            method: method.into(),
            deformed: self.nodes.iter().map(|&node| deformed[node].map(|x| x as f32)).collect(),
            values: self.nodes.iter().map(value).collect(),
        });
        Ok(())
    }

    /// Value of the last colour: 98 % of all values are below it, and it is at most ten times the 98 % quantile of the
    /// case in the middle, so that a bad case does not set the scale of the others. None without values from 0 on.
    pub fn scale(&self) -> Option<f64> {
        /// Share of the values that have colours of their own.
        const COLOURED: f64 = 0.98;
        /// Cases whose errors are so much smaller than the largest colour are still told apart on a scale of decades.
        const ABOVE_THE_MIDDLE: f64 = 10.0;
        let own =
            |case: &SurfaceCase| case.values.iter().flatten().map(|x| f64::from(*x)).collect();
        let cases: Vec<Vec<f64>> = self.cases.iter().map(own).collect();
        let middle = cases.iter().filter_map(|own| quantile(own.clone(), COLOURED)).collect();
        let all = quantile(cases.concat(), COLOURED)?;
        let scale = all.min(ABOVE_THE_MIDDLE * quantile(middle, 0.5)?);
        // The quantile is 0 if few nodes differ from 0.
        let largest = || cases.iter().flatten().copied().fold(0.0, f64::max);
        Some(if scale > 0.0 { scale } else { largest() })
    }

    /// Refuses what a damaged file may hold.
    pub(crate) fn check(&self) -> Result<(), ReportError> {
        check_triangles(&self.triangles, self.reference.len())?;
        let expected = self.reference.len();
        let lists = self.cases.iter().flat_map(|case| [case.deformed.len(), case.values.len()]);
        match lists.into_iter().find(|&found| found != expected) {
            Some(found) => Err(ReportError::Length("a surface case".into(), found, expected)),
            None => Ok(()),
        }
    }
}

/// The value that so large a share of others is not above; none without values.
fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get((share * values.len().saturating_sub(1) as f64).round() as usize).copied()
}

fn check_triangles(triangles: &[[usize; 3]], nodes: usize) -> Result<(), ReportError> {
    let corners = triangles.as_flattened();
    let beyond = corners.iter().position(|&node| node >= nodes);
    beyond.map_or(Ok(()), |at| Err(ReportError::Triangle(at / 3, corners[at], nodes)))
}
