//! False alarms of R̂ on independent draws, and weights at the edges of what can be judged.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_sample::{effective_share, psis, r_hat, standard_normals};

/// Share of 400 runs of four chains of independent draws whose largest R̂ of four parameters is above 1.01.
fn share_above(draws: usize) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut chains =
        || -> Vec<Vec<f64>> { (0..4).map(|_| standard_normals(draws / 4, &mut random)).collect() };
    let mut largest = || (0..4).map(|_| r_hat(&chains())).fold(0.0, f64::max);
    (0..400).filter(|_| largest() > 1.01).count() as f64 / 400.0
}

#[test]
fn r_hat_of_560_independent_draws_is_above_the_usual_limit_in_one_run_of_seven() {
    // 14.3 % of 1000 runs by numpy; three standard deviations of a share of 400 runs.
    let share = share_above(560);
    assert!((share - 0.143).abs() < 0.053, "{share}");
    assert!(share_above(1120) < 0.02);
}

#[test]
fn equal_weights_are_all_effective_and_one_weight_is_one() {
    assert_eq!(effective_share(&[-700.0; 8]), 1.0);
    assert_eq!(effective_share(&[0.0, f64::NEG_INFINITY]), 0.5);
    assert_eq!(effective_share(&[f64::NEG_INFINITY; 2]), 0.0);
}

#[test]
fn a_few_weights_are_not_judged() {
    assert_eq!(psis(&[0.0, 0.1, 0.2], 1.0).k_hat, f64::INFINITY);
}
