//! The mixed elements of Taylor and Hood against closed forms and the literature.

use crate::elements::scene::{node_at, roller, scene};
use crate::membrane::cook_membrane;
use crate::shells::{cylinder_quarter, sphere_octant};
use sinew_energy::laws::{NeoHookean, NeoHookeanShape};
use sinew_energy::{Body, Load, Magnitude, Support};
use sinew_fem::{CurvePoint, Line, Options, Solution, SolveError, Solver};
use sinew_mesh::{box_tetrahedra, rectangle_triangles};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6};

/// Without its volumetric part (λ = 0) the law leaves all of the volume to the field of pressure.
const PLAIN: NeoHookean = NeoHookean;
/// Accuracy of two or three quadratic elements through the wall.
const CLOSE: f64 = 0.005;

/// A thick shell of radii 1 and 2 and μ = 1, inflated through its limit point: the pressure at inner radius a is
/// `p = 2/λ_b + 1/(2λ_b⁴) − 2/λ_a − 1/(2λ_a⁴)` with `λ_a = a`, `λ_b³ = (7 + a³)/8`
/// (A. E. Green, W. Zerna, Theoretical Elasticity, 1954).
#[test]
fn a_thick_sphere_passes_its_limit_point() {
    const LARGEST: f64 = 0.816423647955; // at a = 1.82814731
    let exact = |a: f64| {
        let b = ((7.0 + a.powi(3)) / 8.0).cbrt();
        2.0 / b + 0.5 / b.powi(4) - 2.0 / a - 0.5 / a.powi(4)
    };
    let mesh = sphere_octant([1.0, 2.0], [2, 3]).quadratic_tetrahedra();
    let load = Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Fixed(1.0) };
    let planes = [("x_min", 0), ("y_min", 1), ("z_min", 2)].map(|(set, axis)| roller(set, axis));
    let sphere = scene(PLAIN, mesh, vec![load], planes.into()).mixed();
    let body = sphere.lower().unwrap();
    let pole = node_at(sphere.mesh.points(), [1.0, 0.0, 0.0]);
    let mut solver = Solver::new(&body).unwrap();
    let curve = solver.follow(&Line::of_loads(&[1.0, 0.0]), &Options::default()).unwrap();
    let (mut radii, mut largest) = (Vec::new(), 0.0_f64);
    for point in curve.with_longest_step(0.3).unwrap().skip(1) {
        let CurvePoint { place, solution, .. } = point.unwrap();
        let Solution { displacement, load_factor, .. } = solution;
        assert!((load_factor - place).abs() < 1e-15);
        let radius = (1.0 + swept(&body, &displacement) / FRAC_PI_6).cbrt();
        let pressure = exact(radius);
        assert!((load_factor / pressure - 1.0).abs() < CLOSE, "a = {radius}: {load_factor}");
        // A single node is less exact than the volume that all enclose.
        let pole = 1.0 + displacement[3 * pole];
        assert!((pole / radius - 1.0).abs() < 2.0 * CLOSE, "a = {radius}: {pole}");
        (largest, _) = (largest.max(load_factor), radii.push(radius));
        if radius > 3.0 {
            assert!(load_factor < 0.66, "{load_factor}");
            break;
        }
    }
    assert!(radii.windows(2).all(|pair| pair[0] < pair[1]) && radii[radii.len() - 1] > 3.0);
    assert!((largest / LARGEST - 1.0).abs() < CLOSE, "{largest}");
}

/// Volume that the loaded surface has swept.
fn swept(body: &Body, displacement: &[f64]) -> f64 {
    -body.pressures[0].value(displacement, &[])
}

/// A quarter of a thick tube of radii 1 and 2 and μ = 1 in plane strain: `p = ½[2 ln(λ_a/λ_b) + 1/λ_b² − 1/λ_a²]`
/// with `λ_a = a`, `λ_b² = (3 + a²)/4`. Inner radius and pressure.
const TUBE: [(f64, f64); 4] =
    [(1.1, 0.131562278444), (1.3, 0.313376398042), (1.5, 0.428228409097), (2.0, 0.574053572307)];

fn tube_of_triangles() -> Body {
    let mut mesh = rectangle_triangles([1.0; 2], [3, 4]).quadratic();
    mesh.map_points(|[x, y, _]| {
        let (sine, cosine) = (FRAC_PI_2 * y).sin_cos();
        [(1.0 + x) * cosine, (1.0 + x) * sine, 0.0]
    });
    let load = Load::Pressure { facets: "x_min".into(), magnitude: Magnitude::Fixed(1.0) };
    let supports = vec![roller("y_min", 1), roller("y_max", 0)];
    scene(PLAIN, mesh, vec![load], supports).mixed().lower().unwrap()
}

