//! The methods on ventricles: the coarse mesh, regression, networks, and what they make of one shape; volumes of cavities by methods
//! that predict nothing else (Tables A.10, A.12, A.13).

use super::ventricle::{Ventricle, Ventricles};
use super::{ALL, LARGEST};
use crate::populations::inflated::perceptron::{Perceptron, Samples};
use crate::populations::rows::Measured;
use crate::populations::simulated::{Compared, Simulated, regression};
use crate::populations::variant::{Inputs, Pace, Variant};
use crate::program::{cpu_seconds, cpu_seconds_of};
use anyhow::{Context, Result, ensure};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use sinew_emulate::Design;
use sinew_fem::FrozenStiffness;
use sinew_gnn::{DataSet, Surrogate};
use sinew_report::{Chart, Distribution};
use std::time::Instant;

/// Steps of a training, one ventricle each, and their largest learning rate. Message passing of three steps takes four fifths of the time of
/// a step, and is trained in a tenth of the steps.
pub(super) const PACE: Pace =
    Pace { embedding_share: 0.1, frozen_encoder: true, ..Pace::of(40_000, 4e-3) };
/// Pace about the coarse solution.
pub(super) const COARSE: Pace = Pace::of(8000, 4e-3);
/// Pace about the coarse solution on the mesh of 6788 nodes.
pub(super) const COARSE_FULL: Pace = Pace { embedding_share: 0.1, frozen_encoder: true, ..COARSE };
/// Pace of fine-tuning on one shape.
const TRANSFER: Pace = Pace { batch: 8, embedding_share: 0.0, ..Pace::of(1500, 1e-3) };
/// Simulations of one shape: to go on with, to choose weights, and to test with.
const ONE_SHAPE: [usize; 3] = [85, 15, 100];

/// Data of the study.
pub(super) struct Data<'a> {
    pub ventricles: &'a Ventricles,
    pub compared: Compared<'a, Ventricle>,
    /// CPU time of the solver by way of the coarse mesh \[s\].
    pub solver_s: f64,
}

impl Data<'_> {
    pub(super) fn facts(&self, drawn: usize, wall_s: f64) -> Result<Vec<(String, String)>> {
        let Compared { training, validation, unseen, .. } = self.compared;
        let body = &unseen.first().context("no ventricle is left to test")?.body;
        let of = |values: Vec<f64>| Distribution::of(values).context("no ventricle");
        let sizes = unseen.iter().flat_map(|ventricle| Ventricle::lengths(&ventricle.displacement));
        let sizes = of(sizes.collect())?;
        let changes = of(unseen.iter().map(Ventricle::largest_volume_change).collect())?;
        let volumes = of(unseen.iter().map(|v| 1e-3 * v.volume(&v.displacement)).collect())?;
        let fact = |name: &str, what: String| (name.to_string(), what);
        Ok(vec![
            fact(
                "ventricles",
                format!(
                    "{drawn} drawn; {} to train, {} to choose weights, {} to test below {:.0} mL; {} nodes, {} cells",
                    training.len(),
                    validation.len(),
                    unseen.len(),
                    1e-3 * LARGEST,
                    body.nodes,
                    body.cells.len() / body.nodes_per_cell
                ),
            ),
            fact("simulations", format!("{wall_s:.0} s, or as long as it takes to read them")),
            fact(
                "displacements tested",
                format!("mean {:.3} mm, largest {:.0} mm", sizes.mean, sizes.q100),
            ),
            fact(
                "inflated cavities",
                format!("{:.0} to {:.0} mL, median {:.0}", volumes.q0, volumes.q100, volumes.q50),
            ),
            fact("largest |J − 1| of a cell", format!("{:.1e} in the median", changes.q50)),
        ])
    }

    /// Simulations of the first shape tested.
    pub(super) fn one_shape(&self) -> Result<OneShape> {
        let Compared { options, unseen, .. } = self.compared;
        let Ventricle { numbers, body, .. } = &unseen[0];
        let counts = if options.quick { [4, 2, 2] } else { ONE_SHAPE };
        let simulated = |design: Design, count: usize| {
            let thetas = design.sample(&body.parameters, count, options.seed)?;
            self.ventricles.at(numbers, &thetas)
        };
        let mut training = simulated(Design::LatinHypercube, counts[0] + counts[1])?;
        let tested = simulated(Design::Uniform, counts[2])?;
        ensure!(
            training.len() > counts[1] + 1,
            "too few parameter sets of one shape have an equilibrium"
        );
        let validation = training.split_off(training.len() - counts[1]);
        Ok(OneShape { training, validation, tested })
    }

    /// CPU times of answers for a shape that changes and for one that stays \[s\] (Table 2.1).
    pub(super) fn answer_times(
        &self,
        variant: &Variant,
        surrogate: &Surrogate,
    ) -> Result<[f64; 2]> {
        let (first, told) = (&self.compared.unseen[0], variant.told);
        let quick = self.compared.options.quick;
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let theta = std::slice::from_ref(&first.theta);
        let geometry = first.geometry(&topology, told)?;
        let predict = || Ok(surrogate.predict(&first.geometry(&topology, told)?, theta)?);
        let varying = cpu_seconds_of(quick, predict)?;
        let fixed = surrogate.fixed_geometry(&geometry)?;
        let fixed = cpu_seconds_of(quick, || Ok(fixed.predict(theta)?))?;
        Ok([varying, fixed])
    }

    /// Row of the table in words, beside the solver.
    fn times(&self, variant: &Variant, surrogate: &Surrogate) -> Result<(String, String)> {
        let [varying, fixed] = self.answer_times(variant, surrogate)?;
        let all = [varying, fixed, self.compared.coarse_s, self.solver_s];
        let [varying, fixed, coarse, solver] = all.map(|s| 1e3 * s);
        let what = format!(
            "{varying:.1} ms where the shape changes, {fixed:.2} ms where it stays; the coarse solution {coarse:.0} ms, the solver by way of it {solver:.0} ms; {}, CPU times",
            variant.name()
        );
        Ok(("an answer".into(), what))
    }
}

