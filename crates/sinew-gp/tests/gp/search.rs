//! The search for the most probable parameters, on evidences whose maximum is known.

use sinew_gp::{
    Data, Domain, Evidence, Formula, GpError, Hyperparameter, Measure, Model, Noise, Operator,
    Prior, Problem, Series,
};
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// A number whose logarithm is within these bounds.
fn within(name: &'static str, [lower, upper]: [f64; 2]) -> Hyperparameter {
    let measure = Measure::Number { lower: lower.exp(), upper: upper.exp() };
    Hyperparameter { name, measure }
}

/// Exact values of one at 0, 1, …, whose variances a kernel gives: with a variance v the logarithm of the probability of each is
/// −½ (ln v + 1/v + ln 2π), and that of the amplitude −½ ln² of it.
fn ones(count: usize, kernel: &Formula<1>) -> Model<1> {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let problem = must(Problem::new(domain, Operator::identity()));
    let places: Vec<[f64; 1]> = (0..count).map(|k| [k as f64]).collect();
    let data = Data::new().values(&places, &vec![1.0; count], Noise::Exact);
    must(Model::new(must(Prior::unconstrained(&problem, kernel)), data, Evidence::Joint))
}

/// Variances exp(2 − 2p) and exp(10q − 10p²) of two independent values, p and q the logarithms of the hyperparameters: for the
/// amplitude one a valley like Rosenbrock's, with its end at p = q = 1.
fn valley(highest: f64) -> Model<1> {
    let known = vec![within("p", [-5.0, highest]), within("q", [-5.0, 5.0])];
    let variance = |h: &[Series], x: &[Series; 1], y: &[Series; 1]| {
        let (p, q) = (h[0].ln(), h[1].ln());
        match (x[0].value(), y[0].value()) {
            (0.0, 0.0) => ((1.0 - p) * 2.0).exp(),
            (1.0, 1.0) => ((q - p.squared()) * 10.0).exp(),
            _ => x[0].constant(0.0),
        }
    };
    ones(2, &Formula::new("valley", known, variance))
}

#[test]
fn the_end_of_a_valley_is_found_and_so_is_that_of_its_part_within_bounds() {
    // Amplitude, p and q.
    let start = || vec![vec![0.0, -1.2, 1.0]];
    let free = must(valley(5.0).fit_from(start(), 200));
    let (found, top) = (free.outcome(), -(2.0 * PI).ln() - 1.0);
    for (x, exact) in found.parameters.iter().zip([0.0, 1.0, 1.0]) {
        assert!((x - exact).abs() < 1e-4, "{found:?}");
    }
    assert!(found.log_posterior > top - 1e-8, "{found:?} {top}");
    assert!(found.evaluations < 80, "{}", found.evaluations);

    let bound = must(valley(0.5).fit_from(start(), 200));
    let [amplitude, p, q] = bound.outcome().parameters[..] else { panic!("three parameters") };
    assert!((p - 0.5).abs() < 1e-12, "{p}");
    // Where the slopes in the other two vanish: 1 + ln a = exp(−1 − 2 ln a), and the second variance is one.
    assert!((1.0 + amplitude - (-1.0 - 2.0 * amplitude).exp()).abs() < 1e-5, "{amplitude}");
    assert!((q - 0.25 + 0.2 * amplitude).abs() < 1e-5, "{q}");
}

#[test]
fn steps_to_where_there_is_no_evidence_are_taken_back() {
    let without = Arc::new(AtomicUsize::new(0));
    let count = without.clone();
    // A variance p² of positive p, and none of others.
    let variance = move |h: &[Series], x: &[Series; 1], _: &[Series; 1]| {
        let p = h[0].ln();
        if p.value() > 0.0 {
            return p.squared();
        }
        count.fetch_add(1, Ordering::Relaxed);
        x[0].constant(f64::NAN)
    };
    let kernel = Formula::new("half-line", vec![within("p", [-10.0, 10.0])], variance);
    for start in [1e-3, 9.5] {
        let found = must(ones(1, &kernel).fit_from(vec![vec![0.0, start]], 100));
        let found = &found.outcome().parameters;
        assert!((found[1] - 1.0).abs() < 1e-4 && found[0].abs() < 1e-4, "{start}: {found:?}");
    }
    assert!(without.load(Ordering::Relaxed) > 0, "no step was too long");
    let error = ones(1, &kernel).fit_from(vec![vec![0.0, -1.0]], 100).unwrap_err();
    let GpError::Invalid(text) = &error else { panic!("{error}") };
    assert!(text.contains("none of 1 restarts reached a finite evidence"), "{text}");
}
