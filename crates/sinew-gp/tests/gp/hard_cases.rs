//! Limits of inference: the right answer, or an error that says what to do.

use sinew_gp::{
    Condition, Data, Domain, Evidence, Fit, FitOptions, Formula, Functional, GpError,
    Hyperparameter, Measure, Model, Noise, Parameter, Prior, Problem, Series, Side, Smoothness,
    constant, linear, matern, periodic, squared_exponential,
};
use std::f64::consts::PI;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that an error says what is expected of it.
#[track_caller]
fn says(error: &GpError, text: &str) {
    assert!(error.to_string().contains(text), "{error}");
}

/// κ u″ = −f on [0, length] with u = 0 at both ends.
fn string(length: f64, bounds: Option<[f64; 2]>) -> Problem<1> {
    let domain = must(Domain::interval("x", [0.0, length]));
    let [dx] = domain.derivatives();
    let equation = match bounds {
        Some(bounds) => -(&must(Parameter::new("stiffness", bounds)) * dx * dx),
        None => -2.0 * (dx * dx),
    };
    let held = || Condition::Dirichlet(constant(0.0));
    must(
        Problem::new(domain, equation)
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held())),
    )
}

/// Under the load sin πx, with stiffness 2.
fn deflection(x: f64) -> f64 {
    (PI * x).sin() / (2.0 * PI * PI)
}

fn prior<const D: usize>(problem: &Problem<D>) -> Prior<D> {
    must(Prior::constrained(problem, &squared_exponential()))
}

/// `count` loads evenly along the string.
fn loads(count: usize) -> Data<1> {
    let at: Vec<[f64; 1]> = (0..count).map(|k| [(k as f64 + 0.5) / count as f64]).collect();
    let f: Vec<f64> = at.iter().map(|[x]| (PI * x).sin()).collect();
    Data::new().equation(&at, &f, Noise::Exact)
}

fn fit<const D: usize>(problem: &Problem<D>, data: Data<D>) -> Fit<D> {
    let model = must(Model::new(prior(problem), data, Evidence::Auto));
    must(model.fit(&FitOptions::default()))
}

fn middle(fit: &Fit<1>) -> f64 {
    must(must(fit.conditional()).mean(&[[0.5]]))[0]
}

#[test]
fn jitter_is_never_silent() {
    // Every load four times, exactly: the covariance has rank six.
    let problem = string(1.0, None);
    let data = (0..3).fold(loads(6), |data, _| {
        let at: Vec<[f64; 1]> = (0..6).map(|k| [(f64::from(k) + 0.5) / 6.0]).collect();
        let f: Vec<f64> = at.iter().map(|[x]| (PI * x).sin()).collect();
        data.equation(&at, &f, Noise::Exact)
    });
    let fit = fit(&problem, data);
    assert!((middle(&fit) - deflection(0.5)).abs() < 1e-4);
    let reported = fit.outcome().jitter;
    assert!(reported >= 1e-10, "{reported:e}");
    let at = &fit.outcome().parameters;
    assert_eq!(must(fit.model().evaluate(at)).jitter, reported);
    // Values that contradict each other without noise are refused; across groups, whose operators may
    // differ, they need more of it, or have no evidence to speak of.
    let contradiction = Data::new().values(&[[0.5], [0.5]], &[0.1, 0.2], Noise::Exact);
    let refused = Model::new(prior(&problem), contradiction, Evidence::Joint).unwrap_err();
    says(
        &refused,
        "values 0 and 1 of observation group 1 at (0.5) and (0.5) are noise-free and differ",
    );
    let one = |data: Data<1>, value| data.values(&[[0.5]], &[value], Noise::Exact);
    let data = one(one(Data::new(), 0.1), 0.2);
    let model = must(Model::new(prior(&problem), data, Evidence::Joint));
    let start: Vec<f64> = model.parameters().iter().map(|p| p.to_scale(p.start[0])).collect();
    match model.evaluate(&start) {
        Ok(evaluation) => assert!(evaluation.value < -1e3, "{evaluation:?}"),
        Err(error) => assert!(matches!(error, GpError::NotPositiveDefinite { .. }), "{error}"),
    }
}

