//! Every condition holds for whatever is drawn; conflicts are named.

use sinew_gp::{
    Condition, Constraints, Derivative, Domain, Field, Periodicity, Problem, Series, Side,
    constant, constraints, field,
};
use std::f64::consts::PI;

/// A condition with the axis and the side of its face.
type Given<const D: usize> = (usize, Side, Condition<D>);

/// Conditions hold up to rounding.
const TOLERANCE: f64 = 1e-9;

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

/// The derivative of an order along an axis.
fn derivative<const D: usize>(of: &Field<D>, x: [f64; D], axis: usize, order: usize) -> f64 {
    let mut orders = [0; D];
    orders[axis] = order;
    of.at(Series::variables(x, orders)).derivative(&orders)
}

/// Coordinate of one end of an axis.
fn end<const D: usize>(domain: &Domain<D>, axis: usize, side: Side) -> f64 {
    match side {
        Side::Lower => domain.ends()[axis][0],
        Side::Upper => domain.ends()[axis][1],
    }
}

/// Distances of a function from what a condition says of it at a point of its face.
fn misses<const D: usize>(
    drawn: &Field<D>,
    (axis, side, condition): &Given<D>,
    x: [f64; D],
) -> Vec<f64> {
    let outwards: f64 = if *side == Side::Lower { -1.0 } else { 1.0 };
    let normal = |order: usize| outwards.powi(order as i32) * derivative(drawn, x, *axis, order);
    let miss = |order: usize, data: &Field<D>| normal(order) - data.value(x);
    match condition {
        Condition::Dirichlet(value) => vec![miss(0, value)],
        Condition::Neumann(slope) => vec![miss(1, slope)],
        Condition::Cauchy { value, slope } => vec![miss(0, value), miss(1, slope)],
        Condition::Robin { value_factor, slope_factor, data } => {
            let missing = data.value(x) - value_factor.value(x) * normal(0);
            vec![normal(1) - missing / slope_factor.value(x)]
        }
        Condition::Derivatives(given) => {
            given.iter().map(|(order, data)| miss(*order, data)).collect()
        }
    }
}

/// Largest distance of a drawn function from the conditions, over points of their faces.
fn miss<const D: usize>(problem: &Problem<D>, given: &[Given<D>]) -> f64 {
    let (drawn, domain) = (draw(problem), problem.domain());
    let mut most = 0.0_f64;
    for point in domain.sample(20, 5).unwrap() {
        for own in given {
            let mut point = point;
            point[own.0] = end(domain, own.0, own.1);
            most = misses(&drawn, own, point).into_iter().fold(most, |most, m| most.max(m.abs()));
        }
    }
    most
}

/// A problem with conditions.
fn under<const D: usize>(problem: Problem<D>, given: &[Given<D>]) -> Problem<D> {
    given.iter().fold(problem, |problem, (axis, side, condition)| {
        let name = problem.domain().names()[*axis].clone();
        problem.condition(&name, *side, condition.clone()).unwrap()
    })
}

fn square(names: [&str; 2]) -> Domain<2> {
    Domain::cuboid([(names[0], [0.0, PI]), (names[1], [0.0, 1.0])]).unwrap()
}

/// A smooth function without symmetries, or its derivative of an order along an axis.
fn reference(axis: usize, order: usize, [x, y]: [Series; 2]) -> Series {
    let (rate, turned): (f64, f64) =
        if axis == 0 { (1.3, order as f64 * PI / 2.0) } else { (-0.8, 0.0) };
    let wave = (&x * 1.3 + (0.2 + turned)).sin() * (&y * -0.8).exp() * rate.powi(order as i32);
    match (order, axis) {
        (0, _) => wave + x * y,
        (1, 0) => wave + y,
        (1, _) => wave + x,
        _ => wave,
    }
}

#[test]
fn wave_with_insulated_ends_has_the_features_of_4_71() {
    let domain = square(["x", "t"]);
    let [dx, dt] = domain.derivatives();
    let value = field(|[x, _]: [Series; 2]| x.cos());
    let slope = field(|[x, _]: [Series; 2]| x.cos().squared());
    let given = [
        (0, Side::Lower, Condition::Neumann(constant(0.0))),
        (0, Side::Upper, Condition::Neumann(constant(0.0))),
        (1, Side::Lower, Condition::initial(value, slope)),
    ];
    let problem = under(Problem::new(domain, dt * dt - dx * dx).unwrap(), &given);
    let built = constraints(&problem).unwrap();
    let axes: Vec<_> = built.features.iter().map(|f| f.axes.clone()).collect();
    assert_eq!(axes, [vec![0, 1], vec![1], vec![1]]);
    let x: f64 = 0.7;
    let expected = x.cos() + 0.4 * x.cos().powi(2);
    assert!((built.mean.value([x, 0.4]) - expected).abs() < 1e-14);
    assert!(miss(&problem, &given) < TOLERANCE);
}

