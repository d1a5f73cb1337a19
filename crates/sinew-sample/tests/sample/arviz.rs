//! Diagnostics against those of `arviz` (`fixtures/chains`), and files that it opens.

use serde::Deserialize;
use sinew_sample::{
    ArvizDict, Chains, Laplace, LogDensity, NutsOptions, ess_bulk, ess_tail, nuts, nuts_from, psis,
    r_hat, write_csv,
};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rounding of sums of a few hundred terms in another order, far below what decides anything.
const SAME: f64 = 1e-8;

#[derive(Deserialize)]
struct Fixture {
    chains: Vec<Stored>,
    weights: Vec<Weights>,
}

#[derive(Deserialize)]
struct Stored {
    name: String,
    draws: Vec<Vec<f64>>,
    r_hat: Option<f64>,
    ess_bulk: f64,
    ess_tail: f64,
}

#[derive(Deserialize)]
struct Weights {
    logs: Vec<f64>,
    efficiency: f64,
    smoothed: Vec<f64>,
    k_hat: f64,
}

fn fixture() -> Fixture {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/chains/diagnostics.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= SAME * expected.abs()
}

#[test]
fn mixing_is_that_of_arviz() {
    let chains = fixture().chains;
    assert_eq!(chains.len(), 8);
    for stored in chains {
        let (name, draws) = (&stored.name, &stored.draws);
        match stored.r_hat {
            Some(expected) => assert!(close(r_hat(draws), expected), "{name}: {}", r_hat(draws)),
            None => assert!(r_hat(draws).is_nan(), "{name}"),
        }
        assert!(close(ess_bulk(draws), stored.ess_bulk), "{name}: bulk {}", ess_bulk(draws));
        assert!(close(ess_tail(draws), stored.ess_tail), "{name}: tail {}", ess_tail(draws));
    }
}

#[test]
fn weights_are_smoothed_as_by_arviz() {
    let weights = fixture().weights;
    assert_eq!(weights.len(), 4);
    for stored in weights {
        let found = psis(&stored.logs, stored.efficiency);
        assert!(close(found.k_hat, stored.k_hat), "{} {}", found.k_hat, stored.k_hat);
        for (found, expected) in found.log_weights.iter().zip(&stored.smoothed) {
            assert!(close(*found, *expected), "{found} {expected}");
        }
    }
}

/// Normal with correlation .9 and standard deviations 1 and 3, restricted to x > −1.
struct Cut;

impl LogDensity for Cut {
    fn dimension(&self) -> usize {
        2
    }

    fn value_and_gradient(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let (a, b) = (x[0], x[1] / 3.0);
        let scale = 1.0 / (1.0 - 0.81);
        gradient[0] = -scale * (a - 0.9 * b);
        gradient[1] = -scale * (b - 0.9 * a) / 3.0;
        if a <= -3.0 { f64::NEG_INFINITY } else { -0.5 * scale * (a * a + b * b - 1.8 * a * b) }
    }
}

fn draws_on(threads: usize) -> Chains {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let options = NutsOptions { draws: 500, seed: 7, ..NutsOptions::default() };
    pool.install(|| nuts(&Cut, &Laplace::at(&Cut, &[0.0, 0.0]).unwrap(), &options).unwrap())
}

#[test]
fn one_and_two_threads_draw_the_same() {
    let chains = draws_on(1);
    assert_eq!(chains, draws_on(2));
    let found = chains.summary(1);
    // Four Monte Carlo standard errors of a mean over more than 1000 effective draws; the cut takes .1 % of the mass.
    assert!(found.ess_bulk > 1000.0 && found.r_hat < 1.01, "{found:?}");
    assert!(found.mean.abs() < 0.4 && (found.deviation - 3.0).abs() < 0.3, "{found:?}");
}

#[test]
fn a_caller_hears_of_every_step_and_ends_the_chains() {
    let about = Laplace::at(&Cut, &[0.0, 0.0]).unwrap();
    let options = NutsOptions { chains: 2, warmup: 30, draws: 20, seed: 3 };
    let heard = AtomicUsize::new(0);
    let hear = |most: usize| match heard.fetch_add(1, Ordering::Relaxed) + 1 < most {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let drawn = nuts_from(&Cut, &about, &[], &options, &|| hear(usize::MAX)).unwrap();
    assert_eq!((drawn.pooled().count(), heard.swap(0, Ordering::Relaxed)), (40, 100));
    let error = nuts_from(&Cut, &about, &[], &options, &|| hear(10)).unwrap_err().to_string();
    assert!(error.contains("interrupted"), "{error}");
    // Both chains end at the break or just after it.
    assert!(heard.into_inner() <= 11);
}

#[test]
fn no_maximum_is_an_error() {
    struct Saddle;
    impl LogDensity for Saddle {
        fn dimension(&self) -> usize {
            1
        }
        fn value_and_gradient(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            gradient[0] = x[0];
            0.5 * x[0] * x[0]
        }
    }
    let refused = Laplace::at(&Saddle, &[0.0]).unwrap_err().to_string();
    assert!(refused.contains("not positive definite"), "{refused}");
}

#[test]
fn files_hold_every_draw_once() {
    let folder = tempfile::tempdir().unwrap();
    let chains = vec![vec![1.0, 2.5], vec![3.0, 1e-300]];
    let path = folder.path().join("posterior.csv");
    write_csv(&path, &[("a [kPa]".into(), chains.clone())]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(rows[..3], ["chain,draw,a [kPa]", "0,0,1", "0,1,2.5"]);
    let last = rows[4].rsplit(',').next().unwrap();
    assert_eq!((rows.len(), last.parse::<f64>().unwrap()), (5, 1e-300));
    let uneven = [("a".to_string(), chains.clone()), ("b".to_string(), vec![vec![1.0]])];
    assert!(write_csv(&path, &uneven).unwrap_err().to_string().contains("draws of b: 1"));
    let dict = ArvizDict::default().with("posterior", "a", chains);
    // Names keep their order; one that comes again takes the place of the earlier one.
    let dict = dict.with_observed("V 2", 1.0).with_observed("V 10", 7.0).with_observed("V 2", 1.0);
    let dict = dict.with_observed("V 10", 120.0);
    assert_eq!(
        dict.to_json(),
        r#"{"observed_data":{"V 2":1.0,"V 10":120.0},"posterior":{"a":[[1.0,2.5],[3.0,1e-300]]}}"#
    );
    // The form of arviz' `coords` and `dims`.
    let labels = ["V 2", "V 10"].map(String::from).to_vec();
    assert_eq!(
        ArvizDict::default().with_log_likelihood(labels, vec![vec![vec![-0.5, -2.0]]]).to_json(),
        r#"{"coords":{"datum":["V 2","V 10"]},"dims":{"data":["datum"]},"log_likelihood":{"data":[[[-0.5,-2.0]]]}}"#
    );
}
