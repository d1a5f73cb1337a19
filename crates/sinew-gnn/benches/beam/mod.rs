//! The gravity beam of the thesis (390 nodes, 511 with virtual ones, M = 40, K = 5) and its training.
#![allow(dead_code)] // every benchmark uses its part

use std::sync::Arc;

use sinew_emulate::coordinates::*;
use sinew_energy::{Barriers, Load, Parameter, Sampling, Scene, Support, laws::NeoHookean};
use sinew_gnn::*;
use sinew_graph::{AugmentationConfig, FeatureMatrix, augment, graph_features};
use sinew_mesh::Mesh;

/// Trained parameter sets [kPa].
const RANGE: [f64; 2] = [50.0, 100.0];

pub(crate) fn thetas(count: usize) -> Vec<Vec<f64>> {
    let point = |i: usize| {
        let fractions = [(i as f64 + 0.5) / count as f64, (i as f64 * 0.618_033_988_75).fract()];
        fractions.iter().map(|f| RANGE[0] * (RANGE[1] / RANGE[0]).powf(*f)).collect()
    };
    (0..count).map(point).collect()
}

fn mesh() -> Mesh<4> {
    sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5])
}

/// The OnceClampedBeam with fields a beam's deflection resembles.
pub(crate) fn beam() -> DataSet {
    let mesh = mesh();
    let config = AugmentationConfig::for_nodes(mesh.points.len());
    let topology =
        augment(&mesh.points, &sinew_mesh::edges(&mesh), &config).expect("a box connects");
    let clamped = &mesh.node_sets["x_min"];
    let indicator =
        FeatureMatrix::indicator(mesh.points.len(), clamped).expect("a node set of the box");
    let geometry = Geometry {
        features: graph_features(&topology, &mesh.points, &indicator, 3)
            .expect("features of the box"),
        global: vec![],
        dirichlet: Dirichlet::clamped(mesh.points.len(), 3, clamped)
            .expect("a node set of the box"),
        coordinates: Coordinates::Components,
        topology,
    };
    let sample = |theta: Vec<f64>| {
        let bend = |x: f64| 0.4 * x * x / theta[0];
        let field = mesh
            .points
            .iter()
            .flat_map(|x| [-0.1 * bend(x[0]), 0.01 * x[1] * x[0] / theta[1], -bend(x[0])]);
        Sample { geometry: 0, displacement: field.collect(), theta }
    };
    DataSet {
        geometries: vec![geometry],
        training: thetas(200).into_iter().map(sample).collect(),
        validation: vec![],
    }
}

/// Minimum potential energy of the neo-Hookean beam under its weight.
pub(crate) fn energy(data: &DataSet) -> Box<dyn Objective> {
    let scene = Scene {
        name: "OnceClampedBeam".into(),
        parameters: ["mu", "lambda"].map(stiffness).to_vec(),
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh(), NeoHookean)
    };
    let potential = scene.lower().expect("a complete scene").with_barriers(Barriers::default());
    let sample = &data.training[0];
    let scale = potential.value(&sample.displacement, &sample.theta).abs();
    Box::new(MinimumPotential::new(vec![Arc::new(potential)], scale).expect("a positive energy"))
}

fn stiffness(name: &str) -> Parameter {
    Parameter { name: name.into(), unit: "kPa".into(), range: RANGE, sampling: Sampling::Log }
}

/// Mean distance to the fields of the data.
pub(crate) fn distance(data: &DataSet) -> Box<dyn Objective> {
    Box::new(DataFit::new(output(data).length()).expect("a length"))
}

fn output(data: &DataSet) -> OutputScale {
    let fields = data.training.iter().map(|sample| &sample.displacement[..]);
    OutputScale::standardising(3, fields).expect("finite fields")
}

/// Steps of a rate so small that the network stays what it is.
pub(crate) fn trainer(
    data: &DataSet,
    batch: usize,
    objective: Box<dyn Objective>,
    optimiser: OptimiserConfig,
) -> Trainer {
    let parameters =
        ParameterScaling::logarithmic(&[RANGE[0]; 2], &[RANGE[1]; 2]).expect("a range");
    let scales = Scales::over(&data.geometries, parameters, output(data)).expect("one geometry");
    let device = Backend::Flex.device().expect("the default backend");
    let config = GraphNetworkConfig::new(3, 1, 4, 2);
    let surrogate = Surrogate::new(&config, data, scales, 0, &device).expect("fitting counts");
    let settings = TrainingConfig {
        batch,
        optimiser,
        learning_rate: 1e-6,
        budget: TrainingBudget::Steps(100_000),
        ..TrainingConfig::default()
    };
    Trainer::new(surrogate, data.clone(), objective, settings).expect("fitting data")
}
