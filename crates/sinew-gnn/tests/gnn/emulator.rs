//! Properties of the network itself.

use crate::common::*;
use burn::module::Module;
use sinew_emulate::coordinates::*;
use sinew_gnn::*;

/// Single precision through some fifteen layers.
const ROUNDING: f64 = 2e-5;

#[test]
fn the_beams_network_has_the_thesis_size() {
    // M = 40, K = 5, width 128: the thesis' 3-D beams have about 510 000 parameters.
    let config = GraphNetworkConfig::new(3, 1, 4, 2);
    let emulator = GraphNetwork::new(&config, 0, &devices()[0]).unwrap();
    assert_eq!(emulator.num_params(), 509_883);
}

#[test]
fn predictions_start_at_the_output_mean_and_keep_the_supports() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    for device in devices() {
        let surrogate = untrained(&data, &config, 0, &device);
        let mean = &surrogate.scales().output.mean;
        let prediction = surrogate.predict(&data.geometries[0], &[vec![1.0, 1.0]]).unwrap();
        for (dof, value) in prediction[0].iter().enumerate() {
            match data.geometries[0].dirichlet.prescribed[dof] {
                Some(prescribed) => assert_eq!(*value, prescribed),
                None => assert!((value - mean[dof % 2]).abs() < 1e-6 * mean[dof % 2].abs()),
            }
        }
    }
}

#[test]
fn one_seed_gives_one_network() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    for device in devices() {
        let [a, b, c] = [1, 1, 2].map(|seed| {
            let emulator = GraphNetwork::new(&config, seed, &device).unwrap();
            emulator.into_record().into_bytes().unwrap()
        });
        assert!(a == b && a != c);
    }
}

#[test]
fn weights_have_the_variance_of_lecun() {
    /// Standard deviation of a unit normal truncated to [−2, 2].
    const TRUNCATED_DEVIATION: f64 = 0.879_625_661_034_239_8;
    let config = GraphNetworkConfig { width: 400, ..GraphNetworkConfig::new(2, 100, 3, 1) };
    let emulator = GraphNetwork::new(&config, 3, &devices()[0]).unwrap();
    let weights = weights(&emulator);
    let (_, values) = weights.iter().find(|(shape, _)| shape[..] == [100, 400]).unwrap();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
    // Standard error of the variance of 40 000 draws: 0.7 %; of the mean: 5e-4.
    assert!((variance * 100.0 - 1.0).abs() < 0.03, "variance {variance}");
    assert!(mean.abs() < 2e-3, "mean {mean}");
    let bound = 2.0 / TRUNCATED_DEVIATION / 10.0;
    assert!(values.iter().all(|v| v.abs() <= bound * 1.0001));
}

#[test]
fn moving_the_body_does_not_change_the_prediction() {
    let (body, data) = plane_data();
    let config = small_config(&data, 2);
    for device in devices() {
        let surrogate = briefly_trained(&data, &config, &device);
        let moved = body.geometry(vec![40.0, 10.0], |x| [x[0] + 300.0, x[1] - 70.0, x[2]]);
        let theta = [vec![0.7, 1.2]];
        let here = surrogate.predict(&data.geometries[0], &theta).unwrap();
        let there = surrogate.predict(&moved, &theta).unwrap();
        assert!(relative_difference(&here[0], &there[0]) < ROUNDING);
        let stretched = surrogate.predict(&data.geometries[1], &theta).unwrap();
        assert!(relative_difference(&here[0], &stretched[0]) > 1e-2);
    }
}

#[test]
fn the_order_of_the_stored_edges_does_not_matter() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    let device = &devices()[0];
    let surrogate = untrained(&data, &config, 3, device);
    let features = surrogate.scales().features.standardise(&data.geometries[0].features).unwrap();
    let table = |values: &[f64], rows: usize| {
        let columns = values.len() / rows;
        let values: Vec<f32> = values.iter().map(|&v| v as f32).collect();
        burn::tensor::Tensor::<2>::from_data(
            burn::tensor::TensorData::new(values, [rows, columns]),
            device,
        )
    };
    let nodes = table(&features.nodes.values, features.nodes.rows);
    let embed = |order: &[usize]| {
        let mut topology = data.geometries[0].topology.clone();
        topology.senders =
            order.iter().map(|&edge| data.geometries[0].topology.senders[edge]).collect();
        topology.receivers =
            order.iter().map(|&edge| data.geometries[0].topology.receivers[edge]).collect();
        let rows: Vec<f64> =
            order.iter().flat_map(|&edge| features.edges.row(edge).to_vec()).collect();
        let graph = Graph::new(&topology);
        let local =
            surrogate.emulator().local_embedding(&graph, nodes.clone(), table(&rows, order.len()));
        local[0].to_data().iter::<f64>().collect::<Vec<f64>>()
    };
    let order: Vec<usize> = (0..data.geometries[0].topology.senders.len()).collect();
    let reversed: Vec<usize> = order.iter().rev().copied().collect();
    assert!(relative_difference(&embed(&order), &embed(&reversed)) < ROUNDING);
    // A surrogate evaluates equal rows of features once.
    let once = surrogate.local_embedding(&data.geometries[0]).unwrap().concat();
    assert!(relative_difference(&once, &embed(&order)) < ROUNDING);
}

