//! Evidences and covariances against dense algebra and formulas, whatever the number of data and threads.

use nalgebra::{DMatrix, DVector};
use sinew_gp::{
    Data, Derivative, Domain, Evaluation, Evidence, Formula, GpError, Model, Noise, Operator,
    Prior, Problem, Series, squared_exponential,
};
use std::f64::consts::PI;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// A process without conditions over a domain, of which data are known.
fn model<const D: usize>(domain: &Domain<D>, kernel: &Formula<D>, data: Data<D>) -> Model<D> {
    let problem = must(Problem::new(domain.clone(), Operator::identity()));
    must(Model::new(must(Prior::unconstrained(&problem, kernel)), data, Evidence::Joint))
}

/// A whole number of places at a distance of one, with values of a wave that have errors of variance 0.1.
fn line(count: usize, kernel: &Formula<1>) -> Model<1> {
    let domain = must(Domain::interval("x", [0.0, count as f64]));
    let places: Vec<[f64; 1]> = (0..count).map(|k| [k as f64]).collect();
    let y: Vec<f64> = (0..count).map(|k| (1.3 * k as f64).cos()).collect();
    model(&domain, kernel, Data::new().values(&places, &y, Noise::Known(0.1_f64.sqrt())))
}

#[test]
fn covariances_are_accurate_exponentials() {
    const COUNT: usize = 400;
    let domain = must(Domain::interval("x", [0.0, 45.0]));
    let share = |k: usize| (0.618_033_988_749_895 * k as f64).fract();
    let places: Vec<[f64; 1]> = (0..COUNT).map(|k| [45.0 * share(k)]).collect();
    let data = Data::new().values(&places, &[0.0; COUNT], Noise::Known(1.0));
    // Amplitude and lengthscale are one.
    let model = model(&domain, &squared_exponential(), data);
    let covariance = must(model.prior_covariance(&[0.0, 0.0]));
    let mut beyond = 0;
    for (row, [a]) in covariance.iter().zip(&places) {
        for (found, [b]) in row.iter().zip(&places) {
            let argument = -0.5 * (a - b) * (a - b);
            if argument < -708.0 {
                assert_eq!(*found, 0.0, "{argument}");
                beyond += 1;
                continue;
            }
            let exact = argument.exp();
            assert!((found - exact).abs() <= 4.5e-16 * exact, "{argument}: {found} {exact}");
        }
    }
    assert!(beyond > 1000, "{beyond}");
    assert!((0..COUNT).all(|k| covariance[k][k] == 1.0));
}

/// Evidence of a line with an amplitude of one and a lengthscale of three, its gradient in the logarithms of both, by dense algebra.
fn by_dense_algebra(covariance: &[Vec<f64>]) -> (f64, [f64; 2]) {
    let count = covariance.len();
    let prior = DMatrix::from_fn(count, count, |i, j| covariance[i][j]);
    let y = DVector::from_fn(count, |k, _| (1.3 * k as f64).cos());
    let noise = DMatrix::from_diagonal_element(count, count, 0.1_f64.sqrt().powi(2));
    let factor = (&prior + noise).cholesky().expect("positive definite");
    let weights = factor.solve(&y);
    let diagonal = factor.l_dirty().diagonal();
    let determinant: f64 = diagonal.iter().map(|l| l.ln()).sum();
    let value = -0.5 * y.dot(&weights) - determinant - 0.5 * count as f64 * (2.0 * PI).ln();
    let inverse = factor.inverse();
    let slope = |of: DMatrix<f64>| {
        0.5 * (weights.dot(&(&of * &weights)) - inverse.component_mul(&of).sum())
    };
    let stretched =
        DMatrix::from_fn(count, count, |i, j| prior[(i, j)] * (i.abs_diff(j) as f64 / 3.0).powi(2));
    (value, [slope(2.0 * &prior), slope(stretched)])
}

#[test]
fn evidence_is_that_of_dense_algebra_whatever_the_threads() {
    let on = |threads: usize, model: &Model<1>| -> Evaluation {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| must(model.evaluate(&[0.0, 3.0_f64.ln()])))
    };
    // Around the orders up to which factors and inverses are computed at once, and far above.
    for count in [1, 9, 64, 65, 130, 320, 321, 677] {
        let model = line(count, &squared_exponential());
        let found = on(1, &model);
        assert_eq!(found, on(2, &model), "{count}: the bits do not depend on the threads");
        let covariance = must(model.prior_covariance(&[0.0, 3.0_f64.ln()]));
        let (value, gradient) = by_dense_algebra(&covariance);
        // Rounding of sums of as many terms, times the condition of a covariance between 0.1 and 8.
        let bar = 1e-13 * (count as f64 + 10.0);
        assert!((found.value - value).abs() < bar, "{count}: {} {value}", found.value);
        for (found, exact) in found.gradient.iter().zip(gradient) {
            assert!((found - exact).abs() < bar, "{count}: {found} {exact}");
        }
    }
}

