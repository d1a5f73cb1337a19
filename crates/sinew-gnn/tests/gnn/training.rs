//! Objectives, optimisers and the training loop.

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::common::*;
use burn::tensor::{Device, Tensor, TensorData};
use sinew_emulate::coordinates::*;
use sinew_gnn::*;
use sinew_graph::{FeatureMatrix, GraphFeatures};

fn settings(steps: usize) -> TrainingConfig {
    TrainingConfig {
        budget: TrainingBudget::Steps(steps),
        batch: 3,
        evaluations: 4,
        learning_rate: 1e-2,
        ..TrainingConfig::default()
    }
}

fn trainer(data: &DataSet, device: &Device, settings: TrainingConfig) -> Trainer {
    let surrogate = untrained(data, &small_config(data, 2), 1, device);
    let objective = data_fit(&surrogate);
    Trainer::new(surrogate, data.clone(), objective, settings).unwrap()
}

/// ½ k ‖u − u₀(θ)‖² with u₀ = θ₀ · pattern: minimised by a known field.
struct Springs {
    pattern: Vec<f64>,
}

impl Potential for Springs {
    fn degrees_of_freedom(&self) -> usize {
        self.pattern.len()
    }

    fn objection(&self, theta: &[f64]) -> Option<String> {
        (theta.len() != 2).then(|| format!("{} parameters", theta.len()))
    }

    fn value_and_gradient(&self, displacement: &[f64], theta: &[f64], gradient: &mut [f64]) -> f64 {
        let mut energy = 0.0;
        for ((g, u), p) in gradient.iter_mut().zip(displacement).zip(&self.pattern) {
            *g = theta[1] * (u - theta[0] * p);
            energy += 0.5 * *g * (u - theta[0] * p);
        }
        energy
    }
}

#[test]
fn every_optimiser_lowers_the_loss_on_every_backend() {
    let (_, data) = plane_data();
    let adam = OptimiserConfig::adam();
    for device in devices() {
        for optimiser in [OptimiserConfig::default(), adam.clone()] {
            let config = TrainingConfig { optimiser: optimiser.clone(), ..settings(80) };
            let mut trainer = trainer(&data, &device, config);
            let report = trainer.run(&mut ()).unwrap();
            let (first, last) = (report.history[0], report.history[3]);
            assert!(last.validation < first.validation, "{optimiser:?}: {:?}", report.history);
            assert!(last.loss < 0.3, "{optimiser:?}: {:?}", report.history);
            assert_eq!((report.steps, report.interrupted), (80, false));
        }
    }
}

#[test]
fn a_network_can_learn_a_tiny_problem_by_heart() {
    let (_, mut data) = plane_data();
    data.training.truncate(4);
    data.validation.clear(); // keep the last weights
    let mut trainer = trainer(&data, &devices()[0], TrainingConfig { batch: 2, ..settings(600) });
    trainer.run(&mut ()).unwrap();
    for sample in &data.training {
        let geometry = &data.geometries[sample.geometry];
        let prediction =
            trainer.surrogate().predict(geometry, std::slice::from_ref(&sample.theta)).unwrap();
        let difference = relative_difference(&clamped(&data, sample), &prediction[0]);
        assert!(difference < 0.03, "{difference}");
    }
}

/// The sample's field with the supports written over it.
fn clamped(data: &DataSet, sample: &Sample) -> Vec<f64> {
    let prescribed = &data.geometries[sample.geometry].dirichlet.prescribed;
    sample.displacement.iter().zip(prescribed).map(|(u, fixed)| fixed.unwrap_or(*u)).collect()
}

#[test]
fn the_same_seed_gives_the_same_numbers() {
    let (_, data) = plane_data();
    for device in devices() {
        let run = || {
            let mut trainer = trainer(&data, &device, settings(12));
            let report = trainer.run(&mut ()).unwrap();
            let theta = [vec![1.0, 1.0]];
            let field = trainer.surrogate().predict(&data.geometries[0], &theta).unwrap().concat();
            (
                report
                    .history
                    .iter()
                    .map(|point| (point.loss, point.validation))
                    .collect::<Vec<_>>(),
                field,
            )
        };
        assert_eq!(run(), run());
    }
}

