//! Every condition holds for whatever is drawn; conflicts are named.

use super::imposed::along;
use super::*;
use crate::{Condition, Derivative, Periodicity, Side};
use std::f64::consts::PI;

/// A smooth function without symmetries, standing for the latent functions of a prior.
fn wild<const D: usize>(number: usize, axes: &[usize]) -> Field<D> {
    let axes = axes.to_vec();
    field(move |x: [Series; D]| {
        axes.iter().fold(x[0].constant(1.3), |sum, d| {
            sum * 0.7 + (&x[*d] * (1.7 + 0.3 * (*d + number) as f64) + 0.4).sin()
        })
    })
}

/// Mean and features, each times a function of its axes.
fn draw<const D: usize>(problem: &Problem<D>) -> Field<D> {
    let Constraints { mean, features } = constraints(problem).unwrap();
    field(move |x: [Series; D]| {
        features.iter().enumerate().fold(mean.at(x.clone()), |sum, (number, feature)| {
            let latent = wild(number, &feature.axes).at(x.clone());
            sum + feature.factor.at(x.clone()) * latent
        })
    })
}

/// Largest distance of a drawn function from the conditions, over points of all faces.
fn miss<const D: usize>(problem: &Problem<D>) -> f64 {
    let drawn = draw(problem);
    let mut most = 0.0_f64;
    for axis in 0..D {
        let structure = AxisStructure::new(problem, axis);
        for point in problem.domain().sample(20, 5).unwrap() {
            for lift in &structure.lifts {
                let x = Series::plain(point);
                let value = lift.apply(&drawn, &x).value();
                let mut point = point;
                point[axis] = lift.end();
                most = most.max((value - lift.imposed.data.value(point)).abs());
            }
        }
    }
    most
}

/// Conditions hold up to rounding.
const TOLERANCE: f64 = 1e-9;

fn square(names: [&str; 2]) -> Domain<2> {
    Domain::cuboid([(names[0], [0.0, PI]), (names[1], [0.0, 1.0])]).unwrap()
}

#[test]
fn wave_with_insulated_ends_has_the_features_of_4_71() {
    let domain = square(["x", "t"]);
    let [dx, dt] = domain.derivatives();
    let problem = Problem::new(domain, dt * dt - dx * dx)
        .and_then(|p| p.condition("x", Side::Lower, Condition::Neumann(constant(0.0))))
        .and_then(|p| p.condition("x", Side::Upper, Condition::Neumann(constant(0.0))))
        .and_then(|p| {
            let value = field(|[x, _]| x.cos());
            let slope = field(|[x, _]| x.cos().squared());
            p.condition("t", Side::Lower, Condition::initial(value, slope))
        })
        .unwrap();
    let built = constraints(&problem).unwrap();
    let axes: Vec<_> = built.features.iter().map(|f| f.axes.clone()).collect();
    assert_eq!(axes, [vec![0, 1], vec![1], vec![1]]);
    let x: f64 = 0.7;
    let expected = x.cos() + 0.4 * x.cos().powi(2);
    assert!((built.mean.value([x, 0.4]) - expected).abs() < 1e-14);
    assert!(miss(&problem) < TOLERANCE);
}

#[test]
fn every_kind_of_condition_holds_for_whatever_is_drawn() {
    // A reference function's own values and derivatives make compatible data on all faces.
    fn u() -> Field<2> {
        field(|x: [Series; 2]| reference(&x))
    }
    let outwards = |axis: usize, side: Side, order: usize| {
        let sign = if side == Side::Lower && order % 2 == 1 { -1.0 } else { 1.0 };
        field(move |x: [Series; 2]| along(&u(), axis, order, &x) * sign)
    };
    // Without slope where y = 0, so that slopes there may be held too.
    let factor = |axis: usize| match axis {
        0 => field(|[_, y]: [Series; 2]| y.squared() + 2.0),
        _ => constant(2.0),
    };
    let kinds = |axis: usize, side: Side| {
        let slope = move || outwards(axis, side, 1);
        let given = |orders: &[usize]| {
            let given = orders.iter().map(|order| match order {
                0 => (0, u()),
                order => (*order, outwards(axis, side, *order)),
            });
            Some(Condition::Derivatives(given.collect()))
        };
        let springy = field(move |x: [Series; 2]| {
            u().at(x.clone()) * factor(axis).at(x.clone()) - slope().at(x) * 0.5
        });
        vec![
            None,
            Some(Condition::Dirichlet(u())),
            Some(Condition::Neumann(slope())),
            Some(Condition::Cauchy { value: u(), slope: slope() }),
            Some(Condition::Robin {
                value_factor: factor(axis),
                slope_factor: constant(-0.5),
                data: springy,
            }),
            given(&[0, 2]),
            given(&[3, 1]),
            given(&[2, 3]),
        ]
    };
    let mut refused = 0;
    for (lower, upper, other) in (0..512).map(|k| (k / 64, k / 8 % 8, k % 8)) {
        let mut problem = Problem::new(square(["x", "y"]), Derivative::along(0)).unwrap();
        for (axis, side, kind) in
            [("x", Side::Lower, lower), ("x", Side::Upper, upper), ("y", Side::Lower, other)]
        {
            if let Some(condition) = kinds(usize::from(axis == "y"), side)[kind].clone() {
                problem = problem.condition(axis, side, condition).unwrap();
            }
        }
        if (lower == 4 || upper == 4) && other >= 5 {
            let error = constraints(&problem).unwrap_err().to_string();
            assert!(error.contains("varies where it meets y = 0"), "{error}");
            refused += 1;
            continue;
        }
        let missed = miss(&problem);
        assert!(missed < TOLERANCE, "{lower} {upper} {other}: {missed:e}");
    }
    assert_eq!(refused, 45);
}