#[test]
fn a_batch_is_its_members() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    let surrogate = briefly_trained(&data, &config, &devices()[0]);
    let fixed = surrogate.fixed_geometry(&data.geometries[0]).unwrap();
    let thetas: Vec<Vec<f64>> =
        thetas(700).iter().map(|theta| theta.to_vec()).chain([vec![3.0, 1.0]]).collect();
    let batch = fixed.predict(&thetas).unwrap(); // 701 × 28 nodes: more than one chunk
    for set in [0, 350, 699, 700] {
        let single = fixed.predict(&thetas[set..=set]).unwrap();
        assert!(relative_difference(&single[0], &batch[set]) < ROUNDING);
    }
    let one = |theta: Vec<f64>| fixed.predict(&[theta]);
    assert!(matches!(
        one(vec![1.0]),
        Err(Error::Coordinates(CoordinateError::Count { found: 1, expected: 2, .. }))
    ));
    assert!(matches!(
        one(vec![1.0, f64::NAN]),
        Err(Error::Coordinates(CoordinateError::NotFinite { .. }))
    ));
    assert!(matches!(one(vec![-1.0, 1.0]), Err(Error::Coordinates(CoordinateError::Parameter(_)))));
}

#[test]
fn sensitivities_are_the_derivatives_of_predictions() {
    let (_, data) = plane_data();
    for activation in [Activation::Celu, Activation::Tanh] {
        let config = GraphNetworkConfig { activation, ..small_config(&data, 2) };
        for device in devices() {
            let surrogate = briefly_trained(&data, &config, &device);
            let fixed = surrogate.fixed_geometry(&data.geometries[0]).unwrap();
            let step = 5e-3; // single precision: rounding and truncation both stay near 1e-4
            for theta in [[0.8, 1.3], [1.7, 0.6]] {
                let exact = fixed.sensitivity(&theta).unwrap();
                assert_eq!(exact.len(), 2);
                for (parameter, derivative) in exact.iter().enumerate() {
                    let moved = |by: f64| {
                        let mut theta = theta.to_vec();
                        theta[parameter] += by;
                        fixed.predict(&[theta]).unwrap().concat()
                    };
                    let (ahead, behind) = (moved(step), moved(-step));
                    let finite: Vec<f64> =
                        ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect();
                    let difference = relative_difference(derivative, &finite);
                    assert!(difference < 5e-3, "parameter {parameter}: {difference:e}");
                }
            }
        }
    }
}

#[test]
fn a_stored_surrogate_predicts_the_same() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    let folder = tempfile::tempdir().unwrap();
    for device in devices() {
        let surrogate = briefly_trained(&data, &config, &device);
        let place = folder.path().join("surrogate");
        surrogate.save(&place).unwrap();
        let read = Surrogate::load(&place, &device).unwrap();
        let theta = [vec![0.9, 1.1]];
        let geometry = &read.geometries()[1];
        assert_eq!(
            surrogate.predict(geometry, &theta).unwrap(),
            read.predict(geometry, &theta).unwrap()
        );
        let path = place.join("surrogate.json");
        let text =
            std::fs::read_to_string(&path).unwrap().replacen("\"version\":4", "\"version\":9", 1);
        std::fs::write(&path, text).unwrap();
        assert!(matches!(Surrogate::load(&place, &device), Err(Error::Version { found: 9, .. })));
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(Surrogate::load(&place, &device), Err(Error::File { .. })));
    }
}

#[test]
fn misfits_are_refused() {
    let (body, data) = plane_data();
    let config = GraphNetworkConfig { node_features: 2, ..small_config(&data, 2) };
    let parameters = ParameterScaling::logarithmic(&[0.5, 0.5], &[2.0, 2.0]).unwrap();
    let output = OutputScale { mean: vec![0.0; 2], scale: vec![1.0; 2] };
    let scales = Scales::over(&data.geometries, parameters, output).unwrap();
    let device = &devices()[0];
    let refused = Surrogate::new(&config, &data, scales.clone(), 0, device);
    assert!(matches!(
        refused,
        Err(Error::Coordinates(CoordinateError::Count { found: 1, expected: 2, .. }))
    ));
    let mut still = scales.clone();
    still.output.scale[1] = 0.0;
    let config = small_config(&data, 2);
    assert!(matches!(
        Surrogate::new(&config, &data, still, 0, device),
        Err(Error::Coordinates(CoordinateError::Scale { .. }))
    ));
    let surrogate = Surrogate::new(&config, &data, scales, 0, device).unwrap();
    let other = plane_cantilever(50.0).geometry(vec![1.0], |x| x);
    assert!(matches!(
        surrogate.fixed_geometry(&other),
        Err(Error::Coordinates(CoordinateError::Count { found: 1, expected: 2, .. }))
    ));
    let mut broken = body.geometry(vec![40.0, 10.0], |x| x);
    broken.features.nodes.values[3] = f64::NAN;
    assert!(matches!(
        surrogate.fixed_geometry(&broken),
        Err(Error::Coordinates(CoordinateError::NotFinite { index: 3, .. }))
    ));
}

#[test]
fn a_shape_number_that_is_always_the_same_is_no_input() {
    // The mean of three tenths is off by its rounding, which is no spread to measure others by.
    let body = plane_cantilever(40.0);
    let geometries: Vec<Geometry> = (0..3).map(|_| body.geometry(vec![0.1], |x| x)).collect();
    let parameters = ParameterScaling::logarithmic(&[0.5], &[2.0]).unwrap();
    let output = OutputScale { mean: vec![0.0; 2], scale: vec![1.0; 2] };
    let scales = Scales::over(&geometries, parameters, output).unwrap();
    assert_eq!(scales.global.scale, [1.0]);
}