#[test]
fn a_thick_tube_of_triangles_inflates_as_the_closed_form_says() {
    let body = tube_of_triangles();
    let mut solver = Solver::new(&body).unwrap();
    let line = Line { load_factors: [0.0, 0.574], thetas: [vec![1.0, 0.0], vec![1.0, 0.0]] };
    let mut largest = 0.0;
    for point in solver.follow(&line, &Options::default()).unwrap().skip(1) {
        let Solution { displacement, load_factor, .. } = point.unwrap().solution;
        let a = (1.0 + swept(&body, &displacement) / FRAC_PI_4).sqrt();
        let b = ((3.0 + a * a) / 4.0).sqrt();
        let pressure = 0.5 * (2.0 * (a / b).ln() + b.powi(-2) - a.powi(-2));
        assert!((load_factor / pressure - 1.0).abs() < CLOSE, "a = {a}: {load_factor}");
        largest = a;
    }
    assert!((largest / TUBE[3].0 - 1.0).abs() < CLOSE, "{largest}");
}

/// This tube of tetrahedra, whose pressure has no potential: its rim slides in two parallel planes.
#[test]
fn a_thick_tube_of_tetrahedra_inflates_as_the_closed_form_says() {
    let mesh = cylinder_quarter([1.0, 2.0], 0.3, [2, 3, 1]).quadratic_tetrahedra();
    let inside = node_at(&mesh.points, [1.0, 0.0, 0.0]);
    let planes = [("x_min", 0), ("y_min", 1), ("z_min", 2), ("z_max", 2)];
    let supports: Vec<_> = planes.map(|(set, axis)| roller(set, axis)).into();
    for (radius, pressure) in &TUBE[..3] {
        let magnitude = Magnitude::Fixed(*pressure);
        let load = Load::Pressure { facets: "inner".into(), magnitude };
        let tube = scene(PLAIN, mesh.clone(), vec![load], supports.clone());
        let body = tube.mixed().lower().unwrap();
        assert_eq!(body.followers.len(), 1);
        let mut solver = Solver::new(&body).unwrap();
        let solution = solver.solve(&[1.0, 0.0], &Options::default()).unwrap();
        let found = 1.0 + solution.displacement[3 * inside];
        assert!((found / radius - 1.0).abs() < CLOSE, "p = {pressure}: {found} {radius}");
    }
}

/// Cook's membrane at finite strain in plane strain, nearly incompressible, against FEniCS with the same elements on the
/// same mesh of 16 × 16 boxes; 6.93 on fine meshes.
#[test]
fn cooks_membrane_does_not_lock() {
    const SHEAR: f64 = 80.1938;
    const BULK: f64 = 400_942.0;
    let mesh = cook_membrane(16).quadratic();
    let [corner, middle] =
        [[48.0, 60.0, 0.0], [48.0, 52.0, 0.0]].map(|at| node_at(&mesh.points, at));
    let load = Load::Traction { facets: "x_max".into(), value: [0.0, 6.25, 0.0] };
    // All of the bulk modulus is the field's: any in the law would weigh J point by point.
    let law = NeoHookeanShape.nearly_incompressible(1e-6);
    let membrane = scene(law, mesh, vec![load], vec![Support::clamped("x_min")]);
    let body = membrane.mixed().lower().unwrap().with_compliance(1.0 / BULK).unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[SHEAR], &Options::default()).unwrap();
    let rise = |node: usize| solution.displacement[3 * node + 1];
    // The digits that FEniCS' numbers were written with.
    assert!((rise(corner) - 6.919165).abs() < 1e-6, "{}", rise(corner));
    assert!((rise(middle) - 6.951970).abs() < 1e-6, "{}", rise(middle));
}

/// No motion of the inside takes back what the sides add to the volume: the linear systems for the pressures have no solution.
#[test]
fn sides_that_change_the_volume_of_an_incompressible_body_are_refused() {
    let mut mesh = box_tetrahedra([1.0; 3], [1; 3]).quadratic();
    let inside = |x: &[f64; 3]| x.iter().all(|x| *x > 0.0 && *x < 1.0);
    let sides = (0..mesh.points.len()).filter(|&node| !inside(&mesh.points[node])).collect();
    mesh.node_sets.insert("sides".into(), sides);
    let wider = Support::moved("sides", &mesh, |[x, _, _]| [0.1 * x, 0.0, 0.0]);
    let body = scene(PLAIN, mesh, vec![], vec![wider]).mixed().lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    assert_eq!(solver.unknowns(), 3);
    let error = solver.solve(&[1.0, 0.0], &Options::default()).unwrap_err();
    assert!(matches!(error, SolveError::NotConverged(_)), "{error}");
}
