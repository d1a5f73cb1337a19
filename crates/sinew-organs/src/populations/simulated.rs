//! What chapter 2 of the thesis does on each of its populations: one network on simulations of shapes, all on one graph.

use super::options::Options;
use anyhow::{Context, Result};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use sinew_gnn::{
    Activation, Backend, Budget, DataFit, DataSet, EmulatorConfig, Geometry, OutputScale,
    ParameterRange, ParameterScaling, Scales, Surrogate, Trainer, TrainingConfig,
};
use sinew_report::{Cell, Chart, Column, Distribution, Row, Series, Style, Table};

/// Sizes of one network of a study.
#[derive(Clone, Copy, Debug)]
pub(super) struct Variant {
    /// K.
    pub steps: usize,
    /// Width of the embeddings, M.
    pub latent: usize,
    /// Virtual nodes, η.
    pub virtual_nodes: &'static [usize],
}

/// A method, its errors and its costs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Measured {
    /// What it is.
    pub method: String,
    /// What it is made from.
    pub about: String,
    /// Bodies that it was tested on, where not on those of the population.
    pub group: String,
    /// Of every node of every body tested \[mm\].
    pub errors: Vec<f64>,
    /// `|V − V̂| / V` of each cavity, where there is one.
    pub volumes: Vec<f64>,
    /// Everything before the first answer, simulations not counted \[s\].
    pub cpu_s: f64,
    /// CPU time of the simulations that it learned from \[s\].
    #[serde(default)]
    pub simulated_s: f64,
    /// Wall time of one answer \[s\].
    pub answer_s: f64,
    /// Medians that the thesis prints \[mm, %\].
    pub printed: [Option<f64>; 2],
}

/// How long networks are trained, and how fast.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Steps, of one body each.
    pub steps: usize,
    /// Largest learning rate.
    pub rate: f64,
    /// Parameter sets in a step, where a body has several.
    pub batch: usize,
    /// Whether message passing stays as it is.
    pub decoders_only: bool,
}

/// A network that has learned nothing yet, for displacements in standardised units.
///
/// # Errors
/// Data that do not fit each other.
pub(super) fn untrained(
    variant: Variant,
    data: &DataSet,
    ranges: Vec<ParameterRange>,
    options: &Options,
) -> Result<Surrogate> {
    let geometry = data.geometries.first().context("a data set without a body")?;
    let dimensions = geometry.dirichlet.prescribed.len() / geometry.topology.real_nodes;
    let features = &geometry.features;
    let [nodes, edges] = [features.nodes.columns, features.edges.columns];
    let sizes = EmulatorConfig {
        latent: variant.latent,
        steps: variant.steps,
        activation: Activation::Tanh,
        global_features: geometry.global.len(),
        ..EmulatorConfig::new(dimensions, nodes, edges, ranges.len())
    };
    let fields = data.training.iter().map(|sample| &sample.displacement[..]);
    let output = OutputScale::standardising(dimensions, fields)?;
    let scales = Scales::over(&data.geometries, ParameterScaling::new(ranges)?, output)?;
    Ok(Surrogate::new(&sizes, data, scales, options.seed, &Backend::default().device()?)?)
}

/// Trains a network on simulations, by the mean nodal distance to them; the best weights on those to validate with are kept.
///
/// # Errors
/// Data that do not fit each other, a training that diverges.
pub(super) fn train(
    surrogate: Surrogate,
    data: DataSet,
    pace: Pace,
    options: &Options,
) -> Result<Surrogate> {
    let objective = DataFit::new(surrogate.scales().output.length())?;
    let config = TrainingConfig {
        learning_rate: pace.rate,
        batch: pace.batch,
        budget: Budget::Steps(if options.quick { 12 } else { pace.steps }),
        evaluations: if options.quick { 2 } else { 20 },
        embedding_share: if pace.decoders_only { 0.0 } else { 1.0 },
        seed: options.seed,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate, data, Box::new(objective), config)?;
    trainer.run(&mut ())?;
    Ok(trainer.into_surrogate())
}

