//! Figures that a source prints for a scene, held against ours.

use sinew::Comparison;
use sinew_emulate::METRICS;
use sinew_report::{Block, Level, Section};

/// Median errors that a source prints for a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Published {
    /// Who prints them, such as `"thesis"`.
    pub source: &'static str,
    /// Published errors by the name of the method (empty for all), in the order of [`METRICS`], then err_V;
    /// `None` where nothing is printed.
    pub errors: &'static [(&'static str, [Option<f64>; 5])],
    /// Mean and largest nodal displacement \[length\], as a check that the scene is the same.
    pub displacement: Option<[f64; 2]>,
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
                            *cell = std::mem::take(cell).against(self.source, printed);
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
        if let (Some((_, own)), Some([mean, largest])) = (own, self.displacement) {
            *own += &format!(" ({} {mean} and {largest} {unit})", self.source);
        }
    }

    /// Published errors that a method is compared with.
    fn of(&self, method: &str) -> [Option<f64>; 5] {
        let found = self.errors.iter().find(|(name, _)| name.is_empty() || *name == method);
        found.map_or([None; 5], |(_, errors)| *errors)
    }

    /// An error as lines, for the methods that are there.
    fn levels(&self, error: usize, upright: bool, methods: &[&str]) -> Vec<Level> {
        let there = |name: &str| name.is_empty() || methods.contains(&name);
        let level = |(method, errors): &(&str, [Option<f64>; 5])| {
            let name = if method.is_empty() { self.source } else { method };
            Some(Level { name: name.into(), value: errors[error]?, upright, published: true })
        };
        self.errors.iter().filter(|(name, _)| there(name)).filter_map(level).collect()
    }
}
