//! Beams on their trees of clusters.

use crate::common::{small_config, thetas};
use sinew_emulate::coordinates::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Barriers, Body, Load, Parameter, Sampling, Scene, Support};
use sinew_fem::Solver;
use sinew_gnn::*;
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};
use sinew_mesh::{TetMesh, box_tetrahedra};
use std::sync::Arc;

pub(crate) const WEIGHT: f64 = 9.8e-3;

pub(crate) fn scene(mesh: TetMesh, weight: [f64; 3], supports: Vec<Support>) -> Body {
    let parameter = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [50.0, 100.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "beam".into(),
        parameters: vec![parameter("mu"), parameter("lambda")],
        loads: vec![Load::BodyForce(weight)],
        supports,
        ..Scene::new(mesh, NeoHookean)
    };
    scene.lower().unwrap()
}

/// Displacement of a body under its loads as if it were linear about rest.
pub(crate) fn response(body: &Body, theta: &[f64; 2]) -> Vec<f64> {
    Solver::new(body).unwrap().linear_response(theta).unwrap()
}

/// A body on its tree of clusters, with outputs at every scale.
pub(crate) struct Beam {
    pub body: Body,
    pub topology: Topology,
    pub theta: [f64; 2],
}

impl Beam {
    pub(crate) fn new(mesh: TetMesh, theta: [f64; 2], supports: Vec<Support>) -> Self {
        let edges = sinew_mesh::edges(&mesh);
        let config = AugmentationConfig::to_one_root(mesh.points.len(), 4);
        let topology = augment(&mesh.points, &edges, &config).unwrap();
        let body = scene(mesh, [0.0, 0.0, -WEIGHT], supports);
        Self { body, topology, theta }
    }

    pub(crate) fn hanging(cells: [usize; 3]) -> Self {
        let mesh = box_tetrahedra([40.0, 10.0, 10.0], cells);
        Self::new(mesh, [75.0, 75.0], vec![Support::clamped("x_min")])
    }

    pub(crate) fn motions(&self) -> Motions {
        let rest = vec![0.0; 3 * self.body.nodes];
        Motions::about(&rest, &self.topology.clusters, &self.body, &self.theta).unwrap()
    }

    pub(crate) fn response(&self) -> Vec<f64> {
        response(&self.body, &self.theta)
    }

    /// Energy of the linear response.
    pub(crate) fn energy(&self) -> f64 {
        -0.5 * self.body.load_value(&self.response(), &self.theta)
    }

    pub(crate) fn data(&self) -> DataSet {
        let held: Vec<usize> =
            (0..self.body.nodes).filter(|i| self.body.prescribed[3 * i].is_some()).collect();
        let indicator = FeatureMatrix::indicator(self.body.nodes, &held).unwrap();
        let geometry = Geometry {
            topology: self.topology.clone(),
            features: graph_features(&self.topology, &self.body.positions, &indicator, 3).unwrap(),
            global: vec![],
            dirichlet: Dirichlet::of_body(&self.body),
            coordinates: Coordinates::Motions(
                self.motions().of_energy(9.0 * self.energy()).unwrap(),
            ),
        };
        let sample = |theta: [f64; 2]| Sample {
            geometry: 0,
            theta: theta.map(|t| 50.0 * t.sqrt() * 2f64.sqrt()).to_vec(),
            displacement: vec![],
        };
        DataSet {
            geometries: vec![geometry],
            training: thetas(16).into_iter().map(sample).collect(),
            validation: vec![],
        }
    }

    pub(crate) fn surrogate(&self, data: &DataSet, device: &burn::tensor::Device) -> Surrogate {
        let parameters = ParameterScaling::logarithmic(&[50.0; 2], &[100.0; 2]).unwrap();
        let output = OutputScale::root_mean_square(3, [&self.response()[..]]).unwrap();
        let scales = Scales::over(&data.geometries, parameters, output).unwrap();
        let layers = self.topology.roots_per_layer.len();
        let decoding = Decoding::Motions { layers, width: 8 };
        let config = GraphNetworkConfig { decoding, ..small_config(data, 3) };
        Surrogate::new(&config, data, scales, 1, device).unwrap()
    }

    pub(crate) fn trained(
        &self,
        data: &DataSet,
        steps: usize,
        device: &burn::tensor::Device,
    ) -> Surrogate {
        let (surrogate, objective) = (self.surrogate(data, device), self.objective());
        let settings = TrainingConfig {
            budget: TrainingBudget::Steps(steps),
            batch: 4,
            learning_rate: 1e-2,
            evaluations: 1,
            ..TrainingConfig::default()
        };
        let mut trainer = Trainer::new(surrogate, data.clone(), objective, settings).unwrap();
        trainer.run(&mut ()).unwrap();
        trainer.into_surrogate()
    }

    /// Objective: energy of the body with barriers.
    pub(crate) fn objective(&self) -> Box<dyn Objective> {
        let potential = self.body.clone().with_barriers(Barriers::default());
        Box::new(MinimumPotential::new(vec![Arc::new(potential)], self.energy()).unwrap())
    }
}
