//! Objectives on simulations against their formulas.

mod common;

use burn::tensor::{Tensor, TensorData};
use common::*;
use sinew_gnn::*;

/// Single precision through a product with a small matrix.
const ROUNDING: f64 = 1e-5;

/// A data set of one geometry, and a prediction for its first two samples.
fn prediction() -> (DataSet, Vec<f64>) {
    let body = plane_cantilever(40.0);
    let thetas = [[0.6, 1.0], [1.0, 0.7], [1.7, 1.2]];
    let training = thetas.into_iter().map(|theta| body.sample(0, theta, 1.0)).collect::<Vec<_>>();
    let predicted = training[..2].iter().flat_map(|sample| &sample.displacement).enumerate();
    let predicted = predicted.map(|(i, u)| u + 0.1 * (0.9 * i as f64).sin()).collect();
    let topology = body.topology.clone();
    let data = DataSet { topology, geometries: vec![body.rest()], training, validation: vec![] };
    (data, predicted)
}

/// A symmetric matrix, diagonally dominant.
fn root(size: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| if i == j { 2.0 } else { 0.5 / (1.0 + i.abs_diff(j) as f64) };
    (0..size * size).map(|at| entry(at / size, at % size)).collect()
}

fn times(root: &[f64], field: &[f64]) -> Vec<f64> {
    let dot = |row: &[f64]| row.iter().zip(field).map(|(a, b)| a * b).sum();
    root.chunks_exact(field.len()).map(dot).collect()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn loss(objective: &dyn Objective, data: &DataSet, predicted: &[f64]) -> f64 {
    objective.check(data).unwrap();
    let values: Vec<f32> = predicted.iter().map(|&u| u as f32).collect();
    let dims = [2, data.topology.real_nodes, 2];
    let u = Tensor::<3>::from_data(TensorData::new(values, dims), &devices()[0]);
    let batch = Batch { geometry: 0, samples: &[&data.training[0], &data.training[1]] };
    objective.loss(&batch, u).unwrap().into_scalar::<f32>().into()
}

#[test]
fn the_energy_norm_weighs_errors_by_its_root() {
    let (data, predicted) = prediction();
    let size = predicted.len() / 2;
    let root = root(size);
    let objective = EnergyNormFit::new(std::slice::from_ref(&root), &data).unwrap();
    // By hand: mean nodal length over the root mean square of the simulations' departures from their mean.
    let fields: Vec<&[f64]> = data.training.iter().map(|s| &s.displacement[..]).collect();
    let mean: Vec<f64> =
        (0..size).map(|i| fields.iter().map(|f| f[i]).sum::<f64>() / 3.0).collect();
    let squares = fields.iter().flat_map(|f| times(&root, &difference(f, &mean)));
    let unit = (squares.map(|x| x * x).sum::<f64>() / (3 * size) as f64).sqrt();
    let lengths = predicted.chunks_exact(size).zip(&fields).flat_map(|(u, f)| {
        let weighed = times(&root, &difference(u, f));
        weighed.chunks_exact(2).map(|row| row[0].hypot(row[1])).collect::<Vec<_>>()
    });
    let expected = lengths.sum::<f64>() / size as f64 / unit;
    let found = loss(&objective, &data, &predicted);
    assert!((found / expected - 1.0).abs() < ROUNDING, "{found} for {expected}");
}

#[test]
fn terms_of_a_sum_enter_with_their_weights() {
    let (data, predicted) = prediction();
    let size = predicted.len() / 2;
    let energy_norm = || Box::new(EnergyNormFit::new(&[root(size)], &data).unwrap());
    let fit = || Box::new(DataFit::new(3.0).unwrap());
    let sum = WeightedSum::new(vec![(2.0, energy_norm()), (0.25, fit())]).unwrap();
    let expected =
        2.0 * loss(&*energy_norm(), &data, &predicted) + 0.25 * loss(&*fit(), &data, &predicted);
    let found = loss(&sum, &data, &predicted);
    assert!((found / expected - 1.0).abs() < ROUNDING, "{found} for {expected}");
    assert!(matches!(WeightedSum::new(vec![]), Err(Error::NothingToTrain(_))));
    assert!(matches!(WeightedSum::new(vec![(f64::NAN, fit())]), Err(Error::Scale { .. })));
}

#[test]
fn an_energy_norm_needs_a_fitting_root_and_simulations() {
    let (data, predicted) = prediction();
    let size = predicted.len() / 2;
    let attempt = |root: Vec<f64>, data: &DataSet| EnergyNormFit::new(&[root], data).unwrap_err();
    assert!(matches!(attempt(root(size - 1), &data), Error::Count { .. }));
    let mut broken = root(size);
    broken[7] = f64::NAN;
    assert!(matches!(attempt(broken, &data), Error::NotFinite { index: 7, .. }));
    let mut without = data.clone();
    without.training[1].displacement.clear();
    assert!(matches!(attempt(root(size), &without), Error::Count { .. }));
    let mut same = data.clone();
    same.training.truncate(1);
    assert!(matches!(attempt(root(size), &same), Error::Scale { .. }));
    assert!(EnergyNormFit::new(&[], &data).is_err());
}
