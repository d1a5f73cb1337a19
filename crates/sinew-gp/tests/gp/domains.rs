//! Domains, functions that vanish on the edges of polygons, and integrals.

use sinew_gp::{Derivative, Domain, Functional, Operator, Problem, Side, constant, constraints};

#[test]
fn bad_axes_are_named() {
    let empty = Domain::interval("x", [1.0, 1.0]).unwrap_err();
    assert!(empty.to_string().contains("axis x runs from 1 to 1"));
    let twice = Domain::cuboid([("x", [0.0, 1.0]), ("x", [0.0, 1.0])]).unwrap_err();
    assert!(twice.to_string().contains("two axes are called x"));
    let interval = Domain::interval("x", [0.0, 1.0]).unwrap();
    let unknown = interval.on_face("y", Side::Lower, 1, 1).unwrap_err();
    assert!(unknown.to_string().contains("no axis y"));
}

#[test]
fn samples_and_grids_lie_inside() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [1.0, 2.0], [0.0, 1.0]];
    let domain = Domain::polygon(["x", "y"], &corners).unwrap();
    assert_eq!(domain.ends(), [[0.0, 2.0]; 2]);
    let points = domain.sample(200, 1).unwrap();
    assert_eq!(points.len(), 200);
    assert!(points.iter().all(|p| domain.contains(*p)));
    assert!(!domain.contains([1.8, 1.0]), "outside of the polygon, inside of its box");
    assert_eq!(Domain::interval("x", [0.0, 1.0]).unwrap().grid(3), [[0.0], [0.5], [1.0]]);
}

/// Winding number by angles: an independent test for lying inside.
fn inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let angle: f64 = (0..corners.len())
        .map(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            let (a, b) = ([a[0] - x, a[1] - y], [b[0] - x, b[1] - y]);
            (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
        })
        .sum();
    angle.abs() > 3.0
}

#[test]
fn features_vanish_on_edges_and_are_positive_inside() {
    let shapes: [&[[f64; 2]]; 4] = [
        &[[0.0, 1.0], [-0.95, 0.31], [-0.59, -0.81], [0.59, -0.81], [0.95, 0.31]],
        // Slender, small, and clockwise.
        &[[0.0, 0.0], [5.0, 0.2], [5.1, 0.5], [0.0, 0.3]],
        &[[0.0, 0.0], [1e-3, 2e-4], [3e-4, 9e-4]],
        &[[0.0, 2.0], [2.0, 2.0], [2.0, 0.0], [0.0, 0.0]],
    ];
    for corners in shapes {
        check_features(corners);
    }
}

/// The conjunction and the product of the distances from the edges.
fn check_features(corners: &[[f64; 2]]) {
    let domain = Domain::polygon(["x", "y"], corners).unwrap();
    let held = Problem::new(domain.clone(), Derivative::along(0))
        .and_then(|problem| problem.boundary(constant(0.0)));
    let features = constraints(&held.unwrap()).unwrap().features;
    assert_eq!(features.len(), 2);
    let features = |point| [0, 1].map(|k: usize| features[k].factor.value(point));
    let [[left, right], [bottom, top]] = domain.ends();
    for k in 0..900 {
        let point = [
            left + (right - left) * (f64::from(k % 30) + 0.37) / 30.0,
            bottom + (top - bottom) * (f64::from(k / 30) + 0.41) / 30.0,
        ];
        let within = inside(corners, point);
        assert_eq!(domain.contains(point), within, "{point:?}");
        let [conjunction, product] = features(point);
        assert_eq!(within, conjunction > 0.0, "{point:?} {conjunction}");
        assert!(!within || 0.0 < product && product.max(conjunction) < 1.1, "{point:?} {product}");
    }
    let polygon = domain.cross_section().unwrap();
    for edge in 0..corners.len() {
        for place in [polygon.on_edge(edge, 0.3), polygon.corners()[edge]] {
            let values = features(place);
            assert!(values.iter().all(|value| value.abs() < 1e-12), "{place:?}: {values:?}");
        }
    }
}

#[test]
fn unusable_polygons_are_refused() {
    let star = |k: usize| 0.8 * std::f64::consts::PI * k as f64;
    let notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    for (corners, problem) in [
        (vec![[0.0, 0.0], [1.0, 0.0]], "at least three"),
        (vec![[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]], "finite coordinates"),
        (notched.to_vec(), "its corner (1, 1) is re-entrant"),
        (vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]], "its corner (1, 0)"),
        (vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "its corner (1, 0)"),
        (vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], "in line"),
        ((0..5).map(|k| [star(k).cos(), star(k).sin()]).collect(), "edges cross"),
    ] {
        let error = Domain::polygon(["x", "y"], &corners).unwrap_err().to_string();
        assert!(error.contains(problem), "{error}");
    }
}

#[test]
fn integrals_are_exact_for_polynomials() {
    let unit = Domain::interval("x", [0.0, 1.0]).unwrap();
    for count in 1..8 {
        let rule = Functional::integral(&unit, Operator::identity(), count).unwrap();
        assert_eq!((rule.points.len(), rule.weights.len()), (count, count));
        for power in 0..2 * count {
            let terms = rule.points.iter().zip(&rule.weights);
            let found: f64 = terms.map(|([x], w)| w * x.powi(power as i32)).sum();
            let mean = 1.0 / (power as f64 + 1.0);
            // Rounding of a sum of seven terms below one.
            assert!((found - mean).abs() < 1e-14, "{count} {power}: {found}");
        }
    }
}

#[test]
fn integrals_of_one_are_sizes() {
    let domain = Domain::cuboid([("x", [0.0, 2.0]), ("y", [1.0, 4.0])]).unwrap();
    let area = Functional::integral(&domain, Operator::identity(), 3).unwrap();
    assert!((area.weights.iter().sum::<f64>() - 6.0).abs() < 1e-13);
    let edge =
        Functional::face_integral(&domain, ("x", Side::Upper), Operator::identity(), 3).unwrap();
    assert!(edge.points.iter().all(|p| p[0] == 2.0));
    assert!((edge.weights.iter().sum::<f64>() - 3.0).abs() < 1e-13);
}
