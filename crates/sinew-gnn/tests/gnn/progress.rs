//! Learning rates, and the time that trainings tell.

use crate::common::*;
use sinew_gnn::*;

/// Peak of the learning rate: a power of two, so that its factors are told exactly.
const PEAK: f64 = 1.0 / 1024.0;

/// A training of a network on one sample.
fn trainer(config: TrainingConfig) -> Trainer {
    let data = one_sample();
    let sizes = GraphNetworkConfig { latent: 4, width: 8, steps: 1, ..small_config(&data, 2) };
    let surrogate = briefly_trained(&data, &sizes, &devices()[0]);
    let objective = data_fit(&surrogate);
    let config = TrainingConfig { learning_rate: PEAK, batch: 1, ..config };
    Trainer::new(surrogate, data, objective, config).unwrap()
}

fn with_budget(budget: TrainingBudget) -> TrainingConfig {
    TrainingConfig { budget, ..TrainingConfig::default() }
}

/// Factors of the first learning rates of a training of so many steps.
fn factors(steps: usize, count: usize) -> Vec<f64> {
    let mut trainer = trainer(with_budget(TrainingBudget::Steps(steps)));
    (0..count).map(|_| trainer.step().unwrap().learning_rate / PEAK).collect()
}

#[test]
fn the_cosine_rises_to_the_peak_and_falls_to_its_end() {
    let of_run = factors(1000, 1000);
    assert!(of_run[..50].windows(2).all(|pair| pair[0] < pair[1]));
    assert!(of_run[50..].windows(2).all(|pair| pair[0] > pair[1]));
    assert_eq!(of_run[50], 1.0);
    assert!((of_run[525] - 0.5005).abs() < 1e-12);
    assert!(of_run[999] < 1.01e-3);
    // A long run warms up for 200 steps only.
    let of_long = factors(1_000_000, 201);
    assert!(of_long[199] < 1.0);
    assert_eq!(of_long[200], 1.0);
}

#[test]
fn a_budget_of_steps_tells_the_time_left() {
    let mut trainer = trainer(with_budget(TrainingBudget::Steps(20)));
    for step in 1..=20 {
        let progress = trainer.step().unwrap();
        assert_eq!((progress.step, progress.steps), (step, 20));
        assert_eq!(progress.share, step as f64 / 20.0);
        let left = (20 - step) as f64 * progress.seconds / step as f64;
        assert!((progress.remaining_seconds - left).abs() <= 1e-12 * progress.seconds);
    }
}

#[test]
fn a_time_budget_estimates_its_steps() {
    const SECONDS: f64 = 0.2;
    let mut trainer = trainer(with_budget(TrainingBudget::Seconds(SECONDS)));
    loop {
        let progress = trainer.step().unwrap();
        let made = progress.step as f64;
        // Before the first step the pace is unknown: the warm-up takes its longest.
        assert!(progress.learning_rate <= PEAK);
        let estimate = (SECONDS / (progress.seconds / made)).max(made + 1.0);
        assert_eq!(progress.steps, estimate.round() as usize);
        assert_eq!(progress.share, (progress.seconds / SECONDS).min(1.0));
        assert_eq!(progress.remaining_seconds, (SECONDS - progress.seconds).max(0.0));
        if progress.share >= 1.0 {
            break;
        }
    }
}

/// Message passing ends with the first step that is its share of the estimated ones. Then the pace without it counts.
#[test]
fn shares_of_a_time_budget_are_shares_of_the_steps() {
    const SECONDS: f64 = 0.8;
    const SHARE: f64 = 0.25;
    /// Measures the pace without message passing.
    const PROBE: usize = 3;
    let budget = with_budget(TrainingBudget::Seconds(SECONDS));
    let mut trainer = trainer(TrainingConfig { embedding_share: SHARE, ..budget });
    let geometry = trainer.surrogate().geometries()[0].clone();
    let passed =
        |trainer: &Trainer| trainer.current_surrogate().local_embedding(&geometry).unwrap();
    let mut embedding = passed(&trainer);
    let mut told: Vec<TrainingProgress> = Vec::new();
    let mut rest: Option<TrainingProgress> = None;
    while told.last().is_none_or(|progress| progress.share < 1.0) {
        let progress = trainer.step().unwrap();
        let after = passed(&trainer);
        if after == embedding && progress.step != PROBE && rest.is_none() {
            rest = told.last().copied();
        }
        assert!(rest.is_none() || after == embedding, "message passing is trained again");
        embedding = after;
        if let Some(rest) = rest.filter(|rest| rest.step > PROBE) {
            let pace = (progress.seconds - rest.seconds) / (progress.step - rest.step) as f64;
            let made = progress.step as f64;
            let estimate = (made + (SECONDS - progress.seconds) / pace).max(made + 1.0);
            assert_eq!(progress.steps, estimate.round() as usize);
        }
        told.push(progress);
    }
    // The estimates are told as whole numbers.
    let is_due = |progress: &TrainingProgress, rounding: f64| {
        progress.step as f64 >= SHARE * (progress.steps as f64 + rounding)
    };
    let rest = rest.expect("message passing ends");
    if rest.step <= PROBE {
        return; // a machine so slow that the probe may have been the first step of the rest
    }
    assert!(is_due(&rest, -0.5), "{rest:?}");
    let before = told.iter().take_while(|progress| progress.step < rest.step);
    for progress in before {
        assert!(!is_due(progress, 0.5), "{progress:?}");
    }
}
