//! Every condition holds for whatever is drawn; conflicts are named.

use super::imposed::along;
use super::*;
use crate::condition::{Condition, Periodicity};
use crate::domain::Side;
use crate::operator::Derivative;
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
    sum(constraints(problem).unwrap())
}

fn sum<const D: usize>(Constraints { mean, features }: Constraints<D>) -> Field<D> {
    field(move |x: [Series; D]| {
        features.iter().enumerate().fold(mean.at(x.clone()), |sum, (number, feature)| {
            let mut at = x.clone();
            if let Some([tx, ty]) = feature.direction {
                (at[0], at[1]) = (&x[0] * tx + &x[1] * ty, x[0].constant(0.0));
            }
            let latent = wild(number, &feature.axes).at(at);
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
        field(move |x: [Series; 2]| along(&u(), &[[1.0, 0.0], [0.0, 1.0]][axis], order, &x) * sign)
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
    let polygon = Domain::polygon(["x", "y"], &L_SHAPE).unwrap();
    let edge = Problem::new(polygon, Derivative::along(0))
        .and_then(|p| p.edge(1, Condition::simply_supported()));
    assert!(edge.unwrap_err().to_string().contains("use Dirichlet, Neumann"));
    let prism = Domain::prism(["x", "y"], &L_SHAPE, ("t", [0.0, 1.0])).unwrap();
    let robin = Condition::Robin {
        value_factor: field(|[_, _, t]: [Series; 3]| t + 1.0),
        slope_factor: constant(1.0),
        data: constant(0.0),
    };
    let edge = Problem::new(prism, Derivative::along(0)).and_then(|p| p.edge(1, robin));
    assert!(edge.unwrap_err().to_string().contains("varies along the third axis"));
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
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
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
    for number in 0..6 {
        let [x, y] = polygon.on_edge(number, 0.37);
        let missed = drawn.value([x, y, 0.6]) - edge().value([x, y, 0.6]);
        assert!(missed.abs() < TOLERANCE, "edge {number}: {missed:e}");
    }
    assert!(miss(&good) < TOLERANCE);
    let bad = problem(constant(0.0)).unwrap();
    assert!(constraints(&bad).unwrap_err().to_string().contains("conflict"));
    let face = bad.condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)));
    assert!(face.unwrap_err().to_string().contains("x is part of the polygon"));
}

/// A reference function and its derivative along a direction: compatible data for all edges.
fn reference([x, y]: &[Series; 2]) -> Series {
    (x * 1.3 + 0.2).sin() * (y * -0.8).exp() + x * y
}

fn reference_slope([nx, ny]: [f64; 2]) -> Field<2> {
    field(move |[x, y]: [Series; 2]| {
        let (angle, decay) = (&x * 1.3 + 0.2, (&y * -0.8).exp());
        let by_x = angle.cos() * &decay * 1.3 + &y;
        let by_y = angle.sin() * &decay * -0.8 + &x;
        by_x * nx + by_y * ny
    })
}

fn edge_condition(kind: usize, outwards: [f64; 2]) -> Option<Condition<2>> {
    let value = || field(|x: [Series; 2]| reference(&x));
    let slope = move || reference_slope(outwards);
    match kind {
        0 => None,
        1 => Some(Condition::Dirichlet(value())),
        2 => Some(Condition::Neumann(slope())),
        3 => Some(Condition::Cauchy { value: value(), slope: slope() }),
        _ => Some(Condition::Robin {
            value_factor: field(|[x, y]: [Series; 2]| x * 0.4 + y * 0.7 + 2.0),
            slope_factor: constant(-0.5),
            data: field(move |x: [Series; 2]| {
                let factor = &x[0] * 0.4 + &x[1] * 0.7 + 2.0;
                reference(&x) * factor - reference_slope(outwards).at(x) * 0.5
            }),
        }),
    }
}

const L_SHAPE: [[f64; 2]; 6] =
    [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

/// A polygon whose edges take turns in their kinds of condition.
fn polygon_problem(corners: &[[f64; 2]], first: usize) -> Problem<2> {
    let domain = Domain::polygon(["x", "y"], corners).unwrap();
    let edges = domain.cross_section().unwrap().edges().to_vec();
    edges.iter().enumerate().fold(
        Problem::new(domain, Derivative::along(0)).unwrap(),
        |problem, (number, edge)| {
            let kind = (first + number * (1 + first % 3)) % 5;
            match edge_condition(kind, edge.normal.map(|n| -n)) {
                Some(condition) => problem.edge(number, condition).unwrap(),
                None => problem,
            }
        },
    )
}

#[test]
fn conditions_on_edges_hold_for_whatever_is_drawn() {
    let pentagon: Vec<[f64; 2]> = (0..5)
        .map(|k| 0.4 * PI * f64::from(k) + 0.3)
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    // Convex, with a notch, with a corner in line, and small.
    let in_line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.2, 1.3]];
    let small = L_SHAPE.map(|corner| corner.map(|c| c * 1e-3));
    for corners in [&pentagon[..], &L_SHAPE, &in_line, &small] {
        for first in (0..15).step_by(4) {
            let problem = polygon_problem(corners, first);
            let drawn = draw(&problem);
            let polygon = problem.domain().cross_section().unwrap();
            for edge in 0..corners.len() {
                for fraction in [0.03, 0.5, 0.71] {
                    let x = Series::plain(polygon.on_edge(edge, fraction));
                    for lift in on_edge(&problem, edge) {
                        let value = lift.apply(&drawn, &x).value();
                        let missed = value - lift.data.at(x.clone()).value();
                        // Slopes are of size 1 / length.
                        let size = 1.0 / polygon.size().min(1.0);
                        assert!(
                            missed.abs() < TOLERANCE * size,
                            "{corners:?} {first}, edge {edge}: {missed:e}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn blends_are_smooth_at_corners() {
    // Around a corner, the gradient of all but the bubble has one limit.
    for first in 0..15 {
        let problem = polygon_problem(&L_SHAPE, first);
        let mut built = constraints(&problem).unwrap();
        built.features.remove(0);
        let drawn = sum(built);
        for (corner, directions) in
            [([0.0, 0.0], [[0.9, 0.3], [0.4, 0.8]]), ([1.0, 1.0], [[-0.9, 0.3], [0.3, -0.9]])]
        {
            let gradient = |[dx, dy]: [f64; 2]| {
                const RADIUS: f64 = 1e-5;
                let at = [corner[0] + RADIUS * dx, corner[1] + RADIUS * dy];
                let value = drawn.at(Series::variables(at, [1, 1]));
                [value.derivative(&[1, 0]), value.derivative(&[0, 1])]
            };
            let [a, b] = directions.map(gradient);
            let apart = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
            assert!(apart < 1e-2, "{first} {corner:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn equal_data_on_all_edges_need_no_blending() {
    let problem = polygon_problem(&L_SHAPE, 0).domain().clone();
    let problem = (0..6)
        .fold(Problem::new(problem, Derivative::along(0)).unwrap(), |problem, edge| {
            problem.edge(edge, edge_condition(1, [1.0, 0.0]).unwrap()).unwrap()
        });
    let mean = constraints(&problem).unwrap().mean;
    for point in problem.domain().sample(20, 3).unwrap() {
        let exact = reference(&Series::plain(point)).value();
        assert!((mean.value(point) - exact).abs() < 1e-12);
    }
}

#[test]
fn conflicts_on_edges_are_named() {
    let domain = || Domain::polygon(["x", "y"], &L_SHAPE).unwrap();
    let problem = |edges: &[(usize, Condition<2>)]| {
        edges.iter().fold(Problem::new(domain(), Derivative::along(0)), |problem, (edge, c)| {
            problem.and_then(|p| p.edge(*edge, c.clone()))
        })
    };
    let values = problem(&[
        (0, Condition::Dirichlet(constant(0.0))),
        (1, Condition::Dirichlet(constant(1.0))),
    ]);
    let error = constraints(&values.unwrap()).unwrap_err();
    assert!(error.to_string().contains("corner x = 2, y = 0"), "{error}");
    // At a right angle, the slope along one edge is that across the other.
    let slopes = problem(&[
        (0, Condition::Dirichlet(field(|[x, _]: [Series; 2]| x * 3.0))),
        (1, Condition::Neumann(constant(2.0))),
    ]);
    let error = constraints(&slopes.unwrap()).unwrap_err();
    assert!(error.to_string().contains("conflict"), "{error}");
    let twice =
        problem(&[(2, Condition::Neumann(constant(0.0))), (2, Condition::Neumann(constant(0.0)))]);
    assert!(
        twice.unwrap_err().to_string().contains("edge 2 of the polygon has a condition already")
    );
    let unknown = problem(&[(6, Condition::Neumann(constant(0.0)))]).unwrap_err();
    assert!(unknown.to_string().contains("no edge 6; the polygon has 6"), "{unknown}");
}

#[test]
fn a_prism_in_time_keeps_fluxes_through_its_edges() {
    // u = (x + y²) (1 + t) with a flux on every other edge.
    let domain = Domain::prism(["x", "y"], &L_SHAPE, ("t", [0.0, 1.0])).unwrap();
    let edges = domain.cross_section().unwrap().edges().to_vec();
    let exact = |[x, y, t]: [Series; 3]| (x + y.squared()) * (t + 1.0);
    let problem = |start: Field<3>| {
        let problem = Problem::new(domain.clone(), Derivative::along(2)).unwrap();
        let problem = edges.iter().enumerate().fold(problem, |problem, (number, edge)| {
            let [nx, ny] = edge.normal.map(|n| -n);
            let slope = field(move |[_, y, t]: [Series; 3]| (y * (2.0 * ny) + nx) * (t + 1.0));
            let condition = match number % 2 {
                0 => Condition::Dirichlet(field(exact)),
                _ => Condition::Neumann(slope),
            };
            problem.edge(number, condition).unwrap()
        });
        problem.condition("t", Side::Lower, Condition::Dirichlet(start)).unwrap()
    };
    let good = problem(field(|[x, y, _]: [Series; 3]| x + y.squared()));
    let drawn = draw(&good);
    assert!(miss(&good) < TOLERANCE);
    for edge in 0..6 {
        let [x, y] = good.domain().cross_section().unwrap().on_edge(edge, 0.37);
        let at = Series::plain([x, y, 0.6]);
        for lift in on_edge(&good, edge) {
            let missed = lift.apply(&drawn, &at).value() - lift.data.at(at.clone()).value();
            assert!(missed.abs() < TOLERANCE, "edge {edge}: {missed:e}");
        }
    }
    let bad = problem(field(|[x, _, _]: [Series; 3]| x));
    assert!(constraints(&bad).unwrap_err().to_string().contains("conflict"));
}