/// Simulations of one unseen shape: to train on, to choose weights by, and to test.
pub(super) struct OneShape {
    training: Vec<Ventricle>,
    validation: Vec<Ventricle>,
    tested: Vec<Ventricle>,
}

/// A network of the population on one shape.
#[derive(Serialize, Deserialize)]
pub(super) struct FineTuned {
    /// Unchanged, and trained further.
    pub rows: Vec<Measured>,
    pub embedding: Chart,
    pub facts: [(String, String); 2],
}

impl OneShape {
    fn compared<'a>(&'a self, data: &Data<'a>, pace: Pace) -> Compared<'a, Ventricle> {
        let Self { training, validation, tested: unseen } = self;
        Compared { training, validation, unseen, pace, ..data.compared }
    }

    /// Coarse solution, and regression on the simulations of the shape.
    pub(super) fn without_networks(&self, data: &Data<'_>) -> Result<Vec<Measured>> {
        let compared = self.compared(data, TRANSFER);
        let mut rows = vec![coarse_alone(&compared)?];
        for coarse in [false, true] {
            rows.push(compared.regression(self.training.len(), Inputs { numbers: 0, coarse })?);
        }
        rows.iter_mut().for_each(of_one_shape);
        Ok(rows)
    }

    /// A network of the population, unchanged and fine-tuned on the simulations of the shape.
    pub(super) fn fine_tuned(
        &self,
        data: &Data<'_>,
        variant: Variant,
        surrogate: &Surrogate,
    ) -> Result<FineTuned> {
        let (topology, told) = (data.ventricles.graph(variant.virtual_nodes)?, variant.told);
        let name = format!("{}{}", variant.name(), told.name());
        let names = [", of the population", ", trained further"].map(|how| format!("{name}{how}"));
        let about = "trained on other shapes, which times do not count";
        let found = data.compared.predicting(surrogate, &topology, told);
        // Every sample has features of its own about a coarse solution, so that message passing has to learn too.
        let embedding_share = if told.coarse { 1.0 } else { 0.0 };
        let compared = self.compared(data, Pace { embedding_share, ..TRANSFER });
        let unchanged = compared.measured([&names[0], about], (0.0, 0), told, &found)?;
        let about = format!("the same on {} simulations of this shape", self.training.len());
        let from = |data: &DataSet| Ok(surrogate.transferred_to(data)?);
        let (trained, _) = compared.trained([&names[1], &about], from, told, &topology)?;
        let mut rows = vec![unchanged, trained];
        rows.iter_mut().for_each(of_one_shape);
        let (embedding, fact) = data.compared.embedding((&variant, surrogate), &topology, 2)?;
        Ok(FineTuned { rows, embedding, facts: [fact, data.times(&variant, surrogate)?] })
    }
}