/// The first two principal components of the embeddings of a body's nodes, in as many colours as it has thirds of its length along
/// an axis, and the share of their variance that these hold.
///
/// # Errors
/// A geometry of another mesh.
pub(super) fn embedding(
    surrogate: &Surrogate,
    geometry: &Geometry,
    along: &[f64],
) -> Result<(Chart, f64)> {
    const THIRDS: [&str; 3] = ["first third", "second third", "last third"];
    let rows = surrogate.local_embedding(geometry)?;
    let columns = rows.first().map_or(0, Vec::len);
    let mut table = DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]);
    let mean = table.row_mean();
    table.row_iter_mut().for_each(|mut row| row -= &mean);
    let svd = table.svd(true, false);
    let left = svd.u.context("no principal components")?;
    let values = &svd.singular_values;
    let share = values.iter().take(2).map(|s| s * s).sum::<f64>() / values.norm_squared();
    let (low, high) = along
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    let third = |node: usize| ((3.0 * (along[node] - low) / (high - low)) as usize).min(2);
    let axes = ["first component", "second component"];
    let chart = Chart::new("Embeddings of nodes", axes, [false; 2]);
    let chart = THIRDS.iter().enumerate().fold(chart, |chart, (part, name)| {
        let nodes = (0..rows.len()).filter(|&node| third(node) == part);
        let points: Vec<[f64; 2]> =
            nodes.map(|node| [0, 1].map(|k| left[(node, k)] * values[k])).collect();
        chart.with(Series::new(*name, Style::Points, points))
    });
    Ok((chart, share))
}

impl Variant {
    /// What it is, for a table.
    pub(super) fn name(&self) -> String {
        let Self { steps, latent, virtual_nodes, .. } = self;
        match virtual_nodes {
            [] => format!("K = {steps}, M = {latent}, no virtual nodes"),
            some => format!("K = {steps}, M = {latent}, η = {some:?}"),
        }
    }
}

impl Measured {
    /// Median error of the nodes \[mm\].
    ///
    /// # Errors
    /// No node was tested.
    pub(super) fn median(&self) -> Result<f64> {
        Ok(Distribution::of(self.errors.clone()).context("no node was tested")?.q50)
    }

    /// Tells the terminal.
    ///
    /// # Errors
    /// As [`Measured::median`].
    pub(super) fn tell(&self) -> Result<()> {
        let volume = Distribution::of(self.volumes.clone());
        let volume = volume.map_or(String::new(), |v| format!(", volume {:.2} %", 100.0 * v.q50));
        let (name, median) = (format!("{} {}", self.method, self.group), self.median()?);
        eprintln!("{name:44} median {median:.4} mm{volume} after {:.0} CPU-seconds", self.cpu_s);
        Ok(())
    }
}

/// The table of what was measured: errors of nodes, of volumes, or both.
///
/// # Errors
/// A method without errors.
pub(super) fn table(measured: &[Measured]) -> Result<Table> {
    let columns = [
        Column::new("err_u", "mm").about("‖u − û‖ at every node of every body tested"),
        Column::new("volume", "%").about("|V − V̂| / V of the cavity"),
    ];
    let errors =
        |row: &Measured| [row.errors.clone(), row.volumes.iter().map(|v| 100.0 * v).collect()];
    let there = |k: usize| measured.iter().any(|row| !errors(row)[k].is_empty());
    let there: Vec<usize> = (0..2).filter(|k| there(*k)).collect();
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
            Ok(Cell::from(found).against("thesis", method.printed[*k]))
        };
        let mut cells = there.iter().map(cell);
        let first = cells.next().context("nothing was tested")??;
        let row = Row::new(method.method.clone(), first, method.answer_s)?
            .on(method.group.clone(), "")
            .described(&method.about, "our finite-element solution on the same mesh");
        let row = cells.try_fold(row, |row, cell| anyhow::Ok(row.error(cell?)))?;
        table.push(row.time(method.cpu_s).time(method.simulated_s))?;
    }
    Ok(table)
}
