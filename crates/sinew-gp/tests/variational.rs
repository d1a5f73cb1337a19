//! The variational bound for nonlinear equations.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter,
    Prior, Problem, SemiLinear, Series, Side, SquaredExponential, VariationalOptions, constant,
    field,
};
use std::f64::consts::{PI, TAU};
use std::time::Instant;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// That an error says what is expected of it.
#[track_caller]
fn says(error: &GpError, text: &str) {
    assert!(error.to_string().contains(text), "{error}");
}

/// A string on a bed: −u″ + `bed` u = f on [0, 1], held at both ends.
fn string(bed: f64) -> Problem<1> {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let [dx] = domain.derivatives();
    let held = || Condition::Dirichlet(constant(0.0));
    must(
        Problem::new(domain, -(dx * dx) + bed * Derivative::identity())
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held())),
    )
}

#[test]
fn of_a_linear_term_nothing_is_approximate() {
    let at: Vec<[f64; 1]> = (1..8).map(|k| [f64::from(k) / 8.0]).collect();
    let load: Vec<f64> = at.iter().map(|[x]| 3.0 * (4.0 * x).sin()).collect();
    let data = Data::new().equation(&at, &load, Noise::Known(0.05)).values(
        &at[1..4],
        &[0.3, 0.2, 0.25],
        Noise::Learned,
    );
    let kernel = SquaredExponential::new();
    let term = SemiLinear::new(string(0.0), [Derivative::identity()], |[u]| u * 4.0);
    let start = must(term.solve(&kernel, &data, &FitOptions::default(), 5));
    let found = must(term.variational(&start, &kernel, &data, &VariationalOptions::default()));
    assert!(found.settled);

    let prior = must(Prior::constrained(&string(4.0), &kernel));
    let model = must(Model::new(prior, data, Evidence::Joint));
    let evidence = must(model.log_evidence(&found.parameters));
    assert!((found.bound - evidence).abs() < 1e-6, "{} {evidence}", found.bound);
    // The parameters are its maximum, too.
    let best = must(must(model.fit_from(vec![found.parameters.clone()], 100)).posterior());
    let places = [[0.1], [0.45], [0.9]];
    let (exact, bound) = (must(best.predict(&places)), must(found.posterior().predict(&places)));
    for place in 0..places.len() {
        assert!((exact.mean[place] - bound.mean[place]).abs() < 1e-4 * exact.mean[1].abs());
        assert!(
            (exact.standard_deviation[place] / bound.standard_deviation[place] - 1.0).abs() < 1e-3
        );
    }
    println!("{:?}", found.trace);
}

/// What a normal prior and a likelihood make of some values, by weighing draws of the prior.
struct Weighed {
    log_evidence: f64,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    /// Number of draws that would be as good without weights.
    effective: f64,
}

/// Draws of N(0, `covariance`) weighed by `log_likelihood`; moments of the values from `first` on.
fn weighed(
    covariance: &[Vec<f64>],
    first: usize,
    log_likelihood: impl Fn(&[f64]) -> f64,
) -> Weighed {
    const DRAWS: usize = 1_000_000;
    let size = covariance.len();
    let mut root = vec![vec![0.0; size]; size];
    for i in 0..size {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| root[i][k] * root[j][k]).sum();
            let left: f64 = covariance[i][j] - sum;
            // Values that others determine, to rounding.
            let pivot = |left: f64| left.max(1e-12 * covariance[i][i]).sqrt();
            root[i][j] = if i == j { pivot(left) } else { left / root[j][j] };
        }
    }
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
        radius * (TAU * random.random::<f64>()).cos()
    };
    let (mut total, mut squares) = (0.0, 0.0);
    let (mut sums, mut products) = (vec![0.0; size - first], vec![0.0; size - first]);
    for _ in 0..DRAWS {
        let z: Vec<f64> = (0..size).map(|_| normal()).collect();
        let draw: Vec<f64> =
            root.iter().map(|row| row.iter().zip(&z).map(|(r, z)| r * z).sum()).collect();
        let weight = log_likelihood(&draw).exp();
        total += weight;
        squares += weight * weight;
        for ((sum, product), value) in sums.iter_mut().zip(&mut products).zip(&draw[first..]) {
            *sum += weight * value;
            *product += weight * value * value;
        }
    }
    let mean: Vec<f64> = sums.iter().map(|s| s / total).collect();
    let deviation = products.iter().zip(&mean).map(|(p, m)| (p / total - m * m).sqrt()).collect();
    Weighed {
        log_evidence: (total / DRAWS as f64).ln(),
        mean,
        deviation,
        effective: total * total / squares,
    }
}