fn of_one_shape(row: &mut Measured) {
    row.group = "one shape".into();
}

/// Prediction of the coarse mesh alone.
pub(super) fn coarse_alone(compared: &Compared<'_, Ventricle>) -> Result<Measured> {
    let about = "the equilibrium of the ventricle on a coarse mesh, by moving least squares";
    let told = Inputs { numbers: ALL, coarse: true };
    compared.measured(["coarse solution", about], (0.0, 0), told, |ventricle| {
        Ok(ventricle.coarse.displacement.clone())
    })
}

/// Quasi-Newton steps with the stiffness of the mean ventricle, which is nearly incompressible as all of them.
pub(super) fn one_stiffness(
    ventricles: &Ventricles,
    compared: &Compared<'_, Ventricle>,
) -> Result<Measured> {
    const STEPS: usize = 32;
    let mean = ventricles.mean()?;
    let stiffness = FrozenStiffness::new(&mean)?;
    let about = "from solution and stiffness of the mean ventricle, one solve in all";
    let names = [&*format!("frozen stiffness, {STEPS} steps"), about];
    let told = Inputs { numbers: ALL, coarse: false };
    compared.measured(names, (0.0, 0), told, |ventricle| {
        Ok(stiffness.descend(&ventricle.body, &ventricle.theta, STEPS)?.displacement)
    })
}

/// Patience \[epochs\] that trainings have, and last none.
const PATIENCE: [usize; 4] = [10, 25, 50, 100];
/// Passes over all samples, few for a quick check.
const EPOCHS: [usize; 2] = [1000, 20];