#[test]
fn factors_vary_on_one_axis_only() {
    let robin = |value_factor: Field<2>| Condition::Robin {
        value_factor,
        slope_factor: constant(1.0),
        data: constant(0.0),
    };
    let both = Problem::new(square(["x", "y"]), Derivative::along(0))
        .and_then(|p| p.condition("x", Side::Upper, robin(field(|[_, y]| y.squared() + 1.0))))
        .and_then(|p| p.condition("y", Side::Lower, robin(field(|[x, _]| x + 1.0))));
    let error = constraints(&both.unwrap()).unwrap_err().to_string();
    assert!(error.contains("vary on faces of both x and y"), "{error}");
}

#[test]
fn derivatives_that_make_no_condition_are_refused() {
    let problem = || Problem::new(square(["x", "y"]), Derivative::along(0)).unwrap();
    let twice = vec![(1, constant(0.0)), (1, constant(0.0))];
    for given in [twice, vec![(4, constant(0.0))], Vec::new()] {
        let refused = problem().condition("x", Side::Upper, Condition::Derivatives(given));
        let error = refused.unwrap_err().to_string();
        assert!(error.contains("give orders from 0 to 3, each once"), "{error}");
    }
}

#[test]
fn periodic_axes_join() {
    for periodicity in [Periodicity::Value, Periodicity::ValueAndSlope] {
        let problem = Problem::new(square(["x", "t"]), Derivative::along(1))
            .and_then(|p| p.periodic("x", periodicity))
            .and_then(|p| {
                let start = Condition::Dirichlet(field(|[x, _]| (x * 2.0).sin()));
                p.condition("t", Side::Lower, start)
            })
            .unwrap();
        assert!(miss(&problem) < TOLERANCE);
    }
}

#[test]
fn conflicts_are_named_by_their_corner() {
    let problem = Problem::new(square(["x", "t"]), Derivative::along(1))
        .and_then(|p| p.condition("x", Side::Upper, Condition::Dirichlet(constant(1.0))))
        .and_then(|p| p.condition("t", Side::Lower, Condition::Dirichlet(field(|[x, _]| x.sin()))))
        .unwrap();
    let error = constraints(&problem).unwrap_err();
    assert!(error.to_string().contains(&format!("corner x = {PI}, t = 0")), "{error}");
    let twice = problem.condition("x", Side::Upper, Condition::Neumann(constant(0.0)));
    assert!(twice.unwrap_err().to_string().contains("has a condition already"));
}

#[test]
fn a_polygon_in_time_keeps_its_edges_and_its_start() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.4, 1.0], [1.0, 2.0], [-0.3, 1.1]];
    let domain = Domain::prism(["x", "y"], &corners, ("t", [0.0, 1.0])).unwrap();
    let edge = || field(|[x, y, t]: [Series; 3]| x * 0.5 + y + t);
    let problem = |start| {
        Problem::new(domain.clone(), Derivative::along(2))
            .and_then(|p| p.boundary(edge()))
            .and_then(|p| p.condition("t", Side::Lower, Condition::Dirichlet(start)))
    };
    let good = problem(field(|[x, y, _]: [Series; 3]| x * 0.5 + y)).unwrap();
    let drawn = draw(&good);
    let polygon = Domain::cross_section(&domain).unwrap();
    for number in 0..corners.len() {
        let [x, y] = polygon.on_edge(number, 0.37);
        let missed = drawn.value([x, y, 0.6]) - edge().value([x, y, 0.6]);
        assert!(missed.abs() < TOLERANCE, "edge {number}: {missed:e}");
    }
    assert!(miss(&good) < TOLERANCE);
    let bad = problem(constant(0.0)).unwrap();
    assert!(constraints(&bad).unwrap_err().to_string().contains("conflict"));
    let twice = good.boundary(edge()).unwrap_err().to_string();
    assert!(twice.contains("the polygon has a condition already"), "{twice}");
    let face = bad.condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)));
    assert!(face.unwrap_err().to_string().contains("x is part of the polygon"));
}

/// A smooth function without symmetries.
fn reference([x, y]: &[Series; 2]) -> Series {
    (x * 1.3 + 0.2).sin() * (y * -0.8).exp() + x * y
}
