//! A theorem of chapter 4 as numbers: built-in conditions leave a prior universal.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, Model, Noise, Operator, Prior, Problem, Side,
    constant, squared_exponential,
};

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
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
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let model = must(Model::new(prior, data, Evidence::Joint));
        let fit = must(model.fit(&FitOptions::default()));
        let grid = domain.grid(2001);
        let mean = must(must(fit.conditional()).mean(&grid));
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