/// Breaks after a number of steps and remembers the losses.
struct StopAfter {
    steps: usize,
    losses: Vec<f64>,
}

impl TrainingObserver for StopAfter {
    fn progress(&mut self, progress: &TrainingProgress) -> ControlFlow<()> {
        self.losses.push(progress.loss);
        if progress.step == self.steps { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn a_resumed_run_continues_bit_for_bit() {
    let (_, data) = plane_data();
    let folder = tempfile::tempdir().unwrap();
    for device in devices() {
        for (optimiser, embedding_share, frozen_encoder) in [
            (OptimiserConfig::default(), 1.0, false),
            (OptimiserConfig::adam(), 1.0, false),
            // The embeddings rest from the eighth step on, before the kill; and from the fifteenth, after it.
            (OptimiserConfig::default(), 0.35, false),
            (OptimiserConfig::default(), 0.7, false),
            (OptimiserConfig::default(), 0.35, true),
            (OptimiserConfig::default(), 0.7, true),
        ] {
            let config =
                TrainingConfig { optimiser, embedding_share, frozen_encoder, ..settings(20) };
            let mut whole = StopAfter { steps: usize::MAX, losses: vec![] };
            let mut uninterrupted = trainer(&data, &device, config.clone());
            uninterrupted.run(&mut whole).unwrap();

            let place = folder.path().join("checkpoint");
            let mut first = StopAfter { steps: 10, losses: vec![] };
            let mut killed = trainer(&data, &device, config);
            killed.checkpoints = Some(place.clone());
            assert!(killed.run(&mut first).unwrap().interrupted);
            drop(killed);

            let objective = data_fit(uninterrupted.surrogate());
            let mut resumed = Trainer::resume(&place, data.clone(), objective, &device).unwrap();
            let mut second = StopAfter { steps: usize::MAX, losses: vec![] };
            let report = resumed.run(&mut second).unwrap();
            assert_eq!(report.steps, 20);
            assert_eq!(whole.losses, [first.losses, second.losses].concat());
            let predict = |trainer: &Trainer| {
                trainer.surrogate().predict(&data.geometries[1], &[vec![0.7, 1.9]]).unwrap()
            };
            assert_eq!(predict(&uninterrupted), predict(&resumed));
            // A checkpoint is also a surrogate.
            Surrogate::load(&place, &device).unwrap();
        }
    }
}

#[test]
fn embeddings_leave_message_passing_and_are_trained_themselves() {
    let (_, data) = plane_data();
    let device = &devices()[0];
    let passed = |surrogate: &Surrogate| {
        let features =
            surrogate.scales().features.standardise(&data.geometries[1].features).unwrap();
        let table = |matrix: &FeatureMatrix| {
            let values: Vec<f32> = matrix.values.iter().map(|&v| v as f32).collect();
            Tensor::<2>::from_data(TensorData::new(values, [matrix.rows, matrix.columns]), device)
        };
        let graph = Graph::new(&data.geometries[1].topology);
        let (nodes, edges) = (table(&features.nodes), table(&features.edges));
        surrogate.emulator().local_embedding(&graph, nodes, edges)[0].to_data()
    };
    let run_with = |embedding_share: f64, frozen_encoder: bool, stop: usize| {
        let config = TrainingConfig { embedding_share, frozen_encoder, ..settings(60) };
        let mut trainer = trainer(&data, device, config);
        let report = trainer.run(&mut StopAfter { steps: stop, losses: vec![] }).unwrap();
        (report, trainer.current_surrogate())
    };
    let run = |embedding_share: f64, stop: usize| run_with(embedding_share, false, stop);
    let untrained = trainer(&data, device, settings(1)).into_surrogate();
    let (report, never) = run(0.0, 60);
    assert_eq!(passed(&never), passed(&untrained));
    let history = &report.history;
    let falls = history.windows(2).all(|pair| pair[1].validation < pair[0].validation);
    assert!(falls, "decoders and embeddings learn: {history:?}");

    let (_, half_way) = run(0.5, 30);
    let (_, finished) = run(0.5, 60);
    assert_ne!(passed(&half_way), passed(&untrained));
    assert_eq!(passed(&half_way), passed(&finished), "message passing rests");
    let (_, all) = run(1.0, 60);
    assert_ne!(passed(&all), passed(&finished));

    // A geometry trained on is predicted with its own embeddings, after a file and in other data too; one that was not is
    // predicted by message passing.
    let theta = [vec![0.7, 1.9]];
    let predict = |surrogate: &Surrogate| surrogate.predict(&data.geometries[1], &theta).unwrap();
    let unseen = finished.predict_unseen(&data.geometries[1], &theta).unwrap();
    assert_ne!(predict(&finished), unseen);
    assert_eq!(predict(&finished.transferred_to(&data).unwrap()), predict(&finished));
    let mut moved = data.clone();
    moved.geometries[0].features.edges.values[0] += 1e-3;
    assert_eq!(predict(&finished.transferred_to(&moved).unwrap()), unseen);
    let folder = tempfile::tempdir().unwrap();
    finished.save(folder.path()).unwrap();
    let loaded = Surrogate::load(folder.path(), device).unwrap();
    assert_eq!(predict(&loaded), predict(&finished));

    // A frozen encoder: message passing rests as well, the decoders go on learning, and a geometry trained on is no exception.
    let (report, frozen) = run_with(0.5, true, 60);
    assert_eq!(passed(&frozen), passed(&half_way));
    let validation = |step| {
        let at = report.history.iter().find(|point| point.step >= step).and_then(|p| p.validation);
        at.unwrap()
    };
    assert!(validation(60) < validation(30), "decoders learn: {:?}", report.history);
    let unseen = frozen.predict_unseen(&data.geometries[1], &theta).unwrap();
    assert_eq!(predict(&frozen), unseen);
}

#[test]
fn the_minimum_of_the_potential_is_found_without_data() {
    let body = plane_cantilever(40.0);
    let pattern = {
        let sample = body.sample(0, [1.0, 1.0], 1.0);
        let prescribed = body.rest().dirichlet.prescribed;
        let value = |(u, fixed): (&f64, &Option<f64>)| fixed.unwrap_or(*u);
        sample.displacement.iter().zip(&prescribed).map(value).collect::<Vec<f64>>()
    };
    let sample =
        |theta: [f64; 2]| Sample { geometry: 0, theta: theta.to_vec(), displacement: vec![] };
    let data = DataSet {
        geometries: vec![body.rest()],
        training: thetas(16).into_iter().map(sample).collect(),
        validation: vec![],
    };
    let potential = Arc::new(Springs { pattern: pattern.clone() });
    let energy =
        MinimumPotential::energy_of_linear_response(&*potential, &pattern, &[1.0, 1.0]).unwrap();
    let exact = 0.5 * pattern.iter().map(|p| p * p).sum::<f64>();
    assert!((energy / exact - 1.0).abs() < 1e-6);
    let objective = MinimumPotential::new(vec![potential], energy).unwrap();
    let mut longer = data.clone();
    longer.training[3].theta.push(1.0);
    assert!(matches!(objective.check(&longer), Err(Error::Parameters { sample: 3, .. })));
    let output = OutputScale::root_mean_square(2, [&pattern[..]]).unwrap();
    let parameters = ParameterScaling::logarithmic(&[0.5, 0.5], &[2.0, 2.0]).unwrap();
    let scales = Scales::over(&data.geometries, parameters, output).unwrap();
    let config = small_config(&data, 2);
    let surrogate = Surrogate::new(&config, &data, scales, 0, &devices()[0]).unwrap();
    let mut trainer =
        Trainer::new(surrogate, data.clone(), Box::new(objective), settings(400)).unwrap();
    trainer.run(&mut ()).unwrap();
    let prediction = trainer.surrogate().predict(&data.geometries[0], &[vec![1.2, 0.8]]).unwrap();
    let expected: Vec<f64> = pattern.iter().map(|p| 1.2 * p).collect();
    let difference = relative_difference(&expected, &prediction[0]);
    assert!(difference < 0.05, "{difference}");
}

#[test]
fn the_potential_enters_with_its_value_and_gradient() {
    let body = plane_cantilever(40.0);
    let springs = Arc::new(Springs { pattern: body.field(&[1.0, 1.0], 1.0) });
    let samples = [body.sample(0, [0.9, 1.1], 1.0), body.sample(0, [1.4, 0.6], 1.0)];
    let objective = MinimumPotential::new(vec![springs.clone()], 7.0).unwrap();
    for device in devices() {
        let device = device.autodiff();
        let values: Vec<f32> =
            (0..2 * springs.pattern.len()).map(|i| (i as f32 * 0.7).sin()).collect();
        let dims = [2, body.points.len(), 2];
        let u = Tensor::<3>::from_data(TensorData::new(values, dims), &device).require_grad();
        let loss = objective.loss(&[&samples[0], &samples[1]], u.clone()).unwrap();
        // The same energy in tensor operations.
        let pattern: Vec<f32> = springs.pattern.iter().map(|&p| p as f32).collect();
        let pattern = Tensor::<3>::from_data(TensorData::new(pattern, [1, dims[1], 2]), &device);
        let parameter = |i: usize| {
            let values: Vec<f32> = samples.iter().map(|sample| sample.theta[i] as f32).collect();
            Tensor::<3>::from_data(TensorData::new(values, [2, 1, 1]), &device)
        };
        let difference = u.clone() - pattern * parameter(0);
        let oracle = (difference.clone() * difference * parameter(1)).sum() * (0.5 / (2.0 * 7.0));
        let (value, expected) =
            (loss.clone().into_scalar::<f32>(), oracle.clone().into_scalar::<f32>());
        assert!((value / expected - 1.0).abs() < 1e-5);
        let gradient = |loss: Tensor<1>| {
            let data = u.grad(&loss.backward()).unwrap().into_data();
            data.iter::<f64>().collect::<Vec<f64>>()
        };
        assert!(relative_difference(&gradient(loss), &gradient(oracle)) < 1e-5);
    }
}

#[test]
fn divergence_is_reported_with_advice_and_keeps_the_weights() {
    let (_, data) = plane_data();
    struct Broken;
    impl Objective for Broken {
        fn check(&self, _: &DataSet) -> Result<()> {
            Ok(())
        }
        fn loss(&self, _: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
            Ok(displacement.sum() * f64::NAN)
        }
    }
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    let mut trainer = Trainer::new(surrogate, data.clone(), Box::new(Broken), settings(5)).unwrap();
    let error = trainer.run(&mut ()).unwrap_err();
    assert!(matches!(error, Error::Diverged { step: 1, .. }));
    let text = error.to_string();
    assert!(text.contains("step 1") && text.contains("narrow the ranges"), "{text}");
    let prediction = trainer.surrogate().predict(&data.geometries[0], &[vec![1.0, 1.0]]);
    assert!(prediction.is_ok());
}

#[test]
fn the_best_weights_on_the_validation_samples_are_kept() {
    let (_, data) = plane_data();
    // A rate far too high: the validation loss soon gets worse.
    let config = TrainingConfig {
        optimiser: OptimiserConfig::adam(),
        schedule: Schedule::Constant,
        learning_rate: 0.5,
        evaluations: 50,
        ..settings(100)
    };
    let mut trainer = trainer(&data, &devices()[0], config);
    let report = trainer.run(&mut ()).unwrap();
    let best = report
        .history
        .iter()
        .min_by(|a, b| a.validation.partial_cmp(&b.validation).unwrap())
        .unwrap();
    assert_eq!(report.kept_step, best.step);
    assert!(report.history.last().unwrap().validation > best.validation);
}

#[test]
fn a_time_budget_ends_in_time() {
    let (_, data) = plane_data();
    let config =
        TrainingConfig { budget: TrainingBudget::Seconds(1.5), evaluations: 3, ..settings(1) };
    let mut trainer = trainer(&data, &devices()[0], config);
    let report = trainer.run(&mut ()).unwrap();
    assert_eq!(report.history.len(), 3);
    assert!(report.seconds >= 1.5 && report.steps > 1);
    let last = report.history.last().unwrap();
    assert_eq!((last.step, last.seconds), (report.steps, report.seconds));
}

#[test]
fn data_that_cannot_be_trained_on_are_refused() {
    let (_, data) = plane_data();
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    let attempt = |change: &dyn Fn(&mut DataSet)| {
        let mut data = data.clone();
        change(&mut data);
        Trainer::new(surrogate.clone(), data, data_fit(&surrogate), settings(1)).err().unwrap()
    };
    assert!(matches!(attempt(&|data| data.training.clear()), Error::NothingToTrain(_)));
    for share in [-0.1, 1.1, f64::NAN] {
        let config = TrainingConfig { embedding_share: share, ..settings(1) };
        assert!(matches!(config.check(), Err(Error::EmbeddingShare(_))));
    }
    assert!(matches!(
        attempt(&|data| data.training[2].displacement.clear()),
        Error::Coordinates(CoordinateError::Count { .. })
    ));
    assert!(matches!(
        attempt(&|data| data.training[2].displacement[5] = f64::INFINITY),
        Error::Coordinates(CoordinateError::NotFinite { index: 5, .. })
    ));
    assert!(matches!(
        attempt(&|data| data.training[1].geometry = 2),
        Error::UnknownGeometry { sample: 1, .. }
    ));
    assert!(matches!(
        attempt(&|data| data.training[1].theta[0] = -1.0),
        Error::Coordinates(CoordinateError::Parameter(_))
    ));
}

#[test]
fn a_surrogate_of_other_meshes_is_refused() {
    let (_, data) = plane_data();
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    let objective = data_fit(&surrogate);
    let mesh = beam([2, 1, 1], vec![4]);
    let other = Body { dimensions: 2, ..mesh };
    let sample = |geometry: usize| other.sample(geometry, [1.0, 1.0], 1.0);
    let flat = || other.geometry(vec![40.0, 10.0], |x| [x[0], x[1], 0.0]);
    let geometries = vec![flat(), flat()];
    let data = DataSet { geometries, training: vec![sample(0), sample(1)], validation: vec![] };
    let refused = Trainer::new(surrogate, data, objective, settings(1)).err().unwrap();
    assert!(
        matches!(
            refused,
            Error::Coordinates(CoordinateError::Count { what: "nodes of a geometry", .. })
        ),
        "{refused}"
    );
}

/// Equal rows of features are evaluated once; features that differ by rounding are not.
#[test]
fn equal_features_have_the_gradients_of_different_ones() {
    let (_, data) = plane_data();
    let mut varied = data.clone();
    for GraphFeatures { nodes, edges } in varied.geometries.iter_mut().map(|g| &mut g.features) {
        for (i, x) in nodes.values.iter_mut().chain(&mut edges.values).enumerate() {
            *x += 1e-6 * (i as f64).sin();
        }
    }
    let [same, varied] = [data, varied].map(|data| {
        let config = TrainingConfig { optimiser: OptimiserConfig::adam(), ..settings(6) };
        let mut trainer = trainer(&data, &devices()[0], config);
        // Later ones differ by how roundings grow.
        let steps = (0..6).map(|_| trainer.step().unwrap());
        steps.map(|step| [step.loss, step.gradient_norm]).collect::<Vec<_>>()
    });
    for (same, varied) in same.as_flattened().iter().zip(varied.as_flattened()) {
        assert!((same / varied - 1.0).abs() < 1e-3, "{same} against {varied}");
    }
}
