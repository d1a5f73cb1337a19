//! The methods on ventricles: the coarse mesh, regression, networks, and what they make of one shape.

use super::ventricle::{Seen, Ventricle, Ventricles, lengths};
use super::{ALL, LARGEST};
use crate::populations::measure::cpu_seconds;
use crate::populations::options::Options;
use crate::populations::simulated::{self, Measured, Pace, Variant, train, untrained};
use anyhow::{Context, Result, ensure};
use sinew_emulate::{Design, PodRegression};
use sinew_gnn::{DataSet, ParameterRange, ParameterScale, Sample, Surrogate};
use sinew_graph::Topology;
use sinew_report::{Chart, Distribution};
use std::time::Instant;

/// Steps of a training, one ventricle each, and their largest learning rate; the same when a network goes on to one shape.
const PACE: Pace = Pace { steps: 2000, rate: 4e-3, batch: 1, decoders_only: false };
const TRANSFER: Pace = Pace { steps: 1500, rate: 1e-3, batch: 8, decoders_only: true };
/// Simulations of one shape: to go on with, to choose weights, and to test with.
const ONE_SHAPE: [usize; 3] = [85, 15, 100];
/// Points of the map along each parameter.
const POINTS: usize = 8;

/// What the study works on.
pub(super) struct Data<'a> {
    pub options: &'a Options,
    pub ventricles: &'a Ventricles,
    pub training: &'a [Ventricle],
    pub validation: &'a [Ventricle],
    pub unseen: &'a [Ventricle],
    /// Wall time of one on the coarse mesh, and by way of it on the fine one \[s\].
    pub solve_s: [f64; 2],
    /// CPU time of both \[s\].
    pub simulation_s: f64,
}

