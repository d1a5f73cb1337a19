//! Covariances against Taylor series of the whole constrained kernel, evidence gradients against
//! finite differences.

use sinew_gp::{
    Condition, Data, Domain, Evidence, Formula, Model, Noise, Operator, Parameter, Periodicity,
    Prior, Problem, Series, Side, Smoothness, constant, constraints, field, linear, matern,
    periodic, rational_quadratic, squared_exponential,
};
use std::f64::consts::PI;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// u_t = θ u_xx with Dirichlet data on three sides (Heat-BVP-1).
fn heat() -> Problem<2> {
    let domain = must(Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let theta = must(Parameter::new("theta", [0.1, 10.0]));
    let end = |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin()));
    must(
        Problem::new(domain, dt - &theta * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, end(-1.0)))
            .and_then(|p| p.condition("x", Side::Upper, end(1.0)))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    )
}

/// A biharmonic equation with a varying coefficient, clamped at x = 0 and insulated at x = 1.
fn plate() -> Problem<2> {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 2.0])]));
    let [dx, dy] = domain.derivatives();
    let foundation = must(Parameter::new("foundation", [-2.0, 5.0]));
    let biharmonic = dx * dx * dx * dx
        + 2.0 * (dx * dx * dy * dy)
        + field(|[x, y]: [Series; 2]| x * 0.5 + y.squared() * 0.1 + 1.0) * dy * dy * dy * dy;
    let identity = sinew_gp::Derivative::identity();
    let clamped = Condition::Cauchy { value: constant(0.0), slope: constant(0.0) };
    must(
        Problem::new(domain, biharmonic + &foundation * identity)
            .and_then(|p| p.condition("x", Side::Lower, clamped))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Neumann(constant(0.0)))),
    )
}

/// A membrane over a pentagon, with values on its edges.
fn membrane() -> Problem<2> {
    let corners = [[0.0, 0.0], [2.0, 0.1], [2.3, 1.4], [1.0, 2.0], [-0.4, 1.1]];
    let domain = must(Domain::polygon(["x", "y"], &corners));
    let [dx, dy] = domain.derivatives();
    let theta = must(Parameter::new("theta", [0.1, 10.0]));
    let rim = field(|[x, y]| x * 0.3 + y + 1.0);
    must(Problem::new(domain, &theta * dx * dx + dy * dy).and_then(|p| p.boundary(rim)))
}

/// u_t + c u_x = 0 around a ring.
fn ring(periodicity: Periodicity) -> Problem<2> {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let speed = must(Parameter::new("speed", [0.1, 3.0]));
    must(Problem::new(domain, dt + &speed * dx).and_then(|p| p.periodic("x", periodicity)))
}

/// L applied to both arguments of Σ φ φ′ k, from one Taylor series in all 2 D coordinates.
fn by_series<const D: usize>(
    problem: &Problem<D>,
    kernel: &Formula<D>,
    theta: f64,
    parameters: &[Vec<f64>],
    operators: [&Operator<D>; 2],
    points: [[f64; D]; 2],
) -> f64 {
    let degrees: Vec<usize> = operators.iter().flat_map(|operator| operator.orders()).collect();
    let variable =
        |side: usize, d: usize| Series::variable(points[side][d], side * D + d, &degrees);
    let x: [Series; D] = std::array::from_fn(|d| variable(0, d));
    let y: [Series; D] = std::array::from_fn(|d| variable(1, d));
    let mut sum = x[0].constant(0.0);
    for (feature, values) in must(constraints(problem)).features.iter().zip(parameters) {
        let (amplitude, rest) = values.split_first().unwrap();
        let numbers: Vec<Series> = rest.iter().map(|v| x[0].constant(*v)).collect();
        let latent = kernel.clone().along(&feature.axes).formula(&numbers, &x, &y);
        let factors = feature.factor.at(x.clone()) * feature.factor.at(y.clone());
        sum = sum + factors * latent * (amplitude * amplitude);
    }
    let mut total = 0.0;
    for left in operators[0].terms() {
        for right in operators[1].terms() {
            let factor = |term: &sinew_gp::Term<D>, point: [f64; D]| {
                let powers: i32 = term.parameters.iter().map(|(_, power)| power).sum();
                term.scale
                    * theta.powi(powers)
                    * term.function.as_ref().map_or(1.0, |f| f.value(point))
            };
            let orders = [left.derivative.orders.as_slice(), &right.derivative.orders].concat();
            total += factor(left, points[0]) * factor(right, points[1]) * sum.derivative(&orders);
        }
    }
    total
}

