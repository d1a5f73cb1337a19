//! Methods of the thesis' chapter 2 on a population: networks on simulations of shapes, all on one graph, and regression; their targets.

use super::options::Options;
use super::rivals::in_short;
use super::rows::{Measured, mean};
use super::variant::{Inputs, Pace, Variant, train};
use crate::program::cpu_seconds;
use anyhow::{Context, Result};
use nalgebra::DMatrix;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sinew::{Body, Parameter, Sampling};
use sinew_emulate::PodRegression;
use sinew_emulate::coordinates::{OutputScale, ParameterScaling};
use sinew_gnn::{Backend, DataSet, Geometry, GraphNetworkConfig, Sample, Scales, Surrogate};
use sinew_graph::Topology;
use sinew_report::{Chart, Series, Style};
use std::time::Instant;

/// A body of a population with its parameters and what the solver found.
pub(super) trait Simulated {
    fn body(&self) -> &Body;

    fn theta(&self) -> &[f64];

    /// Node by node, in components that networks predict.
    fn displacement(&self) -> &[f64];

    /// Features for networks, on the graph that all share.
    fn geometry(&self, topology: &Topology, told: Inputs) -> Result<Geometry>;

    /// Inputs of a regression.
    fn inputs(&self, told: Inputs) -> Vec<f64>;

    /// Their ranges.
    fn parameters(&self, told: Inputs) -> Vec<Parameter>;

    /// Lengths of the displacements of nodes \[mm\].
    fn lengths(displacement: &[f64]) -> Vec<f64>;

    /// Approximation of the displacement that a method corrects, and its size; none where a method starts from rest.
    fn known(&self, _told: Inputs) -> Option<(&[f64], f64)> {
        None
    }

    /// `|V − V̂| / V` of its cavity, if it has one.
    fn volume_error(&self, _found: &[f64]) -> Option<f64> {
        None
    }

    /// Distance of a displacement to its own, node by node \[mm\].
    fn distances(&self, found: &[f64]) -> Vec<f64> {
        let pairs = found.iter().zip(self.displacement());
        Self::lengths(&pairs.map(|(a, b)| a - b).collect::<Vec<_>>())
    }
}

/// Bodies that methods learn from and are tested on.
pub(super) struct Compared<'a, B> {
    pub options: &'a Options,
    pub training: &'a [B],
    /// Validation set, by which the best weights of a training are chosen.
    pub validation: &'a [B],
    pub unseen: &'a [B],
    pub targets: &'a Targets,
    pub pace: Pace,
    /// CPU time of a simulation \[s\].
    pub simulation_s: f64,
    /// CPU time of a body on its coarse mesh \[s\].
    pub coarse_s: f64,
}

