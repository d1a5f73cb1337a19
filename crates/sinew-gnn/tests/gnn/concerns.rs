//! Losses that raise concern about a training, and those that do not.

use crate::common::*;
use burn::tensor::Tensor;
use sinew_gnn::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Steps between evaluations.
const STEPS: usize = 2;

/// Losses that are told beforehand: those of the steps, that of zero outputs, and that of all samples with the weights of an
/// evaluation.
struct Scripted {
    of_steps: Vec<f64>,
    of_zero_output: f64,
    of_all_samples: f64,
    steps: AtomicUsize,
    others: AtomicUsize,
}

impl Objective for Scripted {
    fn check(&self, _: &DataSet) -> Result<()> {
        Ok(())
    }

    fn loss(&self, _: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let next = |counter: &AtomicUsize| counter.fetch_add(1, Ordering::Relaxed);
        let loss = match displacement.is_autodiff() {
            true => self.of_steps[next(&self.steps)],
            // Zero outputs come first.
            false if next(&self.others) == 0 => self.of_zero_output,
            false => self.of_all_samples,
        };
        Ok(displacement.sum() * 0.0 + loss)
    }
}

/// Concerns of the latest evaluation.
#[derive(Default)]
struct Listener(Vec<Concern>);

impl TrainingObserver for Listener {
    fn evaluate(&mut self, _: &Surrogate, _: &HistoryPoint) -> sinew_gnn::Result<Option<f64>> {
        self.0.clear();
        Ok(None)
    }

    fn concern(&mut self, concern: &Concern) {
        self.0.push(*concern);
    }
}

/// Concerns of the last evaluation, by means of losses that are uncertain by 0.01, and of the whole run, by the loss of all
/// samples.
fn concerns(means: &[f64], of_zero_output: f64, of_all_samples: f64) -> [Option<Concern>; 2] {
    // Two numbers this far on both sides of their mean give it that deviation.
    let spread = 0.01 * 2f64.sqrt();
    let data = one_sample();
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    let objective = Scripted {
        of_steps: means.iter().flat_map(|mean| [mean - spread, mean + spread]).collect(),
        of_zero_output,
        of_all_samples,
        steps: AtomicUsize::new(0),
        others: AtomicUsize::new(0),
    };
    let config = TrainingConfig {
        budget: TrainingBudget::Steps(STEPS * means.len()),
        evaluations: means.len(),
        batch: 1,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate, data, Box::new(objective), config).unwrap();
    let mut listener = Listener::default();
    let report = trainer.run(&mut listener).unwrap();
    assert_eq!(report.history.len(), means.len());
    [listener.0, report.concerns].map(|concerns| {
        assert!(concerns.len() < 2, "{concerns:?}");
        concerns.first().copied()
    })
}

/// Losses are told in single precision.
fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn losses_are_judged_against_those_of_a_network_without_outputs() {
    assert_eq!(concerns(&[0.9, 0.6, 0.3, 0.1], 1.0, 0.1), [None; 2]);
    // Energies are negative; a rise within the noise of batches does not count.
    assert_eq!(concerns(&[-0.2, -0.5, -0.8, -0.78], 0.0, -0.78), [None; 2]);
    for concern in concerns(&[0.5, 0.5, 0.5, 2.0], 1.0, 2.0) {
        let Some(Concern::NothingLearned { loss, of_zero_output }) = concern else {
            panic!("{concern:?}")
        };
        assert!(is_near(loss, 2.0) && is_near(of_zero_output, 1.0), "{concern:?}");
    }
    for concern in concerns(&[-0.2, -0.5, -0.8, -0.3], 0.0, -0.3) {
        let Some(Concern::LossRose { lowest, step, loss }) = concern else { panic!("{concern:?}") };
        assert!(is_near(lowest, -0.8) && is_near(loss, -0.3), "{concern:?}");
        assert_eq!(step, 3 * STEPS);
    }
    assert_eq!(concerns(&[0.5, 0.5, 0.5, 2.0], f64::INFINITY, 2.0), [None; 2]);
}

#[test]
fn noise_of_batches_raises_no_concern_but_the_loss_of_all_samples_has_none() {
    // About a solution, one displacement for all parameters is a good one, and batches differ by more than it lacks.
    let [noisy, exact] = concerns(&[-0.990, -0.995, -1.004, -0.985], -0.995, -0.996);
    assert_eq!((noisy, exact), (None, None));
    assert_eq!(concerns(&[-0.990, -0.995, -1.004, -0.998], -0.995, -0.998), [None; 2]);
    let [noisy, exact] = concerns(&[-0.990, -0.995, -1.004, -0.985], -0.995, -0.994);
    assert_eq!(noisy, None);
    let Some(Concern::NothingLearned { loss, of_zero_output }) = exact else { panic!("{exact:?}") };
    assert!(is_near(loss, -0.994) && is_near(of_zero_output, -0.995), "{exact:?}");
}

#[test]
fn without_evaluations_there_is_no_loss_to_judge() {
    let data = one_sample();
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    let objective = data_fit(&surrogate);
    let budget = TrainingBudget::Steps(3);
    let config = TrainingConfig { budget, evaluations: 0, batch: 1, ..TrainingConfig::default() };
    let report = Trainer::new(surrogate, data, objective, config).unwrap().run(&mut ()).unwrap();
    assert_eq!((report.history, report.concerns), (vec![], vec![]));
}