impl Data<'_> {
    pub(super) fn facts(&self, drawn: usize, wall_s: f64) -> Result<Vec<(String, String)>> {
        let body = &self.unseen.first().context("no ventricle is left to test")?.body;
        let of = |values: Vec<f64>| Distribution::of(values).context("no ventricle");
        let sizes = self.unseen.iter().flat_map(|ventricle| lengths(&ventricle.displacement));
        let sizes = of(sizes.collect())?;
        let changes = of(self.unseen.iter().map(Ventricle::largest_volume_change).collect())?;
        let volumes = of(self.unseen.iter().map(|v| 1e-3 * v.volume(&v.displacement)).collect())?;
        let fact = |name: &str, what: String| (name.to_string(), what);
        Ok(vec![
            fact(
                "ventricles",
                format!(
                    "{drawn} drawn; {} to train, {} to choose weights, {} to test below {:.0} mL; {} nodes, {} cells",
                    self.training.len(),
                    self.validation.len(),
                    self.unseen.len(),
                    1e-3 * LARGEST,
                    body.nodes,
                    body.cells.len() / body.nodes_per_cell
                ),
            ),
            fact("simulations", format!("{wall_s:.0} s, or as long as it takes to read them")),
            fact(
                "displacements tested",
                format!("mean {:.1} mm, largest {:.0} mm", sizes.mean, sizes.q100),
            ),
            fact(
                "inflated cavities",
                format!("{:.0} to {:.0} mL, median {:.0}", volumes.q0, volumes.q100, volumes.q50),
            ),
            fact("largest |J − 1| of a cell", format!("{:.1e} in the median", changes.q50)),
        ])
    }

    /// What the coarse mesh says, by itself.
    pub(super) fn coarse_alone(&self, unseen: &[Ventricle]) -> Result<Measured> {
        let found = |ventricle: &Ventricle| Ok(ventricle.coarse.displacement.clone());
        let about = "the equilibrium of the ventricle on a coarse mesh, by moving least squares";
        self.measured(
            ["coarse solution", about],
            unseen,
            (0.0, Seen { numbers: ALL, coarse: true }),
            found,
        )
    }

    /// Regression over the numbers of the shape and the logarithms of the parameters.
    pub(super) fn regression(
        &self,
        seen: &[Ventricle],
        unseen: &[Ventricle],
        told: Seen,
    ) -> Result<Measured> {
        let start = cpu_seconds();
        let inputs: Vec<Vec<f64>> = seen.iter().map(|v| v.inputs(told)).collect();
        let fields: Vec<Vec<f64>> = seen.iter().map(|v| v.target(told)).collect();
        let fit = PodRegression::fit(&seen[0].parameters(told), &inputs, &fields)?;
        let cpu_s = cpu_seconds() - start;
        let found = |v: &Ventricle| Ok(v.displaced(&fit.predict(&v.inputs(told))?, told));
        let method = format!("POD + GP, {} simulations{}", seen.len(), told.name());
        let about = fit.interpolation().to_string();
        let about = about.split(", lengths").next().unwrap_or_default();
        let measured = self.measured([&method, about], unseen, (cpu_s, told), found)?;
        Ok(Measured { simulated_s: self.simulation_s * seen.len() as f64, ..measured })
    }

    pub(super) fn network(
        &self,
        variant: Variant,
        told: Seen,
        printed: [Option<f64>; 2],
    ) -> Result<(Measured, Surrogate)> {
        let start = cpu_seconds();
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let data = data_set(&topology, self.training, self.validation, told)?;
        let ranges = self.unseen[0].body.parameters.iter().map(|parameter| {
            let [lower, upper] = parameter.range;
            ParameterRange { lower, upper, scale: ParameterScale::Log }
        });
        let surrogate = untrained(variant, &data, ranges.collect(), self.options)?;
        let surrogate = train(surrogate, data, PACE, self.options)?;
        let cpu_s = cpu_seconds() - start;
        let about = format!("network on simulations, told {} numbers of the shape", told.numbers);
        let method = format!("{}, {} numbers{}", variant.name(), told.numbers, told.name());
        let found = predicting(&surrogate, &topology, told);
        let measured = self.measured([&method, &about], self.unseen, (cpu_s, told), found)?;
        let simulated_s = self.simulation_s * (self.training.len() + self.validation.len()) as f64;
        Ok((Measured { printed, simulated_s, ..measured }, surrogate))
    }

    /// One shape that nothing was trained on: as it is, and with simulations of it; and a map of errors.
    #[allow(clippy::type_complexity, reason = "rows and a map")]
    pub(super) fn one_shape(
        &self,
        general: &[(Variant, Seen, Surrogate)],
    ) -> Result<(Vec<Measured>, Vec<Vec<Option<f64>>>)> {
        let numbers = &self.unseen[0].numbers;
        let counts = if self.options.quick { [4, 2, 2] } else { ONE_SHAPE };
        let [design, apart] = [Design::LatinHypercube, Design::Uniform];
        let parameters = &self.unseen[0].body.parameters;
        let seed = self.options.seed;
        let learned = design.sample(parameters, counts[0] + counts[1], seed)?;
        let learned = self.ventricles.at(numbers, &learned)?;
        let tested = self.ventricles.at(numbers, &apart.sample(parameters, counts[2], seed)?)?;
        ensure!(
            learned.len() > counts[1] + 1,
            "too few parameter sets of one shape have an equilibrium"
        );
        let (training, validation) = learned.split_at(learned.len() - counts[1]);
        let mut rows = vec![self.coarse_alone(&tested)?];
        for coarse in [false, true] {
            rows.push(self.regression(training, &tested, Seen { numbers: 0, coarse })?);
        }
        let mut map = Vec::new();
        for (variant, told, surrogate) in general {
            let topology = self.ventricles.graph(variant.virtual_nodes)?;
            let name = format!("{}{}", variant.name(), told.name());
            let about = "trained on other shapes, which times do not count";
            let of_population = format!("{name}, of the population");
            let found = predicting(surrogate, &topology, *told);
            let row = self.measured([&of_population, about], &tested, (0.0, *told), &found)?;
            rows.push(Measured { printed: [Some(0.295), Some(0.43)], ..row });
            if told.coarse && map.is_empty() {
                map = self.map(numbers, &found)?;
            }
            let start = cpu_seconds();
            let data = data_set(&topology, training, validation, *told)?;
            // Every sample has features of its own about a coarse solution, so that message passing has to learn too.
            let pace = Pace { decoders_only: !told.coarse, ..TRANSFER };
            let further = train(surrogate.carried_to(&data)?, data, pace, self.options)?;
            let cpu_s = cpu_seconds() - start;
            let name = format!("{name}, trained further");
            let about = format!("the same on {} simulations of this shape", training.len());
            let found = predicting(&further, &topology, *told);
            let row = self.measured([&name, &about], &tested, (cpu_s, *told), found)?;
            let simulated_s = self.simulation_s * learned.len() as f64;
            rows.push(Measured { printed: [Some(0.113), Some(0.34)], simulated_s, ..row });
        }
        rows.iter_mut().for_each(|row| row.group = "one shape".into());
        Ok((rows, map))
    }

    /// Errors over the first two parameters, the others in the middle.
    fn map(
        &self,
        numbers: &[f64],
        found: impl Fn(&Ventricle) -> Result<Vec<f64>>,
    ) -> Result<Vec<Vec<Option<f64>>>> {
        let points = if self.options.quick { 2 } else { POINTS };
        let at = |k: usize| 10f64.powf(-1.0 + 2.0 * (k as f64 + 0.5) / points as f64);
        let cell = |a: usize, b: usize| -> Result<Option<f64>> {
            let solved = self.ventricles.at(numbers, &[vec![at(a), at(b), 1.0, 1.0]])?;
            let Some(ventricle) = solved.first() else { return Ok(None) };
            let errors = Distribution::of(ventricle.distances(&found(ventricle)?));
            Ok(errors.map(|errors| errors.q50.log10()))
        };
        let row = |b: usize| (0..points).map(|a| cell(a, b)).collect();
        (0..points).map(row).collect()
    }

    pub(super) fn embedding(
        &self,
        (variant, told, surrogate): &(Variant, Seen, Surrogate),
    ) -> Result<(Chart, (String, String))> {
        let ventricle = &self.unseen[0];
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let geometry = ventricle.geometry(&topology, *told)?;
        let along: Vec<f64> = ventricle.body.positions.iter().map(|x| x[2]).collect();
        let (chart, share) = simulated::embedding(surrogate, &geometry, &along)?;
        let what = format!("{:.0} % of the variance, {}", 100.0 * share, variant.name());
        Ok((chart, ("two principal components of the embeddings".into(), what)))
    }

    /// Table 2.1: answers for a shape that changes and for one that stays, beside the solver.
    pub(super) fn times(
        &self,
        (variant, told, surrogate): &(Variant, Seen, Surrogate),
    ) -> Result<(String, String)> {
        const AGAIN: u32 = 20;
        let Ventricle { theta, .. } = &self.unseen[0];
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let theta = std::slice::from_ref(theta);
        let time = |answer: &mut dyn FnMut() -> Result<()>| -> Result<f64> {
            let start = Instant::now();
            (0..AGAIN).try_for_each(|_| answer())?;
            Ok(1e3 * start.elapsed().as_secs_f64() / f64::from(AGAIN))
        };
        let geometry = self.unseen[0].geometry(&topology, *told)?;
        let varying = time(&mut || {
            surrogate.predict(&self.unseen[0].geometry(&topology, *told)?, theta)?;
            Ok(())
        })?;
        let fixed = surrogate.fixed_geometry(&geometry)?;
        let fixed = time(&mut || fixed.predict(theta).map(|_| ()).map_err(Into::into))?;
        let [coarse, solver] = self.solve_s.map(|s| 1e3 * s);
        let what = format!(
            "{varying:.1} ms where the shape changes, {fixed:.2} ms where it stays; the coarse solution {coarse:.0} ms, the solver by way of it {solver:.0} ms; {}, {} threads",
            variant.name(),
            rayon::current_num_threads()
        );
        Ok(("an answer".into(), what))
    }

    fn measured(
        &self,
        [method, about]: [&str; 2],
        unseen: &[Ventricle],
        (cpu_s, told): (f64, Seen),
        found: impl Fn(&Ventricle) -> Result<Vec<f64>>,
    ) -> Result<Measured> {
        let (mut errors, mut volumes) = (Vec::new(), Vec::new());
        let clock = Instant::now();
        let answers = unseen.iter().map(found).collect::<Result<Vec<_>>>()?;
        let mut answer_s = clock.elapsed().as_secs_f64();
        for (ventricle, answer) in unseen.iter().zip(answers) {
            errors.extend(ventricle.distances(&answer));
            let volume = ventricle.volume(&ventricle.displacement);
            volumes.push((ventricle.volume(&answer) - volume).abs() / volume);
            answer_s += if told.coarse { self.solve_s[0] } else { 0.0 };
        }
        let measured = Measured {
            method: method.into(),
            about: about.into(),
            group: String::new(),
            errors,
            volumes,
            cpu_s,
            simulated_s: 0.0,
            answer_s: answer_s / unseen.len() as f64,
            printed: [None; 2],
        };
        measured.tell()?;
        Ok(measured)
    }
}

