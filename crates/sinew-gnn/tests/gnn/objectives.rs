//! Objectives on simulations against their formulas.

use crate::common::*;
use burn::tensor::{Tensor, TensorData};
use sinew_emulate::coordinates::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Parameter, Sampling, Scene, Stiffness, Support};
use sinew_gnn::*;

/// Displacements in single precision.
const ROUNDING: f64 = 1e-5;

/// A data set of one beam, and a prediction for its first two samples.
fn prediction() -> (DataSet, Vec<f64>) {
    let body = beam([3, 1, 1], vec![4, 1]);
    let thetas = [[0.6, 1.0], [1.0, 0.7], [1.7, 1.2]];
    let training = thetas.into_iter().map(|theta| body.sample(0, theta, 1.0)).collect::<Vec<_>>();
    let predicted = training[..2].iter().flat_map(|sample| &sample.displacement).enumerate();
    let predicted = predicted.map(|(i, u)| u + 0.1 * (0.9 * i as f64).sin()).collect();
    let data = DataSet { geometries: vec![body.rest()], training, validation: vec![] };
    (data, predicted)
}

/// The stiffness of such a beam of given cells at rest.
fn stiffness(cells: [usize; 3]) -> Stiffness {
    let parameter = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [0.5, 2.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "beam".into(),
        parameters: vec![parameter("mu"), parameter("lambda")],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], cells), NeoHookean)
    };
    let body = scene.lower().unwrap();
    body.stiffness(&vec![0.0; 3 * body.nodes], &[1.0, 1.0]).unwrap()
}

fn norm(stiffness: &Stiffness, error: &[f64]) -> f64 {
    let mut forces = vec![0.0; error.len()];
    stiffness.apply(error, &mut forces);
    forces.iter().zip(error).map(|(f, e)| f * e).sum::<f64>().sqrt()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn loss(objective: &dyn Objective, data: &DataSet, predicted: &[f64]) -> f64 {
    objective.check(data).unwrap();
    let values: Vec<f32> = predicted.iter().map(|&u| u as f32).collect();
    let dims = [2, data.geometries[0].topology.real_nodes, 3];
    let u = Tensor::<3>::from_data(TensorData::new(values, dims), &devices()[0]);
    let batch = Batch { geometry: 0, samples: &[&data.training[0], &data.training[1]] };
    objective.loss(&batch, u).unwrap().into_scalar::<f32>().into()
}

#[test]
fn the_energy_norm_is_the_root_of_what_an_error_costs() {
    let (data, predicted) = prediction();
    let size = predicted.len() / 2;
    let stiffness = stiffness([3, 1, 1]);
    let objective = EnergyNormFit::new(vec![stiffness.clone()], &data).unwrap();
    let fields: Vec<&[f64]> = data.training.iter().map(|s| &s.displacement[..]).collect();
    let mean: Vec<f64> =
        (0..size).map(|i| fields.iter().map(|f| f[i]).sum::<f64>() / 3.0).collect();
    let spread: f64 = fields.iter().map(|f| norm(&stiffness, &difference(f, &mean)).powi(2)).sum();
    let unit = (spread / 3.0).sqrt();
    let norms =
        predicted.chunks_exact(size).zip(&fields).map(|(u, f)| norm(&stiffness, &difference(u, f)));
    let expected = norms.sum::<f64>() / 2.0 / unit;
    let found = loss(&objective, &data, &predicted);
    assert!((found / expected - 1.0).abs() < ROUNDING, "{found} for {expected}");
}

#[test]
fn an_energy_norm_needs_a_fitting_stiffness_and_simulations() {
    let (data, _) = prediction();
    let attempt =
        |cells, data: &DataSet| EnergyNormFit::new(vec![stiffness(cells)], data).unwrap_err();
    assert!(matches!(attempt([2, 1, 1], &data), Error::Coordinates(CoordinateError::Count { .. })));
    let mut without = data.clone();
    without.training[1].displacement.clear();
    assert!(matches!(
        attempt([3, 1, 1], &without),
        Error::Coordinates(CoordinateError::Count { .. })
    ));
    let mut same = data.clone();
    same.training.truncate(1);
    assert!(matches!(attempt([3, 1, 1], &same), Error::Coordinates(CoordinateError::Scale { .. })));
    assert!(EnergyNormFit::new(vec![], &data).is_err());
}