/// Largest difference relative to √(K_ii K_jj).
fn disagreement<const D: usize>(problem: Problem<D>, kernel: &Formula<D>, theta: f64) -> f64 {
    let domain = problem.domain().clone();
    let points = must(domain.sample(7, 3));
    let (at_values, at_equation) = points.split_at(3);
    let data = Data::new().values(at_values, &[0.1, 0.2, 0.3], Noise::Known(0.1)).equation(
        at_equation,
        &[0.0; 4],
        Noise::Exact,
    );
    let model = must(Model::new(must(Prior::constrained(&problem, kernel)), data, Evidence::Joint));
    let parameters: Vec<f64> = model
        .parameters()
        .iter()
        .enumerate()
        .map(|(number, p)| match p.name.as_str() {
            "theta" | "foundation" => p.to_scale(theta),
            _ => p.to_scale((p.start[0] * p.start[1]).sqrt() * (1.0 + 0.1 * (number % 3) as f64)),
        })
        .collect();
    let mut offset = 0;
    let per_part: Vec<Vec<f64>> = must(constraints(&problem))
        .features
        .iter()
        .map(|feature| {
            let count = 1 + kernel.clone().along(&feature.axes).hyperparameters().len();
            let values = model.parameters()[offset..offset + count]
                .iter()
                .zip(&parameters[offset..offset + count])
                .map(|(p, s)| p.from_scale(*s))
                .collect();
            offset += count;
            values
        })
        .collect();
    let identity = Operator::identity();
    let ours = must(model.prior_covariance(&parameters));
    let ordered: Vec<(&Operator<D>, [f64; D])> = at_equation
        .iter()
        .map(|p| (problem.equation(), *p))
        .chain(at_values.iter().map(|p| (&identity, *p)))
        .collect();
    let mut most = 0.0_f64;
    for (i, (left, x)) in ordered.iter().enumerate() {
        for (j, (right, y)) in ordered.iter().enumerate().take(i + 1) {
            let exact = by_series(&problem, kernel, theta, &per_part, [left, right], [*x, *y]);
            let scale = (ours[i][i] * ours[j][j]).sqrt();
            most = most.max((ours[i][j] - exact).abs() / scale);
        }
    }
    most
}

#[test]
fn covariances_equal_nested_jets() {
    // The bar is 1e-12 relative to the variances.
    const TOLERANCE: f64 = 1e-12;
    let of_two = disagreement(heat(), &squared_exponential(), 1.3);
    assert!(of_two < TOLERANCE, "orders 2 + 2: {of_two:e}");
    let of_four = disagreement(plate(), &squared_exponential(), 0.7);
    assert!(of_four < TOLERANCE, "orders 4 + 4: {of_four:e}");
    let polygon = disagreement(membrane(), &squared_exponential(), 1.3);
    assert!(polygon < TOLERANCE, "on a polygon: {polygon:e}");
    let rational = disagreement(plate(), &rational_quadratic(), 0.7);
    assert!(rational < TOLERANCE, "rational quadratic, orders 4 + 4: {rational:e}");
}

fn check_gradient<const D: usize>(
    problem: &Problem<D>,
    prior: Prior<D>,
    evidence: Evidence,
    label: &str,
) {
    let domain = problem.domain();
    let points = must(domain.sample(12, 8));
    let flux = points[9..].to_vec();
    let values: Vec<f64> = (0..5).map(|k| 0.3 + (1.7 * f64::from(k)).sin()).collect();
    let data = Data::new()
        .values(&points[..5], &values, Noise::Learned)
        .equation(&points[5..9], &[0.2, 0.1, -0.3, 0.4], Noise::Known(0.3))
        .functional(domain.derivatives()[0], &flux, &[0.4, 0.1, 0.2], Noise::Learned);
    let model = must(Model::new(prior, data, evidence));
    let at: Vec<f64> = model
        .parameters()
        .iter()
        .enumerate()
        .map(|(number, p)| {
            let [lower, upper] = p.start.map(|end| p.to_scale(end));
            lower + (upper - lower) * (0.3 + 0.1 * (number % 5) as f64)
        })
        .collect();
    let evaluation = must(model.evaluate(&at));
    assert_eq!(evaluation.value, must(model.log_evidence(&at)));
    let scale = evaluation.gradient.iter().fold(1.0_f64, |m, g| m.max(g.abs()));
    // A fourth-order difference: truncation and rounding both below the bar of 1e-7.
    const STEP: f64 = 2e-3;
    for (number, slope) in evaluation.gradient.iter().enumerate() {
        let shifted = |steps: f64| {
            let mut moved = at.clone();
            moved[number] += steps * STEP;
            must(model.log_evidence(&moved))
        };
        let difference =
            (8.0 * (shifted(1.0) - shifted(-1.0)) - (shifted(2.0) - shifted(-2.0))) / (12.0 * STEP);
        let name = &model.parameters()[number].name;
        assert!((slope - difference).abs() < 1e-7 * scale, "{label}, {name}: {slope} {difference}");
    }
}