impl<B: Simulated> Compared<'_, B> {
    /// Regression on the first `count` simulations, over numbers of the shape and parameters.
    pub(super) fn regression(&self, count: usize, told: Inputs) -> Result<Measured> {
        let start = cpu_seconds();
        let fit = regression(&self.training[..count], told, |body| self.targets.of(body, told))?;
        let cost = (cpu_seconds() - start, count);
        let method = format!("POD + GP, {count} simulations{}", told.name());
        self.measured([&method, &in_short(&fit)], cost, told, |body| {
            self.targets.displaced(body, &fit.predict(&body.inputs(told))?, told)
        })
    }

    /// A network that is trained on all simulations.
    pub(super) fn network(
        &self,
        names: [&str; 2],
        variant: Variant,
        topology: &Topology,
    ) -> Result<(Measured, Surrogate)> {
        let start = |data: &DataSet| self.untrained(variant, data);
        let compared = Self { pace: variant.pace.unwrap_or(self.pace), ..*self };
        compared.trained(names, start, variant.told, topology)
    }

    /// Stores it for a resumed run, with `more` results of the network.
    pub(super) fn kept_network<T: Serialize + DeserializeOwned>(
        &self,
        key: &str,
        names: [&str; 2],
        variant: Variant,
        topology: &Topology,
        more: impl FnOnce(&Surrogate) -> Result<T>,
    ) -> Result<(Measured, T)> {
        let name = names[0].replace(|letter: char| !letter.is_alphanumeric(), "-");
        let file = format!("network-seed-{}-{name}.json", self.options.seed);
        let kept = self.options.kept(&self.options.out.join(key).join(file), || {
            let (measured, surrogate) = self.network(names, variant, topology)?;
            Ok(Trained { measured, more: more(&surrogate)? })
        })?;
        Ok((kept.measured, kept.more))
    }

    /// A network that is trained on all simulations from the weights of another, be they drawn or those of another training.
    pub(super) fn trained(
        &self,
        names: [&str; 2],
        from: impl FnOnce(&DataSet) -> Result<Surrogate>,
        told: Inputs,
        topology: &Topology,
    ) -> Result<(Measured, Surrogate)> {
        let start = cpu_seconds();
        let data = self.data_set(topology, told)?;
        let surrogate = train(from(&data)?, data, self.pace, self.options)?;
        let cost = (cpu_seconds() - start, self.training.len() + self.validation.len());
        let found = self.predicting(&surrogate, topology, told);
        Ok((self.measured(names, cost, told, found)?, surrogate))
    }

    /// Predictions of a network for bodies on a graph.
    pub(super) fn predicting(
        &self,
        surrogate: &Surrogate,
        topology: &Topology,
        told: Inputs,
    ) -> impl Fn(&B) -> Result<Vec<f64>> {
        move |body| {
            let geometry = body.geometry(topology, told)?;
            let found = surrogate.predict(&geometry, &[body.theta().to_vec()])?;
            self.targets.displaced(body, &found[0], told)
        }
    }

    /// A method on what it has not seen, after so many CPU-seconds and simulations.
    pub(super) fn measured(
        &self,
        [method, about]: [&str; 2],
        (cpu_s, learned): (f64, usize),
        told: Inputs,
        found: impl Fn(&B) -> Result<Vec<f64>>,
    ) -> Result<Measured> {
        let clock = Instant::now();
        let answers = self.unseen.iter().map(found).collect::<Result<Vec<_>>>()?;
        let answer_s = clock.elapsed().as_secs_f64() / self.unseen.len() as f64;
        let pairs = || self.unseen.iter().zip(&answers);
        let measured = Measured {
            method: method.into(),
            about: about.into(),
            errors: pairs().flat_map(|(body, answer)| body.distances(answer)).collect(),
            volumes: pairs().filter_map(|(body, answer)| body.volume_error(answer)).collect(),
            bodies: pairs().map(|(body, answer)| mean(&body.distances(answer))).collect(),
            cpu_s,
            simulated_s: self.simulation_s * learned as f64,
            answer_s: answer_s + if told.coarse { self.coarse_s } else { 0.0 },
            ..Measured::default()
        };
        measured.tell()?;
        Ok(measured)
    }

    /// Bodies of the same features share a geometry.
    pub(super) fn data_set(&self, topology: &Topology, told: Inputs) -> Result<DataSet> {
        let mut geometries = Vec::new();
        let mut sample = |body: &B| -> Result<Sample> {
            let geometry = body.geometry(topology, told)?;
            if geometries.last() != Some(&geometry) {
                geometries.push(geometry);
            }
            let (geometry, theta) = (geometries.len() - 1, body.theta().to_vec());
            Ok(Sample { geometry, theta, displacement: self.targets.of(body, told)? })
        };
        let training = self.training.iter().map(&mut sample).collect::<Result<_>>()?;
        let validation = self.validation.iter().map(&mut sample).collect::<Result<_>>()?;
        Ok(DataSet { geometries, training, validation })
    }

    /// A network that has learned nothing yet, for displacements in standardised units.
    pub(super) fn untrained(&self, variant: Variant, data: &DataSet) -> Result<Surrogate> {
        let geometry = data.geometries.first().context("a data set without a body")?;
        let dimensions = geometry.dirichlet.prescribed.len() / geometry.topology.real_nodes;
        let features = &geometry.features;
        let [nodes, edges] = [features.nodes.columns, features.edges.columns];
        let scaled = |p: &Parameter| match variant.raw {
            true => Parameter { sampling: Sampling::Linear, ..p.clone() },
            false => p.clone(),
        };
        let ranges: Vec<_> = self.unseen[0].body().parameters.iter().map(scaled).collect();
        let sizes = GraphNetworkConfig {
            latent: variant.latent,
            steps: variant.steps,
            activation: variant.activation,
            global_features: geometry.global.len(),
            ..GraphNetworkConfig::new(dimensions, nodes, edges, ranges.len())
        };
        let fields = data.training.iter().map(|sample| &sample.displacement[..]);
        let output = OutputScale::standardising(dimensions, fields)?;
        let scales = Scales::over(&data.geometries, ParameterScaling::new(&ranges)?, output)?;
        let device = Backend::default().device()?;
        Ok(Surrogate::new(&sizes, data, scales, self.options.seed, &device)?)
    }

    /// Embeddings of the nodes of the first body tested: the first two principal components of their embeddings, in as many
    /// colours as the body has thirds of its length along an axis, and the share of the variance that these hold.
    pub(super) fn embedding(
        &self,
        (variant, surrogate): (&Variant, &Surrogate),
        topology: &Topology,
        axis: usize,
    ) -> Result<(Chart, (String, String))> {
        const THIRDS: [&str; 3] = ["first third", "second third", "last third"];
        let body = &self.unseen[0];
        let rows = surrogate.local_embedding(&body.geometry(topology, variant.told)?)?;
        let columns = rows.first().map_or(0, Vec::len);
        let mut table = DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]);
        let mean = table.row_mean();
        table.row_iter_mut().for_each(|mut row| row -= &mean);
        let svd = table.svd(true, false);
        let left = svd.u.context("no principal components")?;
        let values = &svd.singular_values;
        let share = values.iter().take(2).map(|s| s * s).sum::<f64>() / values.norm_squared();
        let along = || body.body().positions.iter().map(|x| x[axis]);
        let (low, high) =
            (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        let third = |x: f64| ((3.0 * (x - low) / (high - low)) as usize).min(2);
        let axes = ["first component", "second component"];
        let chart = Chart::new("Embeddings of nodes", axes, [false; 2]);
        let chart = THIRDS.iter().enumerate().fold(chart, |chart, (part, name)| {
            let nodes = along().enumerate().filter(|(_, x)| third(*x) == part);
            let points = nodes.map(|(node, _)| [0, 1].map(|k| left[(node, k)] * values[k]));
            chart.with(Series::new(*name, Style::Points, points))
        });
        let what = format!("{:.0} % of the variance, {}", 100.0 * share, variant.name());
        Ok((chart, ("two principal components of the embeddings".into(), what)))
    }
}

