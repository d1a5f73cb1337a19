//! Equations on polygons with conditions given edge by edge.

use sinew_gp::{
    Condition, Conditional, Data, Domain, Evidence, FitOptions, Model, Noise, Operator, Prior,
    Problem, Series, Side, SquaredExponential, constant, field,
};
use std::f64::consts::PI;

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
fn problem(corners: &[[f64; 2]]) -> Problem<2> {
    let domain = must(Domain::polygon(["x", "y"], corners));
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
                Condition::Robin { value_factor: constant(1.0), slope_factor: constant(2.0), data }
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
    let options = FitOptions {
        restarts: 2,
        iterations: 60,
        seed: 1,
        most_points: 0,
        ..FitOptions::default()
    };
    let fit = must(must(Model::new(prior, data, Evidence::Auto)).fit(&options));
    let grid = must(domain.sample(300, 9));
    let mean = must(must(fit.conditional()).mean(&grid));
    mean.iter().zip(&grid).map(|(m, x)| (m - value(x)).abs()).sum::<f64>() / grid.len() as f64
}

fn pentagon() -> Vec<[f64; 2]> {
    (0..5)
        .map(|k| PI / 2.0 + 0.4 * PI * f64::from(k))
        .map(|angle| [angle.cos(), angle.sin()])
        .collect()
}

const NOTCHED: [[f64; 2]; 6] =
    [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

#[test]
fn membranes_with_mixed_edges_are_solved() {
    // Mean errors of a u of size one.
    for (corners, bound) in [(&pentagon()[..], 2e-3), (&NOTCHED[..], 1.5e-2)] {
        let err = error(&problem(corners), 160);
        println!("{} corners: {err:.1e}", corners.len());
        assert!(err < bound, "{corners:?}: {err:e}");
    }
}

/// Largest distance of a function from the conditions, on nine points of each edge.
fn largest_miss(problem: &Problem<2>, conditional: &Conditional<2>) -> f64 {
    let [dx, dy] = problem.domain().derivatives();
    let corners = problem.domain().cross_section().map(|p| p.corners()).unwrap_or_default();
    let mut most = 0.0_f64;
    for (edge, start) in corners.iter().enumerate() {
        let end = corners[(edge + 1) % corners.len()];
        let [along_x, along_y] = [end[0] - start[0], end[1] - start[1]];
        let length = along_x.hypot(along_y);
        let outwards = [along_y / length, -along_x / length];
        let flux: Operator<2> = outwards[0] * dx + outwards[1] * dy;
        let points: Vec<[f64; 2]> = (1..10)
            .map(|k| f64::from(k) / 10.0)
            .map(|s| [start[0] + s * along_x, start[1] + s * along_y])
            .collect();
        let slopes = must(conditional.mean_of(&flux, &points));
        let values = must(conditional.mean(&points));
        let expected = slope(outwards);
        for ((point, value), found) in points.iter().zip(values).zip(slopes) {
            let value_miss = value - exact(&Series::plain(*point)).value();
            let slope_miss = found - expected(Series::plain(*point)).value();
            let miss = match edge % 4 {
                0 | 2 => value_miss,
                1 => slope_miss,
                _ => value_miss + 2.0 * slope_miss,
            };
            most = most.max(miss.abs());
        }
    }
    most
}

/// The posterior of some loads, whose mean is far from the solution.
fn posterior<const D: usize>(problem: &Problem<D>, count: usize) -> Conditional<D> {
    let at = must(problem.domain().sample(count, 3));
    let load: Vec<f64> = (0..count).map(|k| 3.0 * (k as f64).sin()).collect();
    let data = Data::new().equation(&at, &load, Noise::Known(0.01));
    let prior = must(Prior::constrained(problem, &SquaredExponential::new()));
    let fit = must(Model::new(prior, data, Evidence::Joint));
    must(must(fit.fit(&FitOptions { restarts: 1, ..FitOptions::default() })).conditional())
}

#[test]
fn functions_keep_mixed_edges_whatever_the_load() {
    for problem in [problem(&pentagon()), problem(&NOTCHED)] {
        let conditional = posterior(&problem, 12);
        let inside = must(problem.domain().sample(50, 9));
        let off = must(conditional.mean(&inside))
            .iter()
            .zip(&inside)
            .fold(0.0_f64, |most, (u, x)| most.max((u - exact(&Series::plain(*x)).value()).abs()));
        let miss = largest_miss(&problem, &conditional);
        println!("conditions missed by {miss:.1e} where u is off by {off:.1e}");
        assert!(off > 1e-2 && miss < 1e-9, "{off:e} {miss:e}");
    }
}

#[test]
fn functions_keep_fluxes_through_the_sides_of_a_prism() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.0, 1.0]];
    let domain = must(Domain::prism(["x", "y"], &corners, ("t", [0.0, 3.0])));
    let [dx, dy, dt] = domain.derivatives();
    let zero = || constant(0.0);
    let problem = must(Problem::new(domain, dt - dx * dx - dy * dy));
    let problem = must(problem.condition("t", Side::Lower, Condition::Dirichlet(zero())));
    let problem = must(problem.edge(0, Condition::Neumann(zero())));
    let problem = must(problem.edge(2, Condition::Dirichlet(zero())));
    let conditional = posterior(&problem, 20);
    let inside = must(conditional.mean(&[[0.7, 0.4, 1.0], [0.7, 0.4, 2.5]]));
    assert!((inside[0] - inside[1]).abs() > 1e-3, "it moves: {inside:?}");
    let places = |y: f64, t: f64| (1..10).map(move |k| [0.15 * f64::from(k), y, t]);
    let below: Vec<[f64; 3]> = places(0.0, 0.4).chain(places(0.0, 2.9)).collect();
    let above: Vec<[f64; 3]> = places(1.0, 0.4).chain(places(1.0, 2.9)).collect();
    let start: Vec<[f64; 3]> = places(0.3, 0.0).chain(places(0.8, 0.0)).collect();
    let free = must(conditional.mean(&below));
    assert!(free.iter().all(|u| u.abs() > 1e-6), "values on the edge are free: {free:?}");
    let kept = [
        must(conditional.mean_of(&dy.into(), &below)),
        must(conditional.mean(&above)),
        must(conditional.mean(&start)),
    ];
    let miss = kept.iter().flatten().fold(0.0_f64, |most, u| most.max(u.abs()));
    assert!(miss < 1e-9, "{miss:e}");
}