#[test]
fn indefinite_covariances_and_those_that_are_not_numbers_have_no_evidence() {
    const COUNT: usize = 330;
    for (place, value) in [(COUNT - 2, -1.0), (1, f64::NAN), (200, f64::INFINITY)] {
        let at = place as f64;
        let spoiled = move |_: &[Series], x: &[Series; 1], y: &[Series; 1]| {
            let ([x], [y]) = (x, y);
            match x.value() == at && y.value() == at {
                true => x.constant(value),
                false => (((x - y) / 3.0).squared() * -0.5).exp(),
            }
        };
        let model = line(COUNT, &Formula::new("spoiled", Vec::new(), spoiled));
        let error = model.log_evidence(&[0.0]).unwrap_err();
        let expected = GpError::NotPositiveDefinite { size: COUNT, jitter: 1e-4 };
        assert_eq!(error, expected, "{place} {value}");
    }
}

#[test]
fn the_closed_form_is_that_of_the_formula() {
    const PLACES: usize = 13;
    const LENGTHS: [f64; 2] = [0.6, 0.8];
    let domain = must(Domain::cuboid([("x", [-1.0, 1.0]), ("y", [-1.0, 1.0])]));
    let coordinate = |f: f64, k: usize| (f * k as f64).sin();
    let places: Vec<[f64; 2]> =
        (0..PLACES).map(|k| [coordinate(0.7, k), coordinate(1.9, k)]).collect();
    // Standard deviation of a derivative: ∂²ⁿ k where x = x′ is (2n − 1)!! / λ²ⁿ.
    let odd = |n: usize| -> f64 { (1..=n).map(|k| 2.0 * k as f64 - 1.0).product() };
    let deviation = |[a, b]: [usize; 2]| {
        (odd(a) * odd(b)).sqrt() / (LENGTHS[0].powi(a as i32) * LENGTHS[1].powi(b as i32))
    };
    let value = |k: usize| ((k * 7 + 3) % 11) as f64 / 11.0 - 0.4;
    let orders: Vec<[usize; 2]> =
        (0..25).map(|k| [k % 5, k / 5]).filter(|orders| orders[1] != 3).collect();
    let mut data = Data::new();
    for (k, own) in orders.iter().enumerate() {
        let (size, at) = (deviation(*own), &places[k % PLACES..][..1]);
        let derivative = Derivative { orders: *own };
        data = data.functional(derivative, at, &[size * value(k)], Noise::Known(size));
    }
    // All of them at once.
    let terms = orders.iter().map(|own| 1.0 / deviation(*own) * Derivative { orders: *own });
    let sum = terms.reduce(|sum, term| sum + term).expect("a term");
    let values: Vec<f64> = (0..PLACES).map(value).collect();
    let data = data.functional(sum, &places[..9], &values[..9], Noise::Known(10.0)).values(
        &places,
        &values,
        Noise::Known(1.0),
    );
    let kernel: Formula<2> = squared_exponential();
    let own = kernel.clone();
    let formula =
        Formula::new("by series", own.hyperparameters(), move |h, x, y| own.formula(h, x, y));
    let (closed, formula) =
        (model(&domain, &kernel, data.clone()), model(&domain, &formula.stationary(), data));
    let at = [0.0, LENGTHS[0].ln(), LENGTHS[1].ln()];
    let [own, series] = [&closed, &formula].map(|model| must(model.prior_covariance(&at)));
    for (i, j) in (0..own.len()).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let (a, b, scale) = (own[i][j], series[i][j], (series[i][i] * series[j][j]).sqrt());
        // Some thirty roundings of terms as large as the largest entry.
        assert!((a - b).abs() < 1e-11 * scale, "{i} {j}: {a} {b}");
    }
    let [own, series] = [&closed, &formula].map(|model| must(model.evaluate(&at)));
    assert!((own.value - series.value).abs() < 1e-11 * series.value.abs(), "{own:?} {series:?}");
    let scale = series.gradient.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
    for (a, b) in own.gradient.iter().zip(&series.gradient) {
        assert!((a - b).abs() < 1e-11 * scale, "{a} {b}");
    }
}
