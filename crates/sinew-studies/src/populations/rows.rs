//! Errors and costs of methods on simulations, and their table.

use crate::thesis;
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use sinew_report::{Cell, Column, Distribution, Row, Table};

/// A method, its errors and its costs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Measured {
    /// Description.
    pub method: String,
    /// Simulations and training behind it.
    pub about: String,
    /// Bodies that it was tested on, where not on those of the population.
    pub group: String,
    /// Errors of every node of every body tested \[mm\].
    pub errors: Vec<f64>,
    /// `|V − V̂| / V` of each cavity, where there is one.
    pub volumes: Vec<f64>,
    /// Mean error over the nodes of each body \[mm\].
    pub bodies: Vec<f64>,
    /// Everything before the first answer, simulations not counted \[s\].
    pub cpu_s: f64,
    /// CPU time of the simulations that it learned from \[s\].
    #[serde(default)]
    pub simulated_s: f64,
    /// Wall time of one answer \[s\].
    pub answer_s: f64,
}

impl Measured {
    /// Median error of the nodes \[mm\].
    fn median(&self) -> Result<f64> {
        Ok(Distribution::of(self.errors.clone()).context("no node was tested")?.q50)
    }

    pub(super) fn tell(&self) -> Result<()> {
        let volume = Distribution::of(self.volumes.clone());
        let volume = volume.map_or(String::new(), |v| format!(", volume {:.2} %", 100.0 * v.q50));
        let (name, median) = (format!("{} {}", self.method, self.group), self.median()?);
        eprintln!("{name:44} median {median:.4} mm{volume} after {:.0} CPU-seconds", self.cpu_s);
        Ok(())
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The table of what was measured: errors of nodes, of volumes, or both; beside medians that the thesis prints.
pub(super) fn table(measured: &[Measured]) -> Result<Table> {
    let columns = [
        Column::new("err_u", "mm").about("‖u − û‖ at every node of every body tested"),
        Column::new("volume", "%").about("|V − V̂| / V of the cavity"),
        Column::new("mean err_u", "mm").about("mean over the nodes of each body tested"),
    ];
    let errors = |row: &Measured| {
        [row.errors.clone(), row.volumes.iter().map(|v| 100.0 * v).collect(), row.bodies.clone()]
    };
    let there = |k: usize| measured.iter().any(|row| !errors(row)[k].is_empty());
    let there: Vec<usize> = (0..columns.len()).filter(|k| there(*k)).collect();
    let mut table = Table::new(
        there.iter().map(|k| columns[*k].clone()),
        [
            Column::new("answer", "s"),
            Column::new("CPU", "s").once().about("training or fit, all threads"),
            Column::new("simulations", "s").once().about("CPU time of those that it learned from"),
        ],
        [],
    );
    for method in measured {
        let cell = |k: &usize| -> Result<Cell> {
            let found =
                Distribution::of(errors(method)[*k].clone()).context("nothing was tested")?;
            let printed = thesis::printed_median(["", &method.method, &columns[*k].name]);
            Ok(Cell::from(found).against("thesis", printed.map(|printed| printed.limit)))
        };
        let mut cells = there.iter().map(cell);
        let first = cells.next().context("nothing was tested")??;
        let row = Row {
            subject: method.group.clone(),
            about: method.about.clone(),
            reference: "our finite-element solution on the same mesh".into(),
            ..Row::new(method.method.clone(), first, method.answer_s)?
        };
        let row = cells.try_fold(row, |row, cell| anyhow::Ok(row.error(cell?)))?;
        table.push(row.time(method.cpu_s).time(method.simulated_s))?;
    }
    Ok(table)
}
