//! Coordinates of displacements: scales, supports, principal directions and the polynomials that they follow.

use sinew_emulate::coordinates::{
    CoordinateError, Coordinates, Dirichlet, OutputScale, ParameterScaling, PrincipalDirections,
};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Parameter, Scene, Support};
use sinew_mesh::box_tetrahedra;

#[test]
fn a_log_box_maps_to_unit_variance() {
    let scaling = ParameterScaling::logarithmic(&[50.0], &[100.0]).unwrap();
    let bound = 3f64.sqrt(); // a uniform distribution of unit variance ends at ±√3
    assert!((scaling.standardise(&[50.0]).unwrap()[0] + bound).abs() < 1e-12);
    assert!((scaling.standardise(&[100.0]).unwrap()[0] - bound).abs() < 1e-12);
    assert!(scaling.standardise(&[5000f64.sqrt()]).unwrap()[0].abs() < 1e-12);
    assert!(scaling.require_inside(0, &[100.0]).is_ok());
    assert!(scaling.require_inside(0, &[100.1]).is_err());
    assert!((scaling.unstandardise(&[-bound]).unwrap()[0] - 50.0).abs() < 1e-9);
    assert!(scaling.unstandardise(&[]).is_err());
}

#[test]
fn slopes_are_the_derivative() {
    let parameters =
        [Parameter::linear("a", "1", -1.0..=3.0), Parameter::log("b", "1", 0.1..=10.0)];
    let scaling = ParameterScaling::new(&parameters).unwrap();
    let (theta, step) = ([0.4, 1.7], 1e-6);
    let slopes = scaling.slopes(&theta);
    for parameter in 0..2 {
        let mut ahead = theta;
        ahead[parameter] += step;
        let change = scaling.standardise(&ahead).unwrap()[parameter]
            - scaling.standardise(&theta).unwrap()[parameter];
        assert!((change / step - slopes[parameter]).abs() < 1e-5);
    }
}

#[test]
fn bad_parameters_are_named() {
    for (lower, upper, said) in [
        (&[0.0][..], &[1.0][..], "parameter 0 is 0, but its scale is logarithmic"),
        (&[1.0, 2.0], &[2.0, 2.0], "parameter 1 ranges from 2 to 2"),
    ] {
        let refused = ParameterScaling::logarithmic(lower, upper).unwrap_err();
        assert!(refused.to_string().starts_with(said), "{refused}");
    }
    let scaling = ParameterScaling::logarithmic(&[1.0], &[2.0]).unwrap();
    assert!(matches!(scaling.standardise(&[f64::NAN]), Err(CoordinateError::NotFinite { .. })));
    assert!(matches!(scaling.standardise(&[1.0, 1.0]), Err(CoordinateError::Count { .. })));
}

#[test]
fn a_resting_component_gets_a_share_of_the_largest_scale() {
    let displacement = [0.0, 3.0, 0.0, -3.0];
    let scale = OutputScale::root_mean_square(2, [&displacement[..]]).unwrap();
    assert_eq!(scale.scale, [3e-3, 3.0]);
    assert!(matches!(OutputScale::standardising(2, []), Err(CoordinateError::Scale { .. })));
    assert!(matches!(OutputScale::standardising(0, []), Err(CoordinateError::Scale { .. })));
}

#[test]
fn every_node_has_its_own_mean() {
    let (first, second) = ([0.0, 3.0, 0.0, 9.0], [0.0, 5.0, 0.0, 7.0]);
    let scale = OutputScale::standardising(4, [&first[..], &second[..]]).unwrap();
    assert_eq!(scale.mean, [0.0, 4.0, 0.0, 8.0]);
    assert_eq!(scale.scale, [1e-3, 1.0, 1e-3, 1.0]);
    assert!(scale.check(2, 4).is_ok() && scale.check(2, 6).is_err());
    let uneven = OutputScale::standardising(4, [&first[..], &second[..2]]);
    assert!(matches!(uneven, Err(CoordinateError::Count { .. })));
}

