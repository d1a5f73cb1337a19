//! What the report draws, as data: curves over one variable and maps over two.

use serde::{Deserialize, Serialize};

/// Drawings that belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Title, with the thesis' number of the figure.
    pub title: String,
    /// What is to be seen.
    pub caption: String,
    /// Its drawings.
    pub panels: Vec<Panel>,
}

/// One drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Panel {
    /// Lines over one variable.
    Curves(Curves),
    /// Colours over two.
    Map(Map),
}

/// Lines, bands and markers over one variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// Title.
    pub title: String,
    /// Names of the axes, with units.
    pub axes: [String; 2],
    /// Whether the vertical axis is logarithmic.
    pub logarithmic: bool,
    /// The lines.
    pub lines: Vec<Line>,
    /// Observations as (x, y).
    pub marks: Vec<[f64; 2]>,
    /// A level to compare with, such as the true value, with its name.
    pub level: Option<(String, f64)>,
}

/// A line, with or without a band about it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Style class: a method's key, `exact`, or `sample`.
    pub class: String,
    /// (x, y).
    pub points: Vec<[f64; 2]>,
    /// Lower and upper end at each point; may be empty.
    pub band: Vec<[f64; 2]>,
}

/// Values on a grid over a rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Title.
    pub title: String,
    /// Names of the axes.
    pub axes: [String; 2],
    /// Ends of the axes.
    pub ranges: [[f64; 2]; 2],
    /// Number of values along the first axis.
    pub columns: usize,
    /// Values at points of the second axis from low to high, each over the first axis; none
    /// outside of the domain.
    pub rows: Vec<Vec<Option<f64>>>,
    /// Values of the lowest and highest colour.
    pub scale: [f64; 2],
    /// Where u was observed.
    pub observations: Vec<[f64; 2]>,
    /// Where the equation was imposed.
    pub collocation: Vec<[f64; 2]>,
}

/// `value` with as many digits as a drawing shows.
pub fn rounded(value: f64) -> f64 {
    // Through text, so that JSON shows the short number.
    format!("{value:.4e}").parse().unwrap_or(value)
}

impl Map {
    /// Smallest and largest value.
    pub fn range(rows: &[Vec<Option<f64>>]) -> [f64; 2] {
        let values = rows.iter().flatten().flatten();
        let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(*value), high.max(*value)]
        });
        if ends[0] <= ends[1] { ends } else { [0.0, 1.0] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_leave_out_what_is_outside() {
        assert_eq!(Map::range(&[vec![None, Some(2.0)], vec![Some(-1.0), None]]), [-1.0, 2.0]);
        assert_eq!(Map::range(&[vec![None]]), [0.0, 1.0]);
        assert_eq!(rounded(1.0 / 3.0), 0.33333);
    }
}