impl Data<'_> {
    /// Regression and plain networks, put through the same.
    pub(super) fn volumes_alone(&self) -> Result<Vec<Measured>> {
        let mut rows = Vec::new();
        for coarse in [false, true] {
            rows.push(self.regressed_volumes(Inputs { numbers: ALL, coarse })?);
        }
        for transformed in [false, true] {
            rows.extend(self.network_volumes(transformed)?);
        }
        Ok(rows)
    }

    /// A method that finds the volumes \[mm³\] of the ventricles tested, after so many CPU-seconds and simulations, by number.
    fn volumes_found(
        &self,
        [method, about]: [&str; 2],
        (cpu_s, learned): (f64, usize),
        find: impl Fn(&[Ventricle]) -> Result<Vec<f64>>,
    ) -> Result<Measured> {
        let (clock, unseen) = (Instant::now(), self.compared.unseen);
        let found = find(unseen)?;
        let answer_s = clock.elapsed().as_secs_f64() / found.len() as f64;
        let truths = unseen.iter().map(|v| v.volume(&v.displacement));
        let volumes: Vec<f64> = truths.zip(found).map(|(v, found)| (found - v).abs() / v).collect();
        let errors = Distribution::of(volumes.clone()).context("no cavity was tested")?;
        let quartiles = [errors.q25, errors.q50, errors.q75];
        let quartiles = quartiles.map(|error| format!("{:.2}", 100.0 * error)).join(", ");
        Ok(Measured {
            method: method.into(),
            about: format!("{about}; 25, 50, 75 %: {quartiles} %"),
            volumes,
            cpu_s,
            simulated_s: self.compared.simulation_s * learned as f64,
            answer_s,
            ..Measured::default()
        })
    }

    /// Regression of the cavity's growth over numbers and parameters.
    fn regressed_volumes(&self, told: Inputs) -> Result<Measured> {
        let start = cpu_seconds();
        let Compared { training: seen, coarse_s, .. } = self.compared;
        let growth = |v: &Ventricle| Ok(vec![v.growth(&v.displacement) - v.known_growth(told)]);
        let fit = regression(seen, told, growth)?;
        let cpu_s = cpu_seconds() - start;
        let find = |v: &Ventricle| -> Result<f64> {
            let growth = fit.predict(&v.inputs(told))?[0] + v.known_growth(told);
            Ok(growth.exp() * v.volume(&vec![0.0; v.displacement.len()]))
        };
        let method = format!("POD + GP, {} simulations{}", seen.len(), told.name());
        let names = [&method[..], "regression of how much the cavity grows"];
        let found = self.volumes_found(names, (cpu_s, seen.len()), |unseen| {
            unseen.iter().map(find).collect()
        })?;
        let coarse_s = if told.coarse { coarse_s } else { 0.0 };
        Ok(Measured { answer_s: found.answer_s + coarse_s, ..found })
    }

    /// The thesis' plain networks: from parameters and numbers, as they are (MLP 1) or transformed (MLP 2), to the volume.
    fn network_volumes(&self, transformed: bool) -> Result<Vec<Measured>> {
        let Compared { training, validation, options, .. } = self.compared;
        let (start, sizes) = (cpu_seconds(), self.ventricles.sizes()?);
        let inputs = |of: &[Ventricle]| of.iter().map(|v| inputs(v, &sizes, transformed)).collect();
        let volumes =
            |of: &[Ventricle]| of.iter().map(|v| vec![v.volume(&v.displacement)]).collect();
        let known: [Vec<Vec<f64>>; 2] = [inputs(training), volumes(training)];
        let [mut scales, scale] = known.map(|rows| scales(&rows));
        if transformed {
            let second = scales[SECOND][1];
            scales[SECOND - 1..].iter_mut().for_each(|scale| scale[1] = second);
        }
        let samples = |of: &[Ventricle]| -> Samples {
            (scaled(&inputs(of), &scales), scaled(&volumes(of), &scale))
        };
        // The first has no patience in the thesis.
        let (method, patience) =
            if transformed { ("MLP 2", &PATIENCE[..]) } else { ("MLP 1", &[][..]) };
        let learned = training.len() + validation.len();
        let [training, validation] = [training, validation].map(samples);
        let before_s = cpu_seconds() - start;
        let epochs = EPOCHS[usize::from(options.quick)];
        let stopped = Perceptron::train(&training, &validation, patience, epochs, options.seed);
        let find = |network: &Perceptron, unseen: &[Ventricle]| {
            let found = network.predict(&scaled(&inputs(unseen), &scales));
            Ok(found.iter().map(|v| scale[0][0] + scale[0][1] * f64::from(*v)).collect())
        };
        let mut rows = Vec::new();
        for (index, stopped) in stopped.iter().enumerate() {
            let waits = patience.get(index).map_or("none".into(), usize::to_string);
            for (which, weights) in [("best", &stopped.best), ("last", &stopped.last)] {
                let name = format!("{method}, patience {waits}, {which} weights");
                let about = format!("ended after {} epochs", stopped.epoch);
                let cost = (before_s + stopped.cpu_s, learned);
                rows.push(self.volumes_found([&name, &about], cost, |of| find(weights, of))?);
            }
        }
        Ok(rows)
    }
}

/// Inputs of a plain network: parameters and how far every number of the shape moves nodes \[mm\], or the numbers as they are.
fn inputs(ventricle: &Ventricle, sizes: &[f64], transformed: bool) -> Vec<f64> {
    let theta = ventricle.theta.iter().map(|theta| if transformed { theta.ln() } else { *theta });
    theta.chain(ventricle.numbers.iter().zip(sizes).map(|(number, size)| number * size)).collect()
}

/// Place of the second number of a shape among the inputs, by whose deviation transformed numbers are measured.
const SECOND: usize = 5;

/// Mean and deviation of every column.
fn scales(rows: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let column = |column: usize| {
        let mean = |of: &dyn Fn(f64) -> f64| {
            rows.iter().map(|row| of(row[column])).sum::<f64>() / rows.len() as f64
        };
        let centre = mean(&|x| x);
        [centre, mean(&|x| (x - centre).powi(2)).sqrt()]
    };
    (0..rows[0].len()).map(column).collect()
}

fn scaled(rows: &[Vec<f64>], scales: &[[f64; 2]]) -> DMatrix<f32> {
    DMatrix::from_fn(scales.len(), rows.len(), |column, row| {
        ((rows[row][column] - scales[column][0]) / scales[column][1]) as f32
    })
}
