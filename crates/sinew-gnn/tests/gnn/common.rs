//! Small bodies for the tests: a plane cantilever and a beam in space.
#![allow(dead_code)] // every test program uses its part

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Tensor};
use sinew_emulate::coordinates::*;
use sinew_gnn::*;
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};

/// Processors of this build: they repeat every bit, which a graphics processor need not.
pub(crate) fn devices() -> Vec<Device> {
    [Backend::Flex, Backend::NdArray].iter().filter_map(|backend| backend.device().ok()).collect()
}

/// A mesh as the tests need it.
pub(crate) struct Body {
    pub dimensions: usize,
    pub points: Vec<[f64; 3]>,
    pub clamped: Vec<usize>,
    pub topology: Topology,
}

pub(crate) fn plane_cantilever(length: f64) -> Body {
    let mesh = sinew_mesh::rectangle_triangles([length, 10.0], [6, 3]);
    body(2, mesh.points.clone(), &sinew_mesh::edges(&mesh), vec![7, 3])
}

pub(crate) fn beam(cells: [usize; 3], roots: Vec<usize>) -> Body {
    beam_of([100.0, 10.0, 10.0], cells, roots)
}

pub(crate) fn beam_of(size: [f64; 3], cells: [usize; 3], roots: Vec<usize>) -> Body {
    let mesh = sinew_mesh::box_tetrahedra(size, cells);
    body(3, mesh.points.clone(), &sinew_mesh::edges(&mesh), roots)
}

fn body(dimensions: usize, points: Vec<[f64; 3]>, edges: &[[usize; 2]], roots: Vec<usize>) -> Body {
    let mut config = AugmentationConfig::for_nodes(points.len());
    config.roots_per_layer = roots;
    let topology = augment(&points, edges, &config).unwrap();
    let clamped = (0..points.len()).filter(|&node| points[node][0] == 0.0).collect();
    Body { dimensions, points, clamped, topology }
}

impl Body {
    /// This body's geometry with points moved by `map` on the same topology.
    pub(crate) fn geometry(
        &self,
        global: Vec<f64>,
        map: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Geometry {
        let points: Vec<[f64; 3]> = self.points.iter().map(|&x| map(x)).collect();
        let nodes = self.points.len();
        let indicator = FeatureMatrix::indicator(nodes, &self.clamped).unwrap();
        Geometry {
            topology: self.topology.clone(),
            features: graph_features(&self.topology, &points, &indicator, self.dimensions).unwrap(),
            global,
            dirichlet: Dirichlet::clamped(nodes, self.dimensions, &self.clamped).unwrap(),
            coordinates: Coordinates::Components,
        }
    }

    pub(crate) fn rest(&self) -> Geometry {
        self.geometry(vec![], |x| x)
    }

    /// A made-up field, linear in position squared and compliance.
    pub(crate) fn field(&self, theta: &[f64], stretch: f64) -> Vec<f64> {
        let bend = |x: &[f64; 3]| stretch * 1e-3 * x[0] * x[0] / theta[0];
        let row = |x: &[f64; 3]| {
            let mut u = vec![-0.3 * bend(x) * x[1] / 10.0 * theta[1]; self.dimensions];
            u[self.dimensions - 1] = -bend(x);
            u
        };
        self.points.iter().flat_map(row).collect()
    }

    pub(crate) fn sample(&self, geometry: usize, theta: [f64; 2], stretch: f64) -> Sample {
        Sample { geometry, theta: theta.to_vec(), displacement: self.field(&theta, stretch) }
    }
}

/// Parameters in [0.5, 2]², spread without randomness.
pub(crate) fn thetas(count: usize) -> Vec<[f64; 2]> {
    let point = |i: usize| {
        let (a, b) = ((i as f64 + 0.5) / count as f64, (i as f64 * 0.618_033_988_75).fract());
        [0.5 * 4f64.powf(a), 0.5 * 4f64.powf(b)]
    };
    (0..count).map(point).collect()
}

/// Two plane cantilevers of different length on one topology, with simulated fields.
pub(crate) fn plane_data() -> (Body, DataSet) {
    let body = plane_cantilever(40.0);
    let stretched = |factor: f64| move |x: [f64; 3]| [factor * x[0], x[1], x[2]];
    let geometries = vec![
        body.geometry(vec![40.0, 10.0], |x| x),
        body.geometry(vec![60.0, 10.0], stretched(1.5)),
    ];
    let sample = |(i, theta): (usize, [f64; 2])| body.sample(i % 2, theta, 1.0 + (i % 2) as f64);
    let training = thetas(12).into_iter().enumerate().map(sample).collect();
    let validation = thetas(5).into_iter().enumerate().map(sample).collect();
    let data = DataSet { geometries, training, validation };
    (body, data)
}

pub(crate) fn small_config(data: &DataSet, dimensions: usize) -> GraphNetworkConfig {
    let features = &data.geometries[0].features;
    let mut config =
        GraphNetworkConfig::new(dimensions, features.nodes.columns, features.edges.columns, 2);
    config.latent = 8;
    config.width = 16;
    config.steps = 2;
    config.global_features = data.geometries[0].global.len();
    config
}

pub(crate) fn untrained(
    data: &DataSet,
    config: &GraphNetworkConfig,
    seed: u64,
    device: &Device,
) -> Surrogate {
    let fields = data.training.iter().map(|sample| &sample.displacement[..]);
    let output = OutputScale::standardising(config.dimensions, fields).unwrap();
    let parameters = ParameterScaling::logarithmic(&[0.5, 0.5], &[2.0, 2.0]).unwrap();
    let scales = Scales::over(&data.geometries, parameters, output).unwrap();
    Surrogate::new(config, data, scales, seed, device).unwrap()
}

pub(crate) fn data_fit(surrogate: &Surrogate) -> Box<dyn Objective> {
    Box::new(DataFit::new(surrogate.scales().output.length()).unwrap())
}

/// Trained for a few steps, so that outputs are not zero.
pub(crate) fn briefly_trained(
    data: &DataSet,
    config: &GraphNetworkConfig,
    device: &Device,
) -> Surrogate {
    let surrogate = untrained(data, config, 1, device);
    let objective = data_fit(&surrogate);
    let settings = TrainingConfig {
        budget: TrainingBudget::Steps(8),
        batch: 3,
        evaluations: 1,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate, data.clone(), objective, settings).unwrap();
    trainer.run(&mut ()).unwrap();
    trainer.into_surrogate()
}

/// Largest difference relative to the largest value.
pub(crate) fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = a.iter().fold(0f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).fold(0f64, |m, (x, y)| m.max((x - y).abs())) / size
}