#[test]
fn the_bound_is_below_the_evidence_and_the_bands_are_true() {
    // A stiffening bed, a load known roughly at three places, and one deflection.
    const NOISE: [f64; 2] = [6.0, 0.5];
    const CUBIC: f64 = 60.0;
    let at = [[0.25], [0.5], [0.75]];
    let load = [4.0, 9.0, 2.0];
    let seen = ([[0.4]], [0.6]);
    let data = Data::new().equation(&at, &load, Noise::Known(NOISE[0])).values(
        &seen.0,
        &seen.1,
        Noise::Known(NOISE[1]),
    );
    let kernel = SquaredExponential::new();
    let bed = SemiLinear::new(string(0.0), [Derivative::identity()], |[u]| u.powi(3) * CUBIC);
    let start = must(bed.solve(&kernel, &data, &FitOptions::default(), 30));
    // Parameters stay: the evidence of these is what the bound is compared with.
    let options = VariationalOptions { iterations: 0, ..VariationalOptions::default() };
    let found = must(bed.variational(&start, &kernel, &data, &options));

    let places = [[0.15], [0.5], [0.8]];
    let all = Data::new()
        .equation(&at, &load, Noise::Known(1.0))
        .values(&at, &[0.0; 3], Noise::Known(1.0))
        .values(&seen.0, &[0.0], Noise::Known(1.0))
        .values(&places, &[0.0; 3], Noise::Known(1.0));
    let prior = must(Prior::constrained(&string(0.0), &kernel));
    let model = must(Model::new(prior, all, Evidence::Joint));
    let covariance = must(model.prior_covariance(&found.parameters));
    let log_normal =
        |misfit: f64, sigma: f64| -0.5 * ((misfit / sigma).powi(2) + (TAU * sigma * sigma).ln());
    let truth = weighed(&covariance, 7, |d| {
        let residuals = (0..3).map(|k| d[k] + CUBIC * d[3 + k].powi(3) - load[k]);
        residuals.map(|r| log_normal(r, NOISE[0])).sum::<f64>()
            + log_normal(d[6] - seen.1[0], NOISE[1])
    });
    let bound = must(found.posterior().predict(&places));
    let linear = must(must(start.fit.posterior()).predict(&places));
    println!(
        "evidence {:.3}, bound {:.3}, by {:.0} effective draws",
        truth.log_evidence, found.bound, truth.effective
    );
    println!("mean {:.3?}, bound {:.3?}, linear {:.3?}", truth.mean, bound.mean, linear.mean);
    println!(
        "deviation {:.3?} {:.3?} {:.3?}",
        truth.deviation, bound.standard_deviation, linear.standard_deviation
    );
    // The draws leave 1/√effective, here less than 0.003.
    assert!(truth.effective > 1e5);
    assert!(found.bound < truth.log_evidence + 0.01 && found.bound > truth.log_evidence - 0.15);
    for place in 0..places.len() {
        let deviation = truth.deviation[place];
        let off = |mean: f64| (mean - truth.mean[place]).abs() / deviation;
        assert!(off(bound.mean[place]) < 0.02 && off(linear.mean[place]) > 0.4);
        let narrow = |found: f64| 1.0 - found / deviation;
        // A normal distribution below a bound is narrower than the truth, but less so than the linear one.
        assert!(narrow(bound.standard_deviation[place]) > 0.0);
        assert!(
            narrow(bound.standard_deviation[place])
                < 0.75 * narrow(linear.standard_deviation[place])
        );
    }
}

