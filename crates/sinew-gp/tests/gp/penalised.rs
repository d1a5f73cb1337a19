//! Conditions as pseudo-observations (PCGP).

use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, Model, Noise, Operator, Parameter,
    Periodicity, Prior, Problem, Series, Side, field, squared_exponential,
};
use std::f64::consts::PI;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// sin 2π(x − t/2) travels around a ring of length one.
fn exact([x, t]: [f64; 2]) -> f64 {
    (2.0 * PI * (x - 0.5 * t)).sin()
}

/// u_t + c u_x = 0 with its start; what is told of the ends is that they join.
fn ring(periodicity: Periodicity) -> Problem<2> {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let speed = must(Parameter::new("speed", [0.05, 5.0]));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| (x * (2.0 * PI)).sin()));
    must(
        Problem::new(domain, dt + &speed * dx)
            .and_then(|p| p.periodic("x", periodicity))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    )
}

#[test]
fn a_wave_runs_around_a_ring() {
    for periodicity in [Periodicity::Value, Periodicity::ValueAndSlope] {
        let problem = ring(periodicity);
        let domain = problem.domain().clone();
        let prior = must(Prior::penalised(&problem, &squared_exponential(), 80, 3));
        let places = must(domain.sample(8, 1));
        let y: Vec<f64> = places
            .iter()
            .enumerate()
            .map(|(k, x)| exact(*x) + 0.01 * (2.3 * k as f64).sin())
            .collect();
        let data = Data::new().values(&places, &y, Noise::Known(0.01)).equation(
            &must(domain.sample(60, 2)),
            &[0.0; 60],
            Noise::Exact,
        );
        let model = must(Model::new(prior, data, Evidence::Auto));
        let fit = must(model.fit(&FitOptions::default()));
        let speed = must(fit.parameter("speed"));
        assert!((speed - 0.5).abs() < 0.01, "{periodicity:?}: {speed}");
        let conditional = must(fit.conditional());
        let grid = domain.grid(15);
        let mean = must(conditional.mean(&grid));
        let misses = mean.iter().zip(&grid).map(|(m, x)| (m - exact(*x)).abs());
        let err = misses.sum::<f64>() / grid.len() as f64;
        // Distance between the ends at times between pseudo-observations. The last times are left out: no
        // pseudo-observation lies beyond them.
        let jump = |operator: &Operator<2>| {
            (1..10)
                .map(|k| {
                    let t = f64::from(k) / 10.0;
                    let ends = must(conditional.mean_of(operator, &[[0.0, t], [1.0, t]]));
                    (ends[1] - ends[0]).abs()
                })
                .fold(0.0, f64::max)
        };
        let value = jump(&Operator::identity());
        let slope = jump(&Derivative::along(0).into());
        println!(
            "{periodicity:?}: speed {speed:.4}, error {err:.1e}, jumps {value:.1e} {slope:.1e}"
        );
        assert!(err < 0.01, "{periodicity:?}: {err}");
        assert!(value < 0.03, "{periodicity:?}: {value}");
        // The slope has size 2π.
        assert!(periodicity == Periodicity::Value || slope < 0.3, "{slope}");
    }
}