#[test]
fn one_number_is_enough_to_compute_with() {
    let problem = string(1.0, None);
    // One load says little, but the answer is finite, positive and held at the ends.
    let one_load = fit(&problem, Data::new().equation(&[[0.5]], &[1.0], Noise::Exact));
    let conditional = must(one_load.conditional());
    let mean = must(conditional.mean(&[[0.0], [0.5], [1.0]]));
    assert_eq!([mean[0], mean[2]], [0.0, 0.0]);
    assert!(mean[1] > 0.0 && mean[1] < 1.0, "{mean:?}");
    let uncertain = must(conditional.predict(&[[0.5]])).standard_deviation[0];
    assert!(uncertain.is_finite() && uncertain > 0.0);
    // One value with noise to be learned.
    let value = deflection(0.5);
    let noisy = fit(&problem, Data::new().values(&[[0.5]], &[value], Noise::Learned));
    assert!(middle(&noisy).is_finite() && middle(&noisy).abs() <= 1.01 * value);
}

#[test]
fn stiffness_is_found_from_ten_times_off() {
    let problem = string(1.0, Some([0.01, 1000.0]));
    let places: Vec<[f64; 1]> = (1..9).map(|k| [f64::from(k) / 9.0]).collect();
    let y: Vec<f64> = places
        .iter()
        .enumerate()
        .map(|(k, [x])| deflection(*x) + 0.0005 * (3.7 * k as f64).sin())
        .collect();
    let data = loads(10).values(&places, &y, Noise::Learned);
    for factor in [0.1_f64, 10.0] {
        let model = must(Model::new(prior(&problem), data.clone(), Evidence::Auto));
        let position = must(model.position("stiffness"));
        let mut start: Vec<f64> = model
            .parameters()
            .iter()
            .map(|p| p.to_scale((p.start[0] * p.start[1]).sqrt()))
            .collect();
        start[position] = (2.0 * factor).ln();
        let found = must(model.fit_from(vec![start], 300));
        let stiffness = must(found.parameter("stiffness"));
        assert!((stiffness - 2.0).abs() < 0.05, "from {factor} × : {stiffness}");
    }
}

#[test]
fn lengthscales_may_end_at_their_bounds() {
    // A parabola is the limit of infinite lengthscales: x (1 − x) is the constrained feature itself.
    let problem = string(1.0, None);
    let at: Vec<[f64; 1]> = (0..8).map(|k| [(f64::from(k) + 0.5) / 8.0]).collect();
    let data = Data::new().equation(&at, &[4.0; 8], Noise::Exact);
    let model = must(Model::new(prior(&problem), data, Evidence::Joint));
    let ends: Vec<Vec<f64>> = (0..2)
        .map(|end| {
            let bound = |p: &sinew_gp::FreeParameter| p.to_scale(p.bounds[end]);
            model.parameters().iter().map(bound).collect()
        })
        .collect();
    for end in &ends {
        let evaluation = must(model.evaluate(end));
        assert!(evaluation.value.is_finite() && evaluation.gradient.iter().all(|g| g.is_finite()));
    }
    let fit = must(model.fit_from(ends, 200));
    let lengthscale = must(fit.parameter("lengthscale x 1"));
    let bound = fit.model().parameters()[must(fit.model().position("lengthscale x 1"))].bounds[1];
    assert!(lengthscale > 0.3 * bound, "{lengthscale} of {bound}");
    assert!((middle(&fit) - 0.25).abs() < 1e-6, "{}", middle(&fit));
}