/// Shapes and numbers of the weights of a network, in the order of its modules.
pub(crate) fn weights(network: &GraphNetwork) -> Vec<(Vec<usize>, Vec<f64>)> {
    let mut weights = Weights(Vec::new());
    network.visit(&mut weights);
    weights.0
}

struct Weights(Vec<(Vec<usize>, Vec<f64>)>);

impl ModuleVisitor for Weights {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let weight = param.val();
        self.0.push((weight.dims().to_vec(), weight.into_data().iter::<f64>().collect()));
    }
}

/// A loss of so small a size that its gradients vanish beside Adam's epsilon.
struct Tiny(Box<dyn Objective>);

/// Size of a [`Tiny`] loss: a power of two, which changes no digit.
pub(crate) const TINY: f64 = 1.0 / (1u64 << 60) as f64;

impl Objective for Tiny {
    fn check(&self, data: &DataSet) -> Result<()> {
        self.0.check(data)
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        Ok(self.0.loss(samples, displacement)? * TINY)
    }
}

/// A training on all samples at once whose steps are `rate` times the gradient of the loss: Adam without memory, whose
/// direction is the gradient over its epsilon where that is the larger one. Loss and gradient norm are told [`TINY`].
pub(crate) fn descent(
    surrogate: &Surrogate,
    data: &DataSet,
    objective: Box<dyn Objective>,
    rate: f64,
) -> Trainer {
    const EPSILON: f64 = 1e-8;
    let settings = TrainingConfig {
        optimiser: OptimiserConfig::Adam { beta1: 0.0, beta2: 0.0 },
        schedule: Schedule::Constant,
        learning_rate: rate * EPSILON / TINY,
        gradient_norm_limit: None,
        budget: TrainingBudget::Steps(4),
        batch: data.training.len(),
        ..TrainingConfig::default()
    };
    Trainer::new(surrogate.clone(), data.clone(), Box::new(Tiny(objective)), settings).unwrap()
}

/// Two plane cantilevers, and a sample on the first alone.
pub(crate) fn one_sample() -> DataSet {
    let (_, mut data) = plane_data();
    data.training.truncate(1);
    data.validation.clear();
    data
}