#[test]
fn supports_leave_what_they_do_not_hold() {
    let lowered = |support| {
        let scene = Scene::new(box_tetrahedra([1.0; 3], [1; 3]), NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
            .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
            .support(Support::clamped("x_min"));
        scene.support(support).lower().unwrap()
    };
    let close = |found: &[f64], expected: &[f64]| {
        let pairs = found.iter().zip(expected);
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}");
    };
    // Held by 0.5 along (3, 0, 4) / 5, and free across it.
    let body = lowered(Support::along("x_max", [3.0, 0.0, 4.0], 0.5));
    let dirichlet = Dirichlet::of_body(&body);
    assert_eq!(dirichlet.axes.len(), 4);
    let node = *dirichlet.axes.keys().next().unwrap();
    let projector = &dirichlet.projectors(3)[9 * node..9 * node + 9];
    close(projector, &[0.64, 0.0, -0.48, 0.0, 1.0, 0.0, -0.48, 0.0, 0.36]);
    close(&dirichlet.held(3)[3 * node..3 * node + 3], &[0.3, 0.0, 0.4]);
    // Along an axis no frame is needed.
    let body = lowered(Support::along("x_max", [0.0, 2.0, 0.0], 0.5));
    let dirichlet = Dirichlet::of_body(&body);
    assert!(dirichlet.axes.is_empty());
    close(&dirichlet.projectors(3)[9 * node..9 * node + 9], &[1., 0., 0., 0., 0., 0., 0., 0., 1.]);
    close(&dirichlet.held(3)[3 * node..3 * node + 3], &[0.0, 0.5, 0.0]);
}

fn mapped(basis: &PrincipalDirections, output: &[f64]) -> Vec<f64> {
    basis.moved(output).iter().zip(basis.origin()).map(|(du, u)| u + du).collect()
}

fn about_trend(
    fields: &[Vec<f64>],
    parameters: &[Vec<f64>],
    power: f64,
) -> Result<PrincipalDirections, CoordinateError> {
    PrincipalDirections::about_trend(fields.iter().map(Vec::as_slice), parameters, power)
}

/// Directions of simulations without parameters.
fn about_mean(fields: &[Vec<f64>], power: f64) -> Result<PrincipalDirections, CoordinateError> {
    about_trend(fields, &vec![Vec::new(); fields.len()], power)
}

#[test]
fn a_basis_survives_storage_bit_for_bit() {
    let fields = [vec![0.0, 1.0, 2.0], vec![0.5, 0.1, -1.0], vec![1.0, 1.0, 1.0]];
    let basis = about_mean(&fields, 1.0).unwrap();
    let text = serde_json::to_string(&basis).unwrap();
    assert_eq!(serde_json::from_str::<PrincipalDirections>(&text).unwrap(), basis);
    let cut = text.replacen("\"columns\":3", "\"columns\":2", 1);
    assert!(serde_json::from_str::<PrincipalDirections>(&cut).is_err());
}

