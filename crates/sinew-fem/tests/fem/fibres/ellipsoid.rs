//! The wall between two ellipsoids against the benchmark that it is from, and the angles of its rules.

use nalgebra::Vector3;
use sinew_fem::fibres::{EllipsoidWall, FibreError, FibreRule, Frame};
use sinew_mesh::TruncatedEllipsoid;
use std::f64::consts::PI;

const LAND: EllipsoidWall = EllipsoidWall::LAND;

fn wall(short: [f64; 2], long: [f64; 2], base: f64) -> Result<EllipsoidWall, FibreError> {
    EllipsoidWall::new(TruncatedEllipsoid { short, long, base })
}

/// The parametrisation of Land et al.: position, n(∂x/∂u) and n(∂x/∂v).
fn land(t: f64, u: f64, v: f64) -> [Vector3<f64>; 3] {
    let (r, l) = (7.0 + 3.0 * t, 17.0 + 3.0 * t);
    let position = Vector3::new(r * u.sin() * v.cos(), r * u.sin() * v.sin(), l * u.cos());
    let du = Vector3::new(r * u.cos() * v.cos(), r * u.cos() * v.sin(), -l * u.sin());
    let dv = Vector3::new(-r * u.sin() * v.sin(), r * u.sin() * v.cos(), 0.0);
    [position, du.normalize(), dv.normalize()]
}

#[test]
fn fibres_are_those_of_the_benchmark() {
    for t in [0.0_f64, 0.1, 0.5, 0.77, 1.0] {
        let end = -(5.0 / (17.0 + 3.0 * t)).acos();
        for step in 1..=20 {
            let u = -PI + (end + PI) * f64::from(step) / 20.0;
            for v in [-3.0, -1.5, 0.0, 0.4, 2.2] {
                let [x, du, dv] = land(t, u, v);
                let depth = LAND.depth(x.into(), 0.0).unwrap();
                assert!((depth - t).abs() < 1e-13, "{depth} at {t}");
                let (sin, cos) = (90.0 - 180.0 * t).to_radians().sin_cos();
                let expected = du * sin + dv * cos;
                let [fibre, sheet, normal] =
                    LAND.frame(x.into(), &FibreRule::NINETY, 0.0).unwrap().map(Vector3::from);
                assert!((fibre - expected).norm() < 1e-13, "{t} {u} {v}");
                assert!(sheet.dot(&du).abs() < 1e-13 && sheet.dot(&dv).abs() < 1e-13);
                assert!((fibre.cross(&sheet) - normal).norm() < 1e-15);
            }
        }
    }
}

#[test]
fn the_axis_has_a_frame_too() {
    let [fibre, sheet, _] = LAND.frame([0.0, 0.0, -18.0], &FibreRule::SIXTY, 0.0).unwrap();
    let beside = LAND.frame([1e-9, 0.0, -18.0], &FibreRule::SIXTY, 0.0).unwrap();
    assert_eq!(sheet, [0.0, 0.0, -1.0]);
    assert!((Vector3::from(fibre) - Vector3::from(beside[0])).norm() < 1e-8);
}

#[test]
fn points_beside_the_wall_are_refused() {
    let nowhere = [[0.0, 0.0, 0.0], [6.9, 0.0, 0.0], [0.0, 10.1, 0.0], [8.0, 0.0, 5.1]];
    for point in nowhere.into_iter().chain([[f64::NAN, 8.0, 0.0], [f64::INFINITY, 0.0, 0.0]]) {
        let error = LAND.frame(point, &FibreRule::SIXTY, 0.0).unwrap_err();
        assert!(matches!(error, FibreError::Outside { .. }), "{point:?}");
    }
    // A tenth of the thickness is 0.3 mm.
    assert!((LAND.depth([6.9, 0.0, 0.0], 0.1).unwrap() + 1.0 / 30.0).abs() < 1e-13);
    assert!(LAND.depth([0.0, 10.1, 0.0], 0.1).is_ok());
    assert!(LAND.depth([6.6, 0.0, 0.0], 0.1).is_err());
    assert!(LAND.depth([6.6, 0.0, 0.0], f64::NAN).is_err());
}

#[test]
fn thick_walls_are_no_harder() {
    let wall = wall([0.1, 10.0], [0.2, 20.0], 0.0).unwrap();
    for t in [0.0, 1e-3, 0.3, 1.0] {
        let point = [0.0, -(0.1 + 9.9 * t), 0.0];
        assert!((wall.depth(point, 0.5).unwrap() - t).abs() < 1e-12);
    }
}

#[test]
fn walls_without_thickness_or_base_are_refused() {
    let error = wall([7.0, 7.0], [17.0, 20.0], 5.0).unwrap_err();
    assert_eq!(
        error,
        FibreError::Unfit(
            "the short semi-axes (7, 7) must be positive, finite and ascending from endocardium to epicardium"
                .into()
        )
    );
    assert!(wall([7.0, 10.0], [17.0, f64::NAN], 5.0).is_err());
    let error = wall([7.0, 10.0], [17.0, 20.0], 18.0).unwrap_err();
    assert_eq!(
        error,
        FibreError::Unfit(
            "the base at z = 18 does not cut the inner ellipsoid of half-height 17".into()
        )
    );
}

/// A frame on the x axis, where the wall is vertical: seen from outside, circumferential is +y and the base is up.
fn close(rule: &FibreRule, x: f64, expected: Frame) {
    let frame = LAND.frame([x, 0.0, 0.0], rule, 0.1).unwrap();
    let pairs = frame.as_flattened().iter().zip(expected.as_flattened());
    // π times a depth is off by some rounding errors.
    pairs.for_each(|(a, b)| assert!((a - b).abs() < 4e-15, "{frame:?}"));
}

#[test]
fn angles_count_towards_the_base() {
    let half = 0.75_f64.sqrt();
    let rule = FibreRule::SIXTY;
    // Beyond a surface the angle is that of the surface.
    close(&rule, 6.9, [[0.0, 0.5, half], [1.0, 0.0, 0.0], [0.0, half, -0.5]]);
    close(&rule, 8.5, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
    close(&rule, 10.2, [[0.0, 0.5, -half], [1.0, 0.0, 0.0], [0.0, -half, -0.5]]);
}

#[test]
fn sheets_turn_about_the_fibre() {
    let rule = FibreRule::new(0.0, 0.0).unwrap().with_sheets(90.0, -90.0).unwrap();
    close(&rule, 6.9, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    close(&rule, 8.5, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
    close(&rule, 10.2, [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]]);
}

#[test]
fn angles_that_are_none_are_refused() {
    let error = FibreRule::new(60.0, f64::INFINITY).unwrap_err();
    assert_eq!(
        error,
        FibreError::Unfit(format!(
            "the fibre angle is {} degrees; give a finite one",
            f64::INFINITY
        ))
    );
    assert!(FibreRule::SIXTY.with_sheets(f64::NAN, 0.0).is_err());
}
