//! Trainings that leave their best weights, and the way back.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::*;
use burn::tensor::Tensor;
use sinew_gnn::*;

/// Steps of a training, and between two evaluations.
const STEPS: usize = 60;
const BETWEEN: usize = 3;

/// Message passing is trained in a share of the steps, then embeddings or, with a frozen encoder, decoders alone.
fn config((embedding_share, frozen_encoder): (f64, bool)) -> TrainingConfig {
    TrainingConfig {
        schedule: Schedule::Constant,
        learning_rate: 1e-2,
        embedding_share,
        frozen_encoder,
        budget: TrainingBudget::Steps(STEPS),
        batch: 3,
        evaluations: STEPS / BETWEEN,
        ..TrainingConfig::default()
    }
}

fn trainer(data: &DataSet, config: TrainingConfig) -> Trainer {
    let surrogate = untrained(data, &small_config(data, 2), 1, &devices()[0]);
    let objective = data_fit(&surrogate);
    Trainer::new(surrogate, data.clone(), objective, config).unwrap()
}

fn resumed(place: &Path, data: &DataSet) -> Trainer {
    let objective = data_fit(trainer(data, config((1.0, false))).surrogate());
    Trainer::resume(place, data.clone(), objective, &devices()[0]).unwrap()
}

/// The checkpoint of a training that has learned for half of its steps.
fn learn(place: &Path, data: &DataSet, encoder: (f64, bool)) {
    let mut first = trainer(data, config(encoder));
    first.checkpoints = Some(place.into());
    first.run(&mut Judge::until(STEPS / 2, data)).unwrap();
}

/// A training that goes on from a checkpoint with steps of a size that no network bears. Its embeddings come to rest before or after
/// that.
fn reckless(place: &Path, data: &DataSet) -> Trainer {
    resumed(place, data).with_learning_rate(1.0)
}

/// Copies a folder with the folders in it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let (entry, is_folder) =
            entry.map(|e| (e.path(), e.file_type().unwrap().is_dir())).unwrap();
        let to = to.join(entry.file_name().unwrap());
        if is_folder {
            copy(&entry, &to);
        } else {
            std::fs::copy(&entry, &to).unwrap();
        }
    }
}

/// Root of the mean square of the relative error over the validation samples.
fn error(surrogate: &Surrogate, data: &DataSet) -> f64 {
    let squares: f64 = data
        .validation
        .iter()
        .map(|sample| {
            let geometry = &data.geometries[sample.geometry];
            let predicted = surrogate.predict(geometry, std::slice::from_ref(&sample.theta));
            predicted.map_or(f64::INFINITY, |predicted| {
                relative_difference(&sample.displacement, &predicted[0]).powi(2)
            })
        })
        .sum();
    (squares / data.validation.len() as f64).sqrt()
}

/// Tells errors, keeps them with losses, and breaks after a number of steps.
struct Judge<'a> {
    data: &'a DataSet,
    stop: usize,
    losses: Vec<f64>,
    errors: Vec<(usize, f64)>,
}

impl<'a> Judge<'a> {
    fn until(stop: usize, data: &'a DataSet) -> Self {
        Self { data, stop, losses: Vec::new(), errors: Vec::new() }
    }
}

impl TrainingObserver for Judge<'_> {
    fn progress(&mut self, progress: &TrainingProgress) -> ControlFlow<()> {
        self.losses.push(progress.loss);
        if progress.step == self.stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn evaluate(
        &mut self,
        surrogate: &Surrogate,
        point: &HistoryPoint,
    ) -> sinew_gnn::Result<Option<f64>> {
        let error = error(surrogate, self.data);
        self.errors.push((point.step, error));
        Ok(Some(error))
    }
}

#[test]
fn the_best_weights_are_kept_and_returned_to_with_smaller_steps() {
    let ((_, data), folder) = (plane_data(), tempfile::tempdir().unwrap());
    for encoder in [(1.0, false), (0.3, false), (0.52, false), (0.3, true), (0.52, true)] {
        let place = folder.path().join(format!("{encoder:?}"));
        learn(&place, &data, encoder);
        let mut trainer = reckless(&place, &data);
        let mut judge = Judge::until(usize::MAX, &data);
        let report = trainer.run(&mut judge).unwrap();
        println!("returned {} times; {:?}", report.returns, judge.errors);
        let kept = report.kept_error.unwrap();
        let (best, last) = (judge.errors.iter().map(|(_, error)| *error), judge.errors.last());
        assert!(best.fold(f64::INFINITY, f64::min) >= kept);
        assert_eq!(error(trainer.surrogate(), &data), kept);
        // What was learned was lost, and came back.
        let worst = judge.errors.iter().map(|(_, error)| *error).fold(0.0, f64::max);
        assert!(report.returns > 0 && worst > 3.0 * kept, "{worst} and {kept}");
        assert!(last.is_some_and(|(_, last)| *last < 3.0 * kept), "{last:?} and {kept}");
    }
}

