//! Volumes of inflated cavities by methods that predict nothing else (Tables A.10, A.12, A.13).

use super::ALL;
use super::methods::Data;
use super::perceptron::{Perceptron, Samples};
use super::ventricle::Ventricle;
use crate::populations::rows::Measured;
use crate::populations::simulated::{Compared, Simulated, regression};
use crate::populations::variant::Inputs;
use crate::timing::cpu_seconds;
use anyhow::{Context, Result};
use nalgebra::DMatrix;
use sinew_report::Distribution;
use std::time::Instant;

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