#[test]
fn principal_outputs_spread_as_the_simulations_do() {
    // Along e = (3, 0, 4)/5 with deviation 10, along y with deviation 0.1.
    let at = |a: f64, b: f64| vec![1.0 + 6.0 * a, 2.0 + 0.1 * b, 3.0 + 8.0 * a];
    let fields = [at(1.0, 1.0), at(1.0, -1.0), at(-1.0, 1.0), at(-1.0, -1.0)];
    let basis = about_mean(&fields, 1.0).unwrap();
    let stored = serde_json::to_value(&basis).unwrap();
    let columns = stored["factors"].as_array().unwrap().iter().map(|factor| &factor["columns"]);
    assert_eq!(columns.filter_map(|count| count.as_u64()).min(), Some(2));
    for (found, expected) in basis.origin().iter().zip([1.0, 2.0, 3.0]) {
        assert!((found - expected).abs() < 1e-12);
    }
    let found = mapped(&basis, &[0.6, 1.0, 0.8]);
    for (found, expected) in found.iter().zip([7.0, 2.1, 11.0]) {
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }
    // What no simulation does is not predicted.
    let found = mapped(&basis, &[0.8, 0.0, -0.6]);
    assert!((found[0] - 1.0).abs() < 1e-5 && (found[2] - 3.0).abs() < 1e-5);
    // A smaller power widens the small deviations: √(0.1 / 10) · 10.
    let wide = about_mean(&fields, 0.5).unwrap();
    assert!((mapped(&wide, &[0.0, 1.0, 0.0])[1] - 3.0).abs() < 1e-5);
    // Row i of the matrix of the pull-back is column i of that of the map; more numbers than a sum has lanes.
    let fields: Vec<Vec<f64>> =
        (1..5).map(|k| (0..11).map(|i| ((k * i) as f64).sin()).collect()).collect();
    let basis = about_mean(&fields, 0.7).unwrap();
    let unit = |i: usize| (0..11).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>();
    for (i, j) in (0..11).flat_map(|i| (0..11).map(move |j| (i, j))) {
        let (forward, back) = (basis.moved(&unit(i))[j], basis.pull_back(&unit(j))[i]);
        assert!((forward - back).abs() < 1e-14, "{forward} {back}");
    }
}

#[test]
fn simulations_that_do_not_differ_span_nothing() {
    let same = [vec![1.0, 2.0], vec![1.0, 2.0]];
    assert!(about_mean(&same, 1.0).is_err());
    assert!(about_mean(&[vec![1.0, 2.0]], 1.0).is_err());
    assert!(about_mean(&[vec![1.0, f64::NAN], vec![1.0, 2.0]], 1.0).is_err());
    assert!(about_mean(&[], 1.0).is_err());
}

#[test]
fn the_polynomial_of_principal_directions_has_the_order_of_the_simulations() {
    let parameters: Vec<Vec<f64>> =
        (0..12).map(|i| vec![(1.3 * i as f64).sin(), (2.1 * i as f64).cos()]).collect();
    // Simulations of one number.
    let fitted = |value: &dyn Fn(f64, f64) -> f64, count: usize| {
        let fields = parameters[..count].iter().map(|p| vec![value(p[0], p[1])]);
        about_trend(&fields.collect::<Vec<_>>(), &parameters[..count], 1.0).unwrap()
    };
    let square = |p: f64, q: f64| 2.0 + p - 3.0 * q + 0.5 * p * p - p * q + 4.0 * q * q;
    let basis = fitted(&square, 12);
    // Outputs are in units of a deviation: relative to the first coefficient, which is one.
    let unit = basis.slopes()[0][0];
    let found: Vec<f64> = basis.slopes().iter().map(|slope| slope[0] / unit).collect();
    assert_eq!(found.len(), 5);
    for (found, expected) in found.iter().zip([1.0, -3.0, 0.5, -1.0, 4.0]) {
        assert!((found - expected).abs() < 1e-11, "{found} {expected}");
    }
    let constant = basis.origin()[0];
    assert!((constant - 2.0).abs() < 1e-11);
    let coordinates = Coordinates::Principal(basis);
    for p in &parameters {
        let found = constant + coordinates.expansion(p, None)[0] / unit;
        assert!((found - square(p[0], p[1])).abs() < 1e-11, "{found}");
    }
    // Noise has no order: more terms predict it worse.
    assert_eq!(fitted(&|p, q| (1e3 * (p + 2.0 * q)).sin(), 12).slopes().len(), 0);
    // Too few values for second order, and parameters that do not differ for any.
    assert_eq!(fitted(&|p, q| p - q, 5).slopes().len(), 2);
    let fields = [0.0, 0.0, 1.0, -1.0, 1.0, -1.0].map(|value| vec![value]);
    let same = vec![vec![0.3, 0.4]; 6];
    assert_eq!(about_trend(&fields, &same, 1.0).unwrap().slopes().len(), 0);
}