fn predicting<'a>(
    surrogate: &'a Surrogate,
    topology: &'a Topology,
    told: Seen,
) -> impl Fn(&Ventricle) -> Result<Vec<f64>> + 'a {
    move |ventricle| {
        let geometry = ventricle.geometry(topology, told)?;
        let found = surrogate.predict(&geometry, std::slice::from_ref(&ventricle.theta))?;
        Ok(ventricle.displaced(found.field(0), told))
    }
}

/// Ventricles of the same features share a geometry.
fn data_set(
    topology: &Topology,
    training: &[Ventricle],
    validation: &[Ventricle],
    told: Seen,
) -> Result<DataSet> {
    let mut geometries = Vec::new();
    let mut sample = |ventricle: &Ventricle| -> Result<Sample> {
        let geometry = ventricle.geometry(topology, told)?;
        if geometries.last() != Some(&geometry) {
            geometries.push(geometry);
        }
        Ok(Sample {
            geometry: geometries.len() - 1,
            theta: ventricle.theta.clone(),
            displacement: ventricle.target(told),
        })
    };
    let training = training.iter().map(&mut sample).collect::<Result<_>>()?;
    let validation = validation.iter().map(&mut sample).collect::<Result<_>>()?;
    Ok(DataSet { geometries, training, validation })
}