/// Regression of what `target` says of bodies, over numbers of the shape and parameters. Modes and hyperparameters come from the first
/// [`FITTED`] of them: a fit takes the cube of their number at every step of its search.
pub(super) fn regression<B: Simulated>(
    seen: &[B],
    told: Inputs,
    target: impl Fn(&B) -> Result<Vec<f64>>,
) -> Result<PodRegression> {
    let inputs: Vec<Vec<f64>> = seen.iter().map(|body| body.inputs(told)).collect();
    let fields: Vec<Vec<f64>> = seen.iter().map(target).collect::<Result<_>>()?;
    let few = seen.len().min(FITTED);
    let fit = PodRegression::fit(&seen[0].parameters(told), &inputs[..few], &fields[..few])?;
    Ok(if seen.len() > few { fit.refitted(&inputs, &fields)? } else { fit })
}

/// Simulations that modes and hyperparameters of a regression are fitted to.
const FITTED: usize = 425;

/// A network of a study as it is kept.
#[derive(Serialize, Deserialize)]
struct Trained<T> {
    measured: Measured,
    more: T,
}

/// Largest total degree of the polynomial of sizes; lower ones are tried too.
const DEGREE: usize = 3;

/// Targets: displacements relative to their size over some inputs, or the error of a known approximation relative to the size of that.
///
/// Between soft and stiff tissue displacements differ by orders of magnitude. Their size is the root mean square; its logarithm is a
/// polynomial in the inputs by least squares.
pub(super) struct Targets(Option<(PodRegression, Inputs)>);

impl Targets {
    /// Displacements as they are.
    pub(super) fn absolute() -> Self {
        Self(None)
    }

    /// Displacements relative to the size that bodies with these inputs have.
    pub(super) fn relative<B: Simulated>(training: &[B], over: Inputs) -> Result<Self> {
        let inputs: Vec<_> = training.iter().map(|body| body.inputs(over)).collect();
        let size = |body: &B| {
            let field = body.displacement();
            let square = field.iter().map(|u| u * u).sum::<f64>() / field.len() as f64;
            vec![0.5 * square.ln()]
        };
        let sizes: Vec<_> = training.iter().map(size).collect();
        let parameters = training.first().map_or_else(Vec::new, |body| body.parameters(over));
        let fit = PodRegression::fit_polynomial(&parameters, &inputs, &sizes, DEGREE)?;
        Ok(Self(Some((fit, over))))
    }

    fn size<B: Simulated>(&self, body: &B) -> Result<f64> {
        let Some((sizes, over)) = &self.0 else { return Ok(1.0) };
        Ok(sizes.predict(&body.inputs(*over))?[0].exp())
    }

    /// Target of a method for a body.
    pub(super) fn of<B: Simulated>(&self, body: &B, told: Inputs) -> Result<Vec<f64>> {
        let displacement = body.displacement().iter();
        Ok(match body.known(told) {
            Some((known, size)) => displacement.zip(known).map(|(u, k)| (u - k) / size).collect(),
            None => {
                let size = self.size(body)?;
                displacement.map(|u| u / size).collect()
            }
        })
    }

    /// The displacement of what a method found for a body.
    pub(super) fn displaced<B: Simulated>(
        &self,
        body: &B,
        found: &[f64],
        told: Inputs,
    ) -> Result<Vec<f64>> {
        Ok(match body.known(told) {
            Some((known, size)) => found.iter().zip(known).map(|(f, k)| size * f + k).collect(),
            None => {
                let size = self.size(body)?;
                found.iter().map(|f| size * f).collect()
            }
        })
    }
}
