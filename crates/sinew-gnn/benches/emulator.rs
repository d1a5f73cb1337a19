//! Emulator of the gravity beams (390 nodes, 511 with virtual ones, M = 40, K = 5): full forward
//! pass, decoder alone, and one data-driven training step with Muon, by number of parameter sets.
//!
//! Beside every time stands the error of the fused kernels: the largest difference from the
//! reference path, relative to the largest displacement.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion};
use sinew_gnn::*;
use sinew_graph::{AugmentationConfig, FeatureMatrix, augment, graph_features};

/// Trained parameter sets [kPa].
const RANGE: [f64; 2] = [50.0, 100.0];

fn thetas(count: usize) -> Vec<Vec<f64>> {
    let point = |i: usize| {
        let fractions = [(i as f64 + 0.5) / count as f64, (i as f64 * 0.618_033_988_75).fract()];
        fractions.iter().map(|f| RANGE[0] * (RANGE[1] / RANGE[0]).powf(*f)).collect()
    };
    (0..count).map(point).collect()
}

/// The OnceClampedBeam with fields a beam's deflection resembles.
fn beam() -> DataSet {
    let mesh = sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
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
        basis: None,
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
        topology,
        geometries: vec![geometry],
        training: thetas(200).into_iter().map(sample).collect(),
        validation: vec![],
    }
}

fn trainer(data: &DataSet, batch: usize) -> Trainer {
    let fields = data.training.iter().map(|sample| &sample.displacement[..]);
    let output = OutputScale::standardising(3, fields).expect("finite fields");
    let length = output.length();
    let parameters =
        ParameterScaling::logarithmic(&[RANGE[0]; 2], &[RANGE[1]; 2]).expect("a range");
    let scales = Scales::over(&data.geometries, parameters, output).expect("one geometry");
    let device = Backend::Flex.device().expect("the default backend");
    let config = EmulatorConfig::new(3, 1, 4, 2);
    let surrogate = Surrogate::new(&config, data, scales, 0, &device).expect("fitting counts");
    let settings =
        TrainingConfig { batch, budget: Budget::Steps(100_000), ..TrainingConfig::default() };
    let objective = DataFit::new(length).expect("a length");
    Trainer::new(surrogate, data.clone(), Box::new(objective), settings).expect("fitting data")
}

/// Largest difference between fused and reference path, relative to the largest displacement.
fn fused_error(surrogate: &Surrogate, thetas: &[Vec<f64>]) -> f64 {
    let predict = |choice| {
        let surrogate = surrogate.clone().with_kernels(choice);
        surrogate
            .predict(&surrogate.geometries()[0], thetas)
            .expect("inside the range")
            .displacement
    };
    let (fused, reference) = (predict(KernelChoice::Fused), predict(KernelChoice::Reference));
    let size = reference.iter().fold(0f64, |m, u| m.max(u.abs()));
    fused.iter().zip(&reference).fold(0f64, |m, (a, b)| m.max((a - b).abs())) / size
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args();
    let data = beam();
    let mut brief = trainer(&data, 8);
    for _ in 0..20 {
        brief.step().expect("finite loss");
    }
    let surrogate = brief.current_surrogate();
    println!(
        "{} nodes, {} stored edges, error of the fused kernels {:.1e}",
        data.topology.nodes,
        data.topology.senders.len(),
        fused_error(&surrogate, &thetas(8)),
    );
    let geometry = &data.geometries[0];
    let fixed = surrogate.fixed_geometry(geometry).expect("the trained geometry");
    for batch in [1, 32, 200] {
        let thetas = thetas(batch);
        criterion.bench_with_input(
            BenchmarkId::new("forward", batch),
            &thetas,
            |bencher, thetas| {
                bencher.iter(|| black_box(surrogate.predict(geometry, thetas)));
            },
        );
        criterion.bench_with_input(
            BenchmarkId::new("decoder", batch),
            &thetas,
            |bencher, thetas| {
                bencher.iter(|| black_box(fixed.predict(thetas)));
            },
        );
    }
    for batch in [1, 8, 25, 32, 200] {
        let mut trainer = trainer(&data, batch);
        criterion.bench_function(&format!("training step/{batch}"), |bencher| {
            bencher.iter(|| trainer.step().expect("finite loss"));
        });
    }
    criterion.final_summary();
}
