//! Equations on polygons with conditions given edge by edge.

use std::f64::consts::PI;

use sinew_gp::{
    Composition, Condition, Data, Domain, Evidence, FitOptions, Model, Noise, Prior, Problem,
    Series, SquaredExponential, field,
};

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// u = sin x cosh(y / 2), −Δu = ¾ u.
fn exact([x, y]: &[Series; 2]) -> Series {
    let (up, down) = ((y * 0.5).exp(), (y * -0.5).exp());
    x.sin() * (up + down) * 0.5
}

fn slope([nx, ny]: [f64; 2]) -> impl Fn([Series; 2]) -> Series + Send + Sync + 'static {
    move |[x, y]| {
        let (up, down) = ((&y * 0.5).exp(), (&y * -0.5).exp());
        x.cos() * (&up + &down) * (0.5 * nx) + x.sin() * (up - down) * (0.25 * ny)
    }
}

/// Values on even edges, fluxes or springs on odd ones.
fn problem(corners: &[[f64; 2]], composition: Composition) -> Problem<2> {
    let domain = must(Domain::polygon(["x", "y"], corners).and_then(|d| d.composed(composition)));
    let [dx, dy] = domain.derivatives();
    let corners = domain.cross_section().map(|p| p.corners().to_vec()).unwrap_or_default();
    let problem = must(Problem::new(domain, -(dx * dx) - dy * dy));
    (0..corners.len()).fold(problem, |problem, edge| {
        let ([ax, ay], [bx, by]) = (corners[edge], corners[(edge + 1) % corners.len()]);
        let length = (bx - ax).hypot(by - ay);
        let outwards = [(by - ay) / length, (ax - bx) / length];
        let condition = match edge % 4 {
            0 | 2 => Condition::Dirichlet(field(|x: [Series; 2]| exact(&x))),
            1 => Condition::Neumann(field(slope(outwards))),
            _ => {
                let flux = slope(outwards);
                let data = field(move |x: [Series; 2]| exact(&x) + flux(x) * 2.0);
                Condition::Robin { value_factor: 1.0, slope_factor: 2.0, data }
            }
        };
        must(problem.edge(edge, condition))
    })
}

/// Mean error of the constrained posterior with `count` collocation points.
fn error(problem: &Problem<2>, count: usize) -> f64 {
    let domain = problem.domain();
    let at = must(domain.sample(count, 3));
    let value = |point: &[f64; 2]| exact(&Series::plain(*point)).value();
    let load: Vec<f64> = at.iter().map(|point| 0.75 * value(point)).collect();
    let prior = must(Prior::constrained(problem, &SquaredExponential::new()));
    let data = Data::new().equation(&at, &load, Noise::Exact);
    let options = FitOptions { restarts: 2, iterations: 60, seed: 1 };
    let fit = must(must(Model::new(prior, data, Evidence::Auto)).fit(&options));
    let grid = must(domain.sample(300, 9));
    let mean = must(must(fit.posterior()).mean(&grid));
    mean.iter().zip(&grid).map(|(m, x)| (m - value(x)).abs()).sum::<f64>() / grid.len() as f64
}

#[test]
fn membranes_with_mixed_edges_are_solved() {
    let pentagon: Vec<[f64; 2]> = (0..5)
        .map(|k| PI / 2.0 + 0.4 * PI * f64::from(k))
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    let notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    // Mean errors of a u of size one: at the time of writing 5.6e-4 and 3.6e-3.
    let convex = (&pentagon[..], Composition::Conjunction, 2e-3);
    let notched = (&notched[..], Composition::Equivalence { order: 1 }, 1.5e-2);
    for (corners, composition, bound) in [convex, notched] {
        let err = error(&problem(corners, composition), 160);
        println!("{composition:?}: {err:.1e}");
        assert!(err < bound, "{composition:?}: {err:e}");
    }
}