/// Killed at an evaluation, between two, and after a return: the same numbers, and the same weights are kept.
#[test]
fn a_run_that_returned_to_its_best_weights_resumes_bit_for_bit() {
    let ((_, data), folder) = (plane_data(), tempfile::tempdir().unwrap());
    for encoder in [(1.0, false), (0.52, false), (0.52, true)] {
        let place = |name: &str| folder.path().join(format!("{name}-{encoder:?}"));
        let learned = place("learned");
        learn(&learned, &data, encoder);
        let whole = place("whole");
        copy(&learned, &whole);
        let mut uninterrupted = reckless(&whole, &data);
        let mut whole = Judge::until(usize::MAX, &data);
        let expected = uninterrupted.run(&mut whole).unwrap();
        assert!(expected.returns > 0);
        let half = STEPS / 2;
        for stop in [half + BETWEEN, half + BETWEEN + 1, STEPS - BETWEEN - 1] {
            let place = place(&stop.to_string());
            copy(&learned, &place);
            let mut first = Judge::until(stop, &data);
            let returns = reckless(&place, &data).run(&mut first).unwrap().returns;
            assert!(returns > 0 || stop < STEPS - 2 * BETWEEN, "the last one is after a return");
            let mut rest = resumed(&place, &data);
            let mut second = Judge::until(usize::MAX, &data);
            let report = rest.run(&mut second).unwrap();
            assert_eq!([first.losses, second.losses].concat(), whole.losses, "killed at {stop}");
            assert_eq!(
                (report.kept_step, report.kept_error, report.returns),
                (expected.kept_step, expected.kept_error, expected.returns)
            );
            let of = |trainer: &Trainer| error(trainer.surrogate(), &data).to_bits();
            assert_eq!(of(&rest), of(&uninterrupted));
        }
    }
}

/// A loss that is not finite in some of its calls.
struct Failing {
    fit: Box<dyn Objective>,
    calls: AtomicUsize,
    fails: fn(usize) -> bool,
}

impl Objective for Failing {
    fn check(&self, data: &DataSet) -> Result<()> {
        self.fit.check(data)
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let call = self.calls.fetch_add(1, Ordering::Relaxed) + 1;
        let loss = self.fit.loss(samples, displacement)?;
        Ok(if (self.fails)(call) { loss * f64::NAN } else { loss })
    }
}

#[test]
fn a_step_that_is_not_finite_goes_back_to_the_best_weights() {
    let (_, mut data) = plane_data();
    let held_out = data.clone();
    // Every call of the loss is then a step, in the first half of the run.
    data.validation.clear();
    let run = |fails: fn(usize) -> bool| {
        let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
        let objective = Failing { fit: data_fit(&surrogate), calls: AtomicUsize::new(0), fails };
        let (data, config) = (data.clone(), config((1.0, false)));
        let mut trainer = Trainer::new(surrogate, data, Box::new(objective), config).unwrap();
        trainer.run(&mut Judge::until(usize::MAX, &held_out))
    };
    let report = run(|call| call == 10).unwrap();
    assert_eq!((report.steps, report.returns), (STEPS, 1));
    // Before the first evaluation there is nothing to go back to, and what fails for ever ends.
    for (fails, at) in [((|call| call == 2) as fn(usize) -> bool, 2), (|call| call >= 10, 10)] {
        let failed = run(fails).unwrap_err();
        assert!(matches!(failed, Error::Diverged { step, .. } if step <= at), "{failed}");
        assert!(!failed.to_string().contains("learning rate of"), "{failed}");
    }
}

#[test]
fn a_loss_that_is_not_finite_changes_neither_weights_nor_the_history_of_an_optimiser() {
    let data = one_sample();
    for optimiser in [OptimiserConfig::default(), OptimiserConfig::adam()] {
        let losses = |fails: fn(usize) -> bool| -> Vec<Option<f64>> {
            let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
            let objective =
                Failing { fit: data_fit(&surrogate), calls: AtomicUsize::new(0), fails };
            let config = TrainingConfig { optimiser: optimiser.clone(), ..config((1.0, false)) };
            let mut trainer =
                Trainer::new(surrogate, data.clone(), Box::new(objective), config).unwrap();
            (0..5).map(|_| trainer.step().ok().map(|progress| progress.loss)).collect()
        };
        let (expected, found) = (losses(|_| false), losses(|call| call == 3));
        let [a, b, c, d, _] = expected[..] else { panic!("five steps") };
        assert_eq!(found, [a, b, None, c, d]);
    }
}