#[test]
fn a_slope_across_a_face_is_a_function_on_it() {
    // u = z³ where x = 1, and ∂u/∂z = 12 x² where z = 2: the mean is z³ + (z − 2) (12 x² − 12).
    let domain = Domain::cuboid([("x", [1.0, 4.0]), ("z", [0.0, 2.0])]).unwrap();
    let slope = field(|[x, _]: [Series; 2]| x.squared() * 12.0);
    let given = [
        (0, Side::Lower, Condition::Dirichlet(field(|[_, z]: [Series; 2]| z.powi(3)))),
        (1, Side::Upper, Condition::Neumann(slope)),
    ];
    let problem = under(Problem::new(domain, Derivative::along(0)).unwrap(), &given);
    let mean = constraints(&problem).unwrap().mean.at(Series::variables([3.0, 1.5], [2, 1]));
    // Rounding of numbers of about a hundred.
    let is = |orders: [usize; 2], exact: f64| {
        let found = mean.derivative(&orders);
        assert!((found - exact).abs() < 1e-12, "{orders:?}: {found}");
    };
    is([0, 0], 1.5_f64.powi(3) - 0.5 * 96.0);
    is([0, 1], 3.0 * 1.5 * 1.5 + 96.0);
    is([2, 0], -0.5 * 24.0);
    is([2, 1], 24.0);
}

#[test]
fn every_kind_of_condition_holds_for_whatever_is_drawn() {
    // A reference function's own values and derivatives make compatible data on all faces.
    let outwards = |axis: usize, side: Side, order: usize| {
        let sign = if side == Side::Lower && order % 2 == 1 { -1.0 } else { 1.0 };
        field(move |x: [Series; 2]| reference(axis, order, x) * sign)
    };
    let u = || field(|x: [Series; 2]| reference(0, 0, x));
    // Without slope where y = 0, so that slopes there may be held too.
    let factor = |axis: usize| match axis {
        0 => field(|[_, y]: [Series; 2]| y.squared() + 2.0),
        _ => constant(2.0),
    };
    let kinds = |axis: usize, side: Side| {
        let slope = || outwards(axis, side, 1);
        let given = |orders: &[usize]| {
            let given = orders.iter().map(|order| (*order, outwards(axis, side, *order)));
            Some(Condition::Derivatives(given.collect()))
        };
        let (value, spring, own) = (u(), factor(axis), slope());
        let springy = field(move |x: [Series; 2]| {
            value.at(x.clone()) * spring.at(x.clone()) - own.at(x) * 0.5
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
        let faces = [(0, Side::Lower, lower), (0, Side::Upper, upper), (1, Side::Lower, other)];
        let own = |(axis, side, kind): (usize, Side, usize)| {
            kinds(axis, side)[kind].clone().map(|condition| (axis, side, condition))
        };
        let given: Vec<Given<2>> = faces.into_iter().filter_map(own).collect();
        let problem = Problem::new(square(["x", "y"]), Derivative::along(0)).unwrap();
        let problem = under(problem, &given);
        if (lower == 4 || upper == 4) && other >= 5 {
            let error = constraints(&problem).unwrap_err().to_string();
            assert!(error.contains("varies where it meets y = 0"), "{error}");
            refused += 1;
            continue;
        }
        let missed = miss(&problem, &given);
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
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| (x * 2.0).sin()));
    let start = [(1, Side::Lower, start)];
    for (periodicity, orders) in [(Periodicity::Value, 1), (Periodicity::ValueAndSlope, 2)] {
        let problem = Problem::new(square(["x", "t"]), Derivative::along(1))
            .and_then(|p| p.periodic("x", periodicity));
        let problem = under(problem.unwrap(), &start);
        assert!(miss(&problem, &start) < TOLERANCE);
        let drawn = draw(&problem);
        for [_, t] in problem.domain().sample(20, 5).unwrap() {
            for order in 0..orders {
                let at = |x: f64| derivative(&drawn, [x, t], 0, order);
                let jump = at(PI) - at(0.0);
                assert!(jump.abs() < TOLERANCE, "{periodicity:?} {order}: {jump:e}");
            }
        }
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
fn a_polygon_keeps_its_edges() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.4, 1.0], [1.0, 2.0], [-0.3, 1.1]];
    let domain = Domain::polygon(["x", "y"], &corners).unwrap();
    let edge = || field(|[x, y]: [Series; 2]| x * 0.5 + y.squared());
    let free = Problem::new(domain.clone(), Derivative::along(1)).unwrap();
    let held = free.boundary(edge()).unwrap();
    let drawn = draw(&held);
    let polygon = domain.cross_section().unwrap();
    for number in 0..corners.len() {
        let place = polygon.on_edge(number, 0.37);
        let missed = drawn.value(place) - edge().value(place);
        assert!(missed.abs() < TOLERANCE, "edge {number}: {missed:e}");
    }
    let face = held.clone().condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)));
    assert!(face.unwrap_err().to_string().contains("x is part of the polygon"));
    let twice = held.boundary(edge()).unwrap_err().to_string();
    assert!(twice.contains("the polygon has a condition already"), "{twice}");
}