/// u_t + u u_x − ν u_xx = 0 on [0, 1] × [0, 1] with a known solution (Cole & Hopf), ν unknown.
fn burgers() -> (Domain<2>, SemiLinear<2, 2>, impl Fn([f64; 2]) -> f64) {
    const NU: f64 = 0.1;
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let viscosity = must(Parameter::new("viscosity", [0.01, 1.0]));
    let held = || Condition::Dirichlet(constant(0.0));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| {
        let angle = x * PI;
        angle.sin() * (2.0 * NU * PI) / (angle.cos() + 2.0)
    }));
    let linear = must(
        Problem::new(domain.clone(), dt - &viscosity * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held()))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    );
    let exact = |[x, t]: [f64; 2]| {
        let decay = (-NU * PI * PI * t).exp();
        2.0 * NU * PI * decay * (PI * x).sin() / (2.0 + decay * (PI * x).cos())
    };
    let term = SemiLinear::new(linear, [Derivative::identity(), dx], |[u, slope]| u * slope);
    (domain, term, exact)
}

#[test]
fn bounds_rise_turn_by_turn_for_terms_of_two_arguments() {
    let (domain, burgers, exact) = burgers();
    let places = must(domain.sample(20, 4));
    let y: Vec<f64> = (places.iter().enumerate())
        .map(|(k, x)| exact(*x) + 0.002 * (2.9 * k as f64).sin())
        .collect();
    let at = must(domain.sample(40, 5));
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 40], Noise::Learned);
    let kernel = SquaredExponential::new();
    let start = must(burgers.solve(&kernel, &data, &FitOptions::default(), 15));
    let grid = domain.grid(20);
    let error = |mean: Vec<f64>| {
        mean.iter().zip(&grid).map(|(u, x)| (u - exact(*x)).abs()).sum::<f64>() / 400.0
    };
    let linear = error(must(must(start.fit.posterior()).mean(&grid)));
    let mut bounds = Vec::new();
    for equation in [false, true] {
        let options = VariationalOptions { equation, ..VariationalOptions::default() };
        let clock = Instant::now();
        let found = must(burgers.variational(&start, &kernel, &data, &options));
        let seconds = clock.elapsed().as_secs_f64();
        let err = error(must(found.posterior().mean(&grid)));
        let nu = must(found.parameter("viscosity"));
        println!(
            "Burgers: ν {nu:.4}, err_u {err:.1e} ({linear:.1e} by linearisation), bound {:.2} \
             after {} turns, {seconds:.2} s",
            found.bound,
            found.trace.len()
        );
        assert!(found.settled && found.trace.is_sorted(), "{:?}", found.trace);
        assert!((nu / 0.1 - 1.0).abs() < 0.05 && err < linear.max(1e-3), "{nu} {err:e}");
        let stays = must(start.fit.parameter("viscosity")) == nu;
        assert_eq!(stays, !equation);
        bounds.push(*found.trace.last().unwrap_or(&f64::NAN));
    }
    assert!(bounds[1] >= bounds[0] - 1e-3, "{bounds:?}");
}