#[test]
fn stiffness_keeps_its_value_in_any_unit() {
    // Lengths in units of 1e±6, deflections in others: κ stays, for loads are given per length².
    let fitted = |length: f64, size: f64| {
        let problem = string(length, Some([0.05, 50.0]));
        let at: Vec<[f64; 1]> = (0..10).map(|k| [length * (f64::from(k) + 0.5) / 10.0]).collect();
        let load = |[x]: &[f64; 1]| (PI * x / length).sin() * size / (length * length);
        let f: Vec<f64> = at.iter().map(load).collect();
        let places: Vec<[f64; 1]> = (1..9).map(|k| [length * f64::from(k) / 9.0]).collect();
        let error = |k: usize| 0.0005 * (3.7 * k as f64).sin();
        let y: Vec<f64> = places
            .iter()
            .enumerate()
            .map(|(k, [x])| size * (deflection(x / length) + error(k)))
            .collect();
        let data = Data::new().equation(&at, &f, Noise::Exact).values(&places, &y, Noise::Learned);
        must(fit(&problem, data).parameter("stiffness"))
    };
    let reference = fitted(1.0, 1.0);
    assert!((reference - 2.0).abs() < 0.05, "{reference}");
    for (length, size) in [(1e6, 1.0), (1e-6, 1.0), (1.0, 1e6), (1.0, 1e-6), (1e6, 1e-6)] {
        let stiffness = fitted(length, size);
        assert!((stiffness - reference).abs() < 1e-3, "{length} {size}: {stiffness} {reference}");
    }
}

#[test]
fn corners_that_point_inwards_are_refused() {
    let notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let refused = Domain::polygon(["x", "y"], &notched).unwrap_err();
    says(&refused, "its corner (1, 1) is re-entrant");
    says(&refused, "take a convex domain around yours");
}

#[test]
fn what_is_not_a_number_is_named() {
    let problem = string(1.0, None);
    let new = |data: Data<1>| Model::new(prior(&problem), data, Evidence::Auto).map(|_| ());
    for bad in [f64::NAN, f64::INFINITY] {
        let value = new(loads(3).values(&[[0.2], [0.4]], &[0.1, bad], Noise::Learned)).unwrap_err();
        says(&value, "value number 1 of observation group 2");
        let point = new(loads(3).values(&[[bad]], &[0.1], Noise::Learned)).unwrap_err();
        says(&point, "point number 0 of observation group 2");
        let noise = new(loads(3).values(&[[0.2]], &[0.1], Noise::Known(bad))).unwrap_err();
        says(&noise, "noise of standard deviation");
    }
    let parameters = must(Model::new(prior(&problem), loads(3), Evidence::Auto));
    let count = parameters.parameters().len();
    assert!(parameters.evaluate(&vec![f64::NAN; count]).is_err());
    says(&parameters.evaluate(&[]).unwrap_err(), "0 parameters given");
}

#[test]
fn like_kernels_in_a_sum_have_names_of_their_own() {
    let part = || squared_exponential().scaled();
    let prior = must(Prior::constrained(&string(1.0, None), &(part() + part())));
    let model = must(Model::new(prior, loads(3), Evidence::Auto));
    let mut names: Vec<&str> = model.parameters().iter().map(|p| p.name.as_str()).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count, "{names:?}");
    assert!(must(model.position("lengthscale x 1 (2)")) > must(model.position("lengthscale x 1")));
    for period in [0.0, -1.0, f64::NAN] {
        says(&periodic::<1>(0, period).unwrap_err(), "a periodic kernel of period");
    }
}