#[test]
fn evidence_gradients_equal_differences() {
    for evidence in [Evidence::Joint, Evidence::UnitInformation] {
        let kernels: Vec<Formula<2>> = vec![
            squared_exponential(),
            rational_quadratic(),
            matern(Smoothness::Thrice),
            must(periodic(0, 7.0)) * squared_exponential().along(&[1]),
            squared_exponential().scaled() + linear().scaled(),
        ];
        for kernel in &kernels {
            let problem = heat();
            let prior = must(Prior::constrained(&problem, kernel));
            check_gradient(&problem, prior, evidence, &kernel.name);
        }
        let problem = plate();
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        check_gradient(&problem, prior, evidence, "plate");
        let problem = heat();
        let prior = must(Prior::penalised(&problem, &squared_exponential(), 9, 4));
        check_gradient(&problem, prior, evidence, "penalised");
        let problem = membrane();
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        check_gradient(&problem, prior, evidence, "membrane");
        for periodicity in [Periodicity::Value, Periodicity::ValueAndSlope] {
            let problem = ring(periodicity);
            let prior = must(Prior::penalised(&problem, &squared_exponential(), 9, 4));
            check_gradient(&problem, prior, evidence, "penalised jumps");
        }
    }
}

#[test]
fn jumps_covary_as_differences_of_both_ends() {
    // Six jumps of the value, five of the slope; k = σ² exp(−½ (r²/λ² + s²/μ²)), differentiated by hand.
    let problem = ring(Periodicity::ValueAndSlope);
    let prior = must(Prior::penalised(&problem, &squared_exponential(), 12, 2));
    let model = must(Model::new(prior, Data::new(), Evidence::Joint));
    let (sigma, lambda, mu) = (1.3_f64, 0.6_f64, 0.4_f64);
    let at: Vec<f64> = model
        .parameters()
        .iter()
        .map(|p| match p.name.as_str() {
            "amplitude 1" => sigma.ln(),
            "lengthscale x 1" => lambda.ln(),
            "lengthscale t 1" => mu.ln(),
            _ => p.to_scale(p.start[0]),
        })
        .collect();
    let ours = must(model.prior_covariance(&at));
    // Over both ends of both jumps, r = 0 twice with sign plus and r = ±1 once each with minus.
    let along = |derivative: &dyn Fn(f64) -> f64| {
        2.0 * derivative(0.0) - derivative(1.0) - derivative(-1.0)
    };
    let k = |r: f64| (-0.5 * (r / lambda).powi(2)).exp();
    let value = along(&k);
    let slope = along(&|r| k(r) * (1.0 - (r / lambda).powi(2)) / lambda.powi(2));
    for (row, expected) in [(0, value), (11, slope)] {
        let expected = sigma * sigma * expected;
        assert!((ours[row][row] - expected).abs() < 1e-12 * expected, "{row}");
    }
    // ∂/∂x k is odd in r: at equal t, its jumps with those of the value cancel.
    let cross = (0..6).flat_map(|i| (6..12).map(move |j| (i, j)));
    for (i, j) in cross {
        assert!(ours[i][j].abs() < 1e-12 * sigma * sigma, "{i} {j}");
    }
}

#[test]
fn rough_kernels_are_refused() {
    let problem = heat();
    let refused = Prior::constrained(&problem, &matern(Smoothness::Once)).unwrap_err();
    assert!(refused.to_string().contains("Matérn 3/2 kernel has 1 derivatives"), "{refused}");
}