/// Coordinates along and across the line that halves the notch, from its corner.
fn from_notch([x, y]: &[Series; 2]) -> [Series; 2] {
    let half = 0.5_f64.sqrt();
    [(x + y - 2.0) * -half, (x - y) * half]
}

/// r^⅔ sin ⅔φ with the angle φ from one edge of the notch, harmonic and zero on both.
fn rough(x: &[Series; 2]) -> Series {
    let [along, across] = from_notch(x);
    let angle = across.atan2(&along);
    (along.squared() + across.squared()).powf(1.0 / 3.0) * (angle * (2.0 / 3.0)).cos()
}

/// Collocation points on an L.
const POINTS: usize = 160;

/// Largest error over the range with data edge by edge, each a function of the position along its edge; and the band next to
/// the notch over that in outer corners.
fn notched(u: fn(&[Series; 2]) -> Series, load: fn([f64; 2]) -> f64, seed: u64) -> (f64, f64) {
    let domain = must(Domain::polygon(["x", "y"], &NOTCHED));
    let [dx, dy] = domain.derivatives();
    let problem = must(Problem::new(domain.clone(), -(dx * dx) - dy * dy));
    let problem = (0..6).fold(problem, |problem, edge| {
        let [first, second] = [NOTCHED[edge], NOTCHED[(edge + 1) % 6]];
        let across = usize::from(first[0] != second[0]);
        let on_edge = field(move |x: [Series; 2]| {
            let mut at = x.clone();
            at[across] = x[across].constant(first[across]);
            u(&at)
        });
        must(problem.edge(edge, Condition::Dirichlet(on_edge)))
    });
    let at = must(domain.sample(POINTS, seed));
    let f: Vec<f64> = at.iter().map(|x| load(*x)).collect();
    let prior = must(Prior::constrained(&problem, &SquaredExponential::new()));
    let data = Data::new().equation(&at, &f, Noise::Exact);
    let options =
        FitOptions { restarts: 2, iterations: 60, seed, most_points: 0, ..FitOptions::default() };
    let fit = must(must(Model::new(prior, data, Evidence::Auto)).fit(&options));
    let conditional = must(fit.conditional());
    let grid = must(domain.sample(400, 99));
    let exact: Vec<f64> = grid.iter().map(|x| u(&Series::plain(*x)).value()).collect();
    let range = exact.iter().fold(f64::MIN, |a, b| a.max(*b))
        - exact.iter().fold(f64::MAX, |a, b| a.min(*b));
    let mean = must(conditional.mean(&grid));
    let off = mean.iter().zip(&exact).map(|(m, u)| (m - u).abs()).fold(0.0, f64::max);
    let band = |at: &[[f64; 2]]| {
        let prediction = must(conditional.predict(at));
        prediction.standard_deviation.iter().sum::<f64>() / at.len() as f64
    };
    // A tenth from the notch, and from the five outer corners.
    let notch = band(&[[0.93, 0.93], [1.07, 0.93], [0.93, 1.07]]);
    let outer = band(&[[0.07, 0.07], [1.93, 0.07], [1.93, 0.93], [0.93, 1.93], [0.07, 1.93]]);
    (off / range, notch / outer)
}

#[test]
fn notches_with_data_edge_by_edge_are_solved() {
    type Case = (&'static str, fn(&[Series; 2]) -> Series, fn([f64; 2]) -> f64);
    let cases: [Case; 2] = [
        ("singular", rough, |_| 0.0),
        (
            "singular and smooth",
            |x| rough(x) + x[0].sin() * (&x[1] * 0.5).exp() * 0.3,
            |[x, y]| 0.3 * 0.75 * x.sin() * (0.5 * y).exp(),
        ),
    ];
    for (what, u, load) in cases {
        for seed in 0..10 {
            let (off, wider) = notched(u, load, seed);
            println!("{what} {seed}: {off:.1e} of the range, band {wider:.1} times as wide");
            assert!(off < 5e-3, "{what} {seed}: {off:e}");
            // With a smooth part it is the outer corners, without functions of their own, that are told least.
            assert!(wider > 1.0 || what != "singular", "{what} {seed}: {wider}");
        }
    }
}
