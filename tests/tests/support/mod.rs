//! A small beam that bends under its own weight, as scene, as graph and as data set.
#![allow(dead_code)] // every test program uses its part

use sinew_emulate::coordinates::{Coordinates, Dirichlet, OutputScale, ParameterScaling};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Sampling, Scene, Support};
use sinew_fem::{Options, Solution, Solver, sweep};
use sinew_gnn::{
    Backend, Geometry, GraphNetworkConfig, Objective, Sample, Scales, Surrogate, Trainer,
    TrainingConfig,
};
use sinew_graph::{AugmentationConfig, FeatureMatrix, augment, graph_features};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// Range of μ and λ [kPa]: soft enough that the beam's tip sinks by a sixth to a third of its length.
pub(crate) const RANGE: [f64; 2] = [8.0, 16.0];
/// Weight of a density of 1 g/cm³ at g = 9.8 m/s² [kPa/mm].
pub(crate) const GRAVITY: f64 = 9.8e-3;

/// One entry of θ on the log scale.
pub(crate) fn stiffness(name: &str, range: [f64; 2]) -> Parameter {
    Parameter { name: name.into(), unit: "kPa".into(), range, sampling: Sampling::Log }
}

/// A mesh clamped at `x_min` under a vertical body force [kPa/mm].
pub(crate) fn hanging(mesh: TetMesh, weight: f64) -> Scene {
    Scene {
        name: "beam".into(),
        parameters: vec![stiffness("mu", RANGE), stiffness("lambda", RANGE)],
        loads: vec![Load::BodyForce([0.0, 0.0, -weight])],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, NeoHookean)
    }
}

/// A coarse beam of 63 nodes with its graph: emulators of it train in seconds.
pub(crate) struct Beam {
    pub potential: Body,
    pub geometry: Geometry,
}

impl Beam {
    pub(crate) fn new() -> Self {
        let mesh = mesh();
        let potential =
            hanging(mesh.clone(), GRAVITY).lower().expect("the beam is held and loaded");
        let nodes = potential.nodes;
        let config = AugmentationConfig::for_nodes(nodes);
        let edges = sinew_mesh::edges(&mesh);
        let topology =
            augment(&mesh.points, &edges, &config).expect("a beam is one connected graph");
        let indicator = FeatureMatrix::indicator(nodes, &mesh.node_sets["x_min"]).unwrap();
        let geometry = Geometry {
            features: graph_features(&topology, &mesh.points, &indicator, 3).unwrap(),
            global: Vec::new(),
            dirichlet: Dirichlet::of_body(&potential),
            coordinates: Coordinates::Components,
            topology,
        };
        Self { potential, geometry }
    }

    /// Small displacements scaled up: a size of displacements that needs no simulation.
    pub(crate) fn linear_response(&self, theta: &[f64]) -> Vec<f64> {
        const SMALL: f64 = 1e-6;
        let potential = hanging(mesh(), SMALL * GRAVITY).lower().unwrap();
        let solution = Solver::new(&potential).unwrap().solve(theta, &Options::default()).unwrap();
        solution.displacement.iter().map(|u| u / SMALL).collect()
    }

    /// Equilibria of the finite-element model.
    pub(crate) fn solve(&self, thetas: &[Vec<f64>]) -> Vec<Solution> {
        let swept = sweep(&self.potential, thetas, &Options::default(), || ()).unwrap();
        swept.into_iter().map(Result::unwrap).collect()
    }

    /// A small untrained emulator in a trainer; `fields` are simulations, or empty.
    pub(crate) fn trainer(
        &self,
        thetas: &[Vec<f64>],
        fields: &[Vec<f64>],
        output: OutputScale,
        objective: Box<dyn Objective>,
        config: TrainingConfig,
    ) -> Trainer {
        let sample = |(index, theta): (usize, &Vec<f64>)| Sample {
            geometry: 0,
            theta: theta.clone(),
            displacement: fields.get(index).cloned().unwrap_or_default(),
        };
        let data = sinew_gnn::DataSet {
            geometries: vec![self.geometry.clone()],
            training: thetas.iter().enumerate().map(sample).collect(),
            validation: Vec::new(),
        };
        let features = &self.geometry.features;
        let network = GraphNetworkConfig {
            latent: 16,
            width: 32,
            steps: 3,
            ..GraphNetworkConfig::new(3, features.nodes.columns, features.edges.columns, 2)
        };
        let parameters = ParameterScaling::logarithmic(&[RANGE[0]; 2], &[RANGE[1]; 2]).unwrap();
        let scales = Scales::over(&data.geometries, parameters, output).unwrap();
        let device = Backend::Flex.device().unwrap();
        let surrogate = Surrogate::new(&network, &data, scales, config.seed, &device).unwrap();
        Trainer::new(surrogate, data, objective, config).unwrap()
    }
}

fn mesh() -> TetMesh {
    box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2])
}

/// Centre of the parameter range on its log scale.
pub(crate) fn centre() -> Vec<f64> {
    vec![(RANGE[0] * RANGE[1]).sqrt(); 2]
}

/// A regular grid over the range, on its log scale, corners included.
pub(crate) fn grid(per_axis: usize) -> Vec<Vec<f64>> {
    let at = |i: usize| RANGE[0] * (RANGE[1] / RANGE[0]).powf(i as f64 / (per_axis - 1) as f64);
    (0..per_axis * per_axis).map(|i| vec![at(i % per_axis), at(i / per_axis)]).collect()
}

pub(crate) fn norm(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(|value| value * value).sum::<f64>().sqrt()
}
