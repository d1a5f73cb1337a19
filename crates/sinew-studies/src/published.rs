//! Figures that the thesis prints for a scene, held against ours.

use crate::thesis::printed_median;
use sinew::Comparison;
use sinew_emulate::METRICS;
use sinew_report::{Block, Level, Section};

/// Whose figures they are.
const SOURCE: &str = "the thesis’";

/// Place of a scene's figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Published {
    /// Section of a report, by which the data file of the thesis has its medians.
    pub section: &'static str,
    /// Method whose medians all methods are held against; without one each against its own.
    pub method: Option<&'static str>,
    /// Mean and largest nodal displacement \[length\], as a check that the scene is the same.
    pub displacement: [f64; 2],
}

impl Published {
    /// The section of a comparison, held against these figures: verdicts in its table, lines in its charts, and printed displacements beside
    /// its own.
    pub(crate) fn section(
        &self,
        comparison: &Comparison,
        name: &str,
        title: &str,
    ) -> Result<Section, sinew_report::ReportError> {
        let mut section = comparison.section(name, title)?;
        let methods: Vec<&str> = comparison.methods.iter().map(|m| m.name.as_str()).collect();
        for block in &mut section.blocks {
            match block {
                Block::Facts(facts) => self.beside(facts, &comparison.length_unit),
                Block::Table(table) => {
                    let raw = |row: &&mut sinew_report::Row| methods.contains(&&*row.method);
                    for row in table.rows.iter_mut().filter(raw) {
                        for (cell, printed) in row.errors.iter_mut().zip(self.of(&row.method)) {
                            *cell = std::mem::take(cell).against(SOURCE, printed);
                        }
                    }
                }
                Block::Figure(figure) => {
                    let (upright, most) = match figure.title.as_str() {
                        "Error densities" => (true, METRICS.len() + 1),
                        "Error over training time" => (false, METRICS.len()),
                        _ => continue,
                    };
                    for (error, chart) in figure.panels.iter_mut().take(most).enumerate() {
                        chart.levels.extend(self.levels(error, upright, &methods));
                    }
                }
                _ => {}
            }
        }
        Ok(section)
    }

    /// Adds the printed displacements to the own ones.
    fn beside(&self, facts: &mut [(String, String)], unit: &str) {
        let own = facts.iter_mut().find(|(name, _)| name == "displacement");
        let [mean, largest] = self.displacement;
        if let Some((_, own)) = own {
            *own += &format!(" ({SOURCE} {mean} and {largest} {unit})");
        }
    }

    /// Published errors that a method is compared with, in the order of [`METRICS`], then err_V; none where nothing is printed.
    fn of(&self, method: &str) -> [Option<f64>; 5] {
        let method = self.method.unwrap_or(method);
        ["err_u", "err_F", "err_I₁", "err_Π", "err_V"]
            .map(|column| Some(printed_median([self.section, method, column])?.limit))
    }

    /// An error as lines, for the methods that are there.
    fn levels(&self, error: usize, upright: bool, methods: &[&str]) -> Vec<Level> {
        let count = if self.method.is_some() { 1 } else { methods.len() };
        let level = |method: &&str| {
            let name = if self.method.is_some() { SOURCE } else { method };
            let value = self.of(method)[error]?;
            Some(Level { name: name.into(), value, upright, published: true })
        };
        methods.iter().take(count).filter_map(level).collect()
    }
}