#[test]
fn loads_alone_give_the_same_answer_in_any_unit_of_length() {
    let options = FitOptions { restarts: 2, iterations: 60, seed: 0, ..FitOptions::default() };
    let solved = |length: f64| {
        let beam = string(length, None);
        let at: Vec<[f64; 1]> = (1..10).map(|k| [length * f64::from(k) / 10.0]).collect();
        let f: Vec<f64> = at.iter().map(|[x]| (PI * x / length).sin() / length.powi(2)).collect();
        let beam = fit(&beam, Data::new().equation(&at, &f, Noise::Exact));
        let beam = must(must(beam.conditional()).mean(&[[0.55 * length]]))[0];

        let corners = [[0.0, 0.0], [length, 0.0], [length, length], [0.0, length]];
        let domain = must(Domain::polygon(["x", "y"], &corners));
        let [dx, dy] = domain.derivatives();
        let duct = Problem::new(domain.clone(), -(dx * dx) - dy * dy);
        let duct = must(duct.and_then(|p| p.boundary(constant(0.0))));
        let at = must(domain.sample(100, 1));
        let data = Data::new().equation(&at, &[length.powi(-2); 100], Noise::Exact);
        let duct = must(must(Model::new(prior(&duct), data, Evidence::Auto)).fit(&options));
        let duct = must(must(duct.conditional()).mean(&[[0.5 * length; 2]]))[0];
        [beam, duct]
    };
    let reference = solved(1.0);
    assert!((reference[0] / deflection(0.55) - 1.0).abs() < 1e-6, "{reference:?}");
    // By the series of sines.
    assert!((reference[1] / 0.073_671 - 1.0).abs() < 0.01, "{reference:?}");
    // As micrometres and kilometres would have a length of a metre.
    for length in [1e6, 1e-3] {
        let found = solved(length);
        for (found, reference) in found.iter().zip(reference) {
            // Where the optimiser stops, it no longer moves u by a millionth.
            assert!((found / reference - 1.0).abs() < 1e-6, "{length}: {found} {reference}");
        }
    }
}

#[test]
fn what_cannot_be_predicted_is_refused() {
    let problem = string(1.0, None);
    let [dx] = problem.domain().derivatives();
    let free = must(Prior::unconstrained(&problem, &squared_exponential()));
    let free = must(Model::new(free, loads(3), Evidence::Auto));
    let free = must(must(free.fit(&FitOptions::default())).conditional());
    for bad in [f64::NAN, f64::INFINITY] {
        let places = [[0.5], [bad]];
        let point = "point number 1 of the prediction";
        says(&free.predict(&places).unwrap_err(), point);
        says(&free.mean(&places).unwrap_err(), point);
        says(&free.sample(&places, 1, 0).unwrap_err(), point);
        let sum = |weights: &[f64]| {
            let (operator, points) = (dx.into(), vec![[0.2], [0.4]]);
            free.predict_functional(&Functional { operator, points, weights: weights.to_vec() })
        };
        says(&sum(&[1.0, bad]).unwrap_err(), "weight number 1 of the prediction");
        says(&sum(&[1.0; 3]).unwrap_err(), "2 points but 3 values");
        assert!(sum(&[1.0; 2]).is_ok());
    }
    // Draws of this kernel have two derivatives, whatever its formula says of four.
    let rough = must(Prior::constrained(&problem, &matern(Smoothness::Twice)));
    let rough = must(Model::new(rough, loads(5), Evidence::Auto));
    let rough = must(must(rough.fit(&FitOptions::default())).conditional());
    let bends = rough.predict_operator(&(dx * dx * dx).into(), &[[0.5]]).unwrap_err();
    says(&bends, "has 2 derivatives, the operator takes 3");
    assert!(rough.predict_operator(&(dx * dx).into(), &[[0.5]]).is_ok());
}

#[test]
fn coefficients_that_are_not_numbers_are_named() {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let [dx] = domain.derivatives();
    let undefined = must(Problem::new(domain.clone(), f64::NAN * (dx * dx)));
    let named = Model::new(prior(&undefined), loads(3), Evidence::Auto).unwrap_err();
    says(&named, "the coefficient of the operator has no finite value");
    for (value_factor, slope_factor) in [(f64::NAN, 1.0), (1.0, f64::INFINITY), (1.0, 0.0)] {
        let value_factor = constant(value_factor);
        let slope_factor = constant(slope_factor);
        let robin = Condition::Robin { value_factor, slope_factor, data: constant(0.0) };
        let problem = must(Problem::new(domain.clone(), dx * dx));
        let refused = problem.condition("x", Side::Lower, robin).unwrap_err();
        says(&refused, "the Robin condition on x = 0");
    }
    assert!(Domain::interval("x", [-1e308, 1e308]).is_err(), "its length overflows");
}