#[test]
fn what_has_no_bound_is_an_error() {
    let kernel = SquaredExponential::new();
    let solved = |term: &SemiLinear<1, 1>, data: &Data<1>| {
        let options = FitOptions { restarts: 1, ..FitOptions::default() };
        must(term.solve(&kernel, data, &options, 5))
    };
    let options = VariationalOptions::default();
    let at = [[0.2], [0.5], [0.7]];
    let with = |noise: Noise| Data::new().equation(&at, &[1.0, 2.0, 1.0], noise);

    // An exact equation.
    let cubic = SemiLinear::new(string(0.0), [Derivative::identity()], |[u]| u.powi(3));
    let start = solved(&cubic, &with(Noise::Exact));
    let exact = cubic.variational(&start, &kernel, &with(Noise::Exact), &options).unwrap_err();
    says(&exact, "the equation holds exactly");
    // Nothing to collocate.
    let bare = Data::new().values(&at, &[0.1; 3], Noise::Learned);
    let none = cubic.variational(&start, &kernel, &bare, &options).unwrap_err();
    says(&none, "no observations");
    // A term without a value at some of what u may be: the point is named.
    let root = SemiLinear::new(string(0.0), [Derivative::identity()], |[u]| (u + 0.5).ln());
    let wide = with(Noise::Known(20.0));
    let start = solved(&root, &wide);
    let nowhere = root.variational(&start, &kernel, &wide, &options).unwrap_err();
    assert!(matches!(nowhere, GpError::Singular(_)), "{nowhere}");
    says(&nowhere, "its arguments at point ");
    // Duplicate points, one point, exact values, values at the boundary: all have one.
    let repeated = Data::new()
        .equation(&[[0.5], [0.5], [1.0]], &[2.0, 2.0, 0.0], Noise::Known(0.1))
        .values(&[[0.5], [0.0]], &[0.2, 0.0], Noise::Exact);
    for data in [repeated, Data::new().equation(&[[0.5]], &[2.0], Noise::Known(0.1))] {
        let found = must(cubic.variational(&solved(&cubic, &data), &kernel, &data, &options));
        let there = must(found.posterior().predict(&[[0.5], [1.0]]));
        assert!(found.bound.is_finite() && found.settled);
        assert!(there.mean[0] > 0.1 && there.standard_deviation[1] == 0.0, "{there:?}");
    }
}

#[test]
fn terms_without_a_value_are_named_by_point_and_arguments() {
    let kernel = SquaredExponential::new();
    let options = FitOptions { restarts: 1, ..FitOptions::default() };
    let data = Data::new().equation(&[[0.2], [0.5]], &[1.0; 2], Noise::Exact);
    let identity = [Derivative::identity()];
    // Of the prior mean, zero, the logarithm has no value and the root no slope.
    for term in [|[u]: [Series; 1]| u.ln(), |[u]: [Series; 1]| u.sqrt()] {
        let equation = SemiLinear::new(string(0.0), identity, term);
        let named = equation.solve(&kernel, &data, &options, 5).unwrap_err();
        says(&named, "near (0), its arguments at point 0");
    }
    let cubic = SemiLinear::new(string(0.0), identity, |[u]| u.powi(3));
    let solution = must(cubic.solve(&kernel, &data, &options, 9));
    assert!(solution.has_converged());
    let logarithm = SemiLinear::new(string(0.0), identity, |[u]| u.ln());
    let ends = [[0.5], [0.0]];
    let named = logarithm.left_hand_side(&solution, &ends).unwrap_err();
    says(&named, "near (0), its arguments at point 1");
    // Unusable data come before anything that they are put into.
    let nowhere = Data::new().equation(&[[f64::NAN]], &[1.0], Noise::Exact);
    let named = logarithm.solve(&kernel, &nowhere, &options, 5).unwrap_err();
    says(&named, "point number 0 of observation group 1 is NaN");
    // −u″ − 6 eᵘ = 2 has no solution, and steps lead nowhere.
    let bratu = SemiLinear::new(string(0.0), identity, |[u]| u.exp() * -6.0);
    let at: Vec<[f64; 1]> = (1..8).map(|k| [f64::from(k) / 8.0]).collect();
    let load = Data::new().equation(&at, &[2.0; 7], Noise::Learned);
    let lost = must(bratu.solve(&kernel, &load, &options, 10));
    assert!(!lost.has_converged(), "{}", lost.change);
}

