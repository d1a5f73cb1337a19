//! Theorems of chapter 4 as numbers: wide networks become Gaussian processes, and built-in
//! conditions leave a prior universal.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, Hyperparameter, Kernel, Model, Network, Noise,
    Operator, Prior, Problem, Series, Side, SquaredExponential, check_kernel, constant,
};

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// 1 + E tanh(b + wx) tanh(b + wx′) on [−1, 1] with standard normal b and w: the limit of networks
/// of one hidden layer (Theorem 4.6.1).
#[derive(Debug)]
struct WideNetwork;

/// Trapezoidal rule for a standard normal variate: beyond 6 deviations nothing is left, and the
/// poles of tanh are far enough off the axis for eleven digits at this step.
fn nodes() -> Vec<(f64, f64)> {
    const STEP: f64 = 0.4;
    (-15..=15)
        .map(|k| {
            let b = STEP * f64::from(k);
            (b, STEP * (-0.5 * b * b).exp() / (2.0 * std::f64::consts::PI).sqrt())
        })
        .collect()
}

impl Kernel<1> for WideNetwork {
    fn name(&self) -> String {
        "wide network".into()
    }
    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        Vec::new()
    }
    fn on_axes(&self, _: &[usize]) -> Box<dyn Kernel<1>> {
        Box::new(WideNetwork)
    }
    fn formula(&self, _: &[Series], [x]: &[Series; 1], [y]: &[Series; 1]) -> Series {
        let mut sum = x.constant(1.0);
        for (b, b_weight) in nodes() {
            for (w, w_weight) in nodes() {
                let unit = |x: &Series| (x * w + b).tanh();
                sum = sum + unit(x) * unit(y) * (b_weight * w_weight);
            }
        }
        sum
    }
}

/// −u″ on [−1, 1] with u(−1) = 0 and u(1) = 1.
fn ramp() -> Problem<1> {
    let domain = must(Domain::interval("x", [-1.0, 1.0]));
    let [dx] = domain.derivatives();
    must(
        Problem::new(domain, -(dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, Condition::Dirichlet(constant(0.0))))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Dirichlet(constant(1.0)))),
    )
}

/// −u″ at two points, then u at two points.
fn functionals(network: &Network<1>, equation: &Operator<1>) -> [f64; 4] {
    let load = must(network.mean_of(equation, &[[-0.5], [0.3]]));
    let value = must(network.mean(&[[-0.5], [0.6]]));
    [load[0], load[1], value[0], value[1]]
}

/// Theorem 4.6.2. The covariance of random networks is the limit's at every width; what the width
/// brings is normality, as the fourth cumulant that falls as 1/width.
#[test]
fn wide_networks_with_hard_conditions_become_gaussian_processes() {
    must(check_kernel(&WideNetwork, &[], [-1.0], [1.0], 1));
    const DRAWS: u64 = 12_000;
    let problem = ramp();
    let equation = problem.equation().clone();
    let data = Data::new().equation(&[[-0.5], [0.3]], &[0.0; 2], Noise::Exact).values(
        &[[-0.5], [0.6]],
        &[0.0; 2],
        Noise::Known(1.0),
    );
    let prior = must(Prior::constrained(&problem, &WideNetwork));
    // The only parameter is the amplitude, one on its logarithmic scale at zero.
    let limit = must(must(Model::new(prior, data, Evidence::Joint)).prior_covariance(&[0.0]));
    let mean = [0.0, 0.0, 0.25, 0.8]; // (1 + x)/2 and its curvature
    let mut excess_by_width = Vec::new();
    for width in [1, 4, 16] {
        let mut covariance = [[0.0; 4]; 4];
        let mut fourth = 0.0;
        for seed in 0..DRAWS {
            let prior = must(Prior::constrained(&problem, &SquaredExponential::new()));
            let network = Network::random(prior, width, seed);
            let z: [f64; 4] = {
                let u = functionals(&network, &equation);
                std::array::from_fn(|k| (u[k] - mean[k]) / limit[k][k].sqrt())
            };
            for (row, a) in covariance.iter_mut().zip(z) {
                row.iter_mut().zip(z).for_each(|(c, b)| *c += a * b / DRAWS as f64);
            }
            fourth += 0.5 * (z[0].powi(4) + z[1].powi(4)) / DRAWS as f64;
        }
        let mut worst = 0.0_f64;
        for (i, row) in covariance.iter().enumerate() {
            for (j, c) in row.iter().enumerate() {
                worst = worst.max((c - limit[i][j] / (limit[i][i] * limit[j][j]).sqrt()).abs());
            }
        }
        let excess = fourth - 3.0;
        println!(
            "width {width}: covariance off by {worst:.3}, excess kurtosis of -u'' {excess:.3}"
        );
        // Four standard deviations of a correlation from so many draws, more where tails are heavy.
        assert!(worst < 4.0 * ((2.0 + excess.max(0.0)) / DRAWS as f64).sqrt(), "{width}: {worst}");
        excess_by_width.push(excess);
    }
    assert!(excess_by_width[0] > 1.0, "a narrow network is not a Gaussian process");
    for pair in excess_by_width.windows(2) {
        assert!(pair[1] < 0.5 * pair[0], "{excess_by_width:?}");
    }
}

/// Theorem 4.5.3: z = u/φ of u = (1 − x)√x has no limit at 0, yet u is approximated uniformly.
#[test]
fn built_in_conditions_leave_a_prior_universal() {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let rough = |x: f64| (1.0 - x) * x.sqrt();
    let mut errors = Vec::new();
    for count in [4, 8, 16, 32, 64] {
        let at: Vec<[f64; 1]> =
            (1..=count).map(|k| [f64::from(k) / f64::from(count + 1)]).collect();
        let values: Vec<f64> = at.iter().map(|[x]| rough(*x)).collect();
        let held = || Condition::Dirichlet(constant(0.0));
        let problem = must(
            Problem::new(domain.clone(), Operator::identity())
                .and_then(|p| p.condition("x", Side::Lower, held()))
                .and_then(|p| p.condition("x", Side::Upper, held())),
        );
        let data = Data::new().values(&at, &values, Noise::Exact);
        let prior = must(Prior::constrained(&problem, &SquaredExponential::new()));
        let model = must(Model::new(prior, data, Evidence::Joint));
        let fit = must(model.fit(&FitOptions::default()));
        let grid = domain.grid(2001);
        let mean = must(must(fit.posterior()).mean(&grid));
        let err = mean.iter().zip(&grid).map(|(u, [x])| (u - rough(*x)).abs()).fold(0.0, f64::max);
        println!("(1 - x) sqrt x from {count} values: largest error {err:.1e}");
        assert_eq!([mean[0], mean[2000]], [0.0, 0.0]);
        errors.push(err);
    }
    for pair in errors.windows(2) {
        // From points h apart no method does better than √h on a square root: √2 for twice as many.
        assert!((1.25..1.6).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}