#[test]
fn starts_and_names_that_no_fit_can_use_are_refused() {
    let problem = string(1.0, None);
    let model = || must(Model::new(prior(&problem), loads(3), Evidence::Auto));
    let none = model().fit_from(Vec::new(), 10).unwrap_err();
    says(&none, "no starts are given");
    let expected = model().parameters().len();
    let long = model().fit_from(vec![vec![0.0; expected + 1]], 10).unwrap_err();
    says(&long, &format!("{} parameters given, the model has {expected}", expected + 1));

    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let [dx] = domain.derivatives();
    let clash = must(Parameter::new("amplitude 1", [0.1, 1.0]));
    let clash = must(Problem::new(domain, -(&clash * dx * dx)));
    let clash = Model::new(prior(&clash), loads(3), Evidence::Auto).unwrap_err();
    says(&clash, "parameter amplitude 1 has the name of an amplitude");

    // Bounds the wrong way round.
    let measure = Measure::Number { lower: 2.0, upper: 1.0 };
    let number = Hyperparameter { name: "number", measure };
    let bell = |h: &[Series], x: &[Series; 1], y: &[Series; 1]| {
        (-((&x[0] - &y[0]).squared() * &h[0])).exp()
    };
    let backwards = Formula::new("backwards", vec![number], bell);
    let backwards = Prior::constrained(&problem, &backwards).unwrap_err();
    says(&backwards, "hyperparameter number of the backwards kernel");
}

#[test]
fn kernels_along_axes_that_there_are_not_are_refused() {
    let problem = string(1.0, None);
    let elsewhere: [Formula<1>; 4] = [
        squared_exponential().along(&[1]),
        must(periodic(1, 2.0)),
        squared_exponential() + linear().along(&[0, 3]),
        matern(Smoothness::Thrice).along(&[2]),
    ];
    for kernel in &elsewhere {
        let refused = Prior::constrained(&problem, kernel).unwrap_err();
        says(&refused, "axis is not one of the domain's");
    }
    assert!(Prior::constrained(&problem, &squared_exponential().along(&[0])).is_ok());
}

#[test]
fn data_that_do_not_fit_together_are_refused() {
    let uneven = Data::new().values(&[[0.2]], &[0.1, 0.2], Noise::Known(0.1));
    let refused = Model::new(prior(&string(1.0, None)), uneven, Evidence::Auto).unwrap_err();
    says(&refused, "1 points but 2 values");
    let operator = sinew_gp::Operator::identity();
    let beyond = Functional { operator, points: vec![[0.5], [1.7]], weights: vec![0.5; 2] };
    let beyond = must(Data::new().integral(&beyond, 0.1, Noise::Known(0.1)));
    let refused = Model::new(prior(&string(1.0, None)), beyond, Evidence::Auto).unwrap_err();
    says(&refused, "(1.7) lies outside the domain");
}

#[test]
fn groups_that_determine_nothing_are_named() {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let free = must(Problem::new(domain, sinew_gp::Operator::identity()));
    let free = must(Prior::unconstrained(&free, &squared_exponential()));
    let new = |data: Data<1>| Model::new(free.clone(), data, Evidence::Joint).map(|_| ());
    let some = || Data::new().equation(&[[0.5]], &[1.0], Noise::Exact);
    says(&new(Data::new()).unwrap_err(), "no observations");
    let off = some().values(&[[1.0 + 1e-12], [3.5]], &[0.1, 0.2], Noise::Learned);
    says(&new(off).unwrap_err(), "point 1 of observation group 2 (3.5) lies outside");
    let empty = some().values(&[], &[], Noise::Learned);
    says(&new(empty).unwrap_err(), "observation group 2 has no points");
    assert_eq!(new(some().values(&[], &[], Noise::Known(0.1))), Ok(()));
    let at = [[0.0], [0.3], [-0.0]];
    let twice = |noise| some().values(&at, &[1.0, 1.0, 1.5], noise);
    let differ =
        "values 0 and 2 of observation group 2 at (0) and (-0) are noise-free and differ by 5e-1";
    says(&new(twice(Noise::Exact)).unwrap_err(), differ);
    assert_eq!(new(twice(Noise::Known(0.1))), Ok(()));
    assert_eq!(new(some().values(&at, &[1.0; 3], Noise::Exact)), Ok(()));
}