#[test]
fn predictions_average_about_the_parameters_found() {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let [dx] = domain.derivatives();
    let stiffness = must(Parameter::new("stiffness", [0.02, 10.0]));
    let held = || Condition::Dirichlet(constant(0.0));
    let string = Problem::new(domain, -(&stiffness * dx * dx))
        .and_then(|p| p.condition("x", Side::Lower, held()))
        .and_then(|p| p.condition("x", Side::Upper, held()));
    let term = SemiLinear::new(must(string), [Derivative::identity()], |[u]| u.powi(3) * 4.0);
    let at: Vec<[f64; 1]> = (1..8).map(|k| [f64::from(k) / 8.0]).collect();
    let data = Data::new().equation(&at, &[3.0; 7], Noise::Known(0.3)).values(
        &[[0.3], [0.6]],
        &[0.4, 0.5],
        Noise::Known(0.1),
    );
    let kernel = SquaredExponential::new();
    let start = must(term.solve(&kernel, &data, &FitOptions::default(), 20));
    let options = VariationalOptions { equation: true, draws: 200, ..Default::default() };
    let found = must(term.variational(&start, &kernel, &data, &options));
    let place = [[0.5]];
    let own = must(found.posterior().predict(&place));
    let averaged = must(found.predict(&place));
    let linear = must(must(start.fit.posterior()).mean(&place))[0];
    println!("{linear} linearised, {own:?} at the parameters found, {averaged:?} about them");
    let [before, after] =
        [start.fit.parameter("stiffness"), found.parameter("stiffness")].map(must);
    assert!((after / before).ln().abs() > 0.05, "the equation moves: {before} to {after}");
    // A deviation of the stiffness moves u by far more than where its mean lies.
    assert!((averaged.mean[0] - own.mean[0]).abs() < 0.5 * averaged.standard_deviation[0]);
    assert!(averaged.standard_deviation[0] > own.standard_deviation[0]);
}

#[test]
fn exact_zeros_count_in_any_unit() {
    let kernel = SquaredExponential::new();
    let at: Vec<[f64; 1]> = (1..8).map(|k| [f64::from(k) / 8.0]).collect();
    let solved =
        |unit: f64| {
            let domain = must(Domain::interval("x", [0.0, 1.0]));
            let [dx] = domain.derivatives();
            let held = Condition::Dirichlet(constant(0.0));
            let string = must(Problem::new(domain, -(dx * dx)));
            let string = must(string.condition("x", Side::Lower, held));
            let cubic = move |[u]: [Series; 1]| u.powi(3) / (unit * unit);
            let cubic = SemiLinear::new(string, [Derivative::identity()], cubic);
            // The other support, seen to rest.
            let data = Data::new()
                .equation(&at, &[2.0 * unit; 7], Noise::Known(0.1 * unit))
                .values(&[[0.9]], &[0.0], Noise::Exact);
            let start = must(cubic.solve(&kernel, &data, &FitOptions::default(), 20));
            let options = VariationalOptions::default();
            let found = must(cubic.variational(&start, &kernel, &data, &options));
            let found = must(found.predict(&[[0.9], [0.5]]));
            [found.mean[0], found.standard_deviation[0], found.mean[1], found.standard_deviation[1]]
                .map(|u| u / unit)
        };
    let reference = solved(1.0);
    for unit in [1e8, 1e-8] {
        let [fixed, by, moves, spread] = solved(unit);
        assert!(fixed.abs() < 1e-4 && by < 1e-4, "{unit}: {fixed} ± {by}");
        // The bound ends at the same place but for its last, small gain.
        assert!((moves / reference[2] - 1.0).abs() < 1e-3, "{unit}: {moves}, {reference:?}");
        assert!((spread / reference[3] - 1.0).abs() < 1e-2, "{unit}: {spread}, {reference:?}");
    }
}
