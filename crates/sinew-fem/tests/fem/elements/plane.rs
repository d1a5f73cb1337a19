//! Triangles against slabs of solid elements.

use crate::distort::Distort as _;
use crate::elements::scene::{distance, node_at, roller, scene};
use crate::membrane::cook_membrane;
use sinew_energy::laws::{LinearElastic, NeoHookean, lame_from_young_poisson};
use sinew_energy::{Load, Magnitude, Support};
use sinew_fem::{Options, Solver, cell_stresses};
use sinew_mesh::{AnyMesh, Mesh, box_hexahedra, box_tetrahedra, rectangle_triangles};

const THETA: [f64; 2] = [10.0, 20.0];

/// A strip under its weight, a traction and a pressure, clamped at both ends: deflection of the middle. Under
/// triangles the pressure has a potential; the slab's rim slides in two parallel planes, so there it has none.
fn deflection(mesh: impl Into<AnyMesh>, solid: bool) -> f64 {
    let loads = vec![
        Load::BodyForce([0.0, -0.01, 0.0]),
        Load::Traction { facets: "y_max".into(), value: [0.01, -0.02, 0.0] },
        Load::Pressure { facets: "y_min".into(), magnitude: Magnitude::Fixed(0.2) },
    ];
    let mut supports = vec![Support::clamped("x_min"), Support::clamped("x_max")];
    if solid {
        supports.extend([roller("z_min", 2), roller("z_max", 2)]);
    }
    let strip = scene(NeoHookean, mesh, loads, supports).loose_rims();
    let body = strip.lower().unwrap();
    assert_eq!((body.pressures.len(), body.followers.len()), if solid { (0, 1) } else { (1, 0) });
    let solution = Solver::new(&body).unwrap().solve(&THETA, &Options::default()).unwrap();
    let middle = node_at(strip.mesh.points(), [2.0, 1.0, 0.0]);
    solution.displacement[3 * middle + 1]
}

/// The slab is 0.25 thick: as its sides stay flat the thickness does not matter.
#[test]
fn a_strip_of_triangles_is_a_slab_held_on_both_sides() {
    let triangles = deflection(rectangle_triangles([4.0, 1.0], [16, 4]).quadratic(), false);
    assert!(triangles > 0.05, "{triangles}");
    let slab = [4.0, 1.0, 0.25];
    let tetrahedra = deflection(box_tetrahedra(slab, [16, 4, 1]).quadratic(), true);
    // Both are converged to this.
    assert!((tetrahedra / triangles - 1.0).abs() < 2e-3, "{tetrahedra} {triangles}");
    let hexahedra = deflection(box_hexahedra(slab, [32, 8, 1]), true);
    // Linear elements are stiffer, by the square of the element size.
    assert!((hexahedra / triangles - 1.0).abs() < 0.02, "{hexahedra} {triangles}");
}

/// (μ, 2λμ/(λ + 2μ)): in plane strain the plane stress of a plate (S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, 1951, art. 15 and 16).
fn plate(young: f64, poisson: f64) -> [f64; 2] {
    let [shear, lame] = lame_from_young_poisson(young, poisson);
    [shear, 2.0 * lame * shear / (lame + 2.0 * shear)]
}

#[test]
fn a_plate_pulled_along_one_axis_contracts_by_poissons_ratio() {
    fn check(mesh: impl Into<AnyMesh>) {
        const YOUNG: f64 = 3.0;
        const POISSON: f64 = 0.4;
        const TRACTION: f64 = 0.06;
        let load = Load::Traction { facets: "x_max".into(), value: [TRACTION, 0.0, 0.0] };
        let supports = vec![roller("x_min", 0), roller("y_min", 1)];
        let scene = scene(LinearElastic, mesh, vec![load], supports);
        let (body, theta) = (scene.lower().unwrap(), plate(YOUNG, POISSON));
        let solution = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
        let strain = TRACTION / YOUNG;
        let exact = |x: &[f64; 3]| [strain * x[0], -POISSON * strain * x[1], 0.0];
        let exact: Vec<f64> = scene.mesh.points().iter().flat_map(exact).collect();
        assert!(distance(&solution.displacement, &exact) < 1e-12);
        // Cauchy's stress of small strains.
        let stresses = cell_stresses(&body, &exact, &theta).unwrap();
        assert!(
            stresses.iter().all(|cell| (cell.cauchy[0][0] / TRACTION - 1.0).abs() < 2.0 * strain)
        );
    }
    check(rectangle_triangles([2.0, 1.0], [4, 3]).distorted(5, 0.3));
    check(rectangle_triangles([2.0, 1.0], [3, 2]).quadratic().distorted(5, 0.3));
}

#[test]
fn triangles_that_leave_their_plane_are_refused() {
    let refused = |mesh: Mesh<3>, load: Load| {
        let strip = scene(NeoHookean, mesh, vec![load], vec![Support::clamped("x_min")]);
        strip.lower().expect_err("it is not plane").to_string()
    };
    let flat = || rectangle_triangles([2.0, 1.0], [2, 1]);
    let mut tilted = flat();
    tilted.points.iter_mut().for_each(|x| x[2] = 0.3 * x[0]);
    let said = refused(tilted, Load::BodyForce([0.0, -0.01, 0.0]));
    assert!(said.contains("node 1 lies 3e-1 above"), "{said}");
    // Far away, too, but for rounding errors of single precision there; at any height.
    let moved = |by: f64, tilt: f64| {
        let mut mesh = flat();
        mesh.map_points(|[x, y, _]| [x + by, y, 7.0 + tilt * x]);
        scene(NeoHookean, mesh, vec![], vec![Support::clamped("x_min")]).lower()
    };
    assert!(moved(1e6, 0.5).is_err() && moved(1e6, 1e-2).is_ok() && moved(0.0, 1e-3).is_err());
    assert!(moved(0.0, 0.0).is_ok());
    let said = refused(flat(), Load::BodyForce([0.0, -0.01, 2.0]));
    assert!(said.contains("body force along z is 2"), "{said}");
    let said = refused(flat(), Load::Traction { facets: "x_max".into(), value: [0.0, 0.0, -3.0] });
    assert!(said.contains("traction on `x_max` along z is -3"), "{said}");
    // NaN in a load is told as such.
    let said = refused(flat(), Load::BodyForce([0.0, 0.0, f64::NAN]));
    assert!(said.contains("is NaN"), "{said}");
}

/// E = 1, ν = ⅓, a force of 1 over the free end: the middle of that end rises by 23.96
/// (R. D. Cook, J. Struct. Div. ASCE 100, 1974, and later refinements).
#[test]
fn cooks_linear_membrane_rises_as_in_the_literature() {
    let mesh = cook_membrane(16).quadratic();
    let middle = node_at(&mesh.points, [48.0, 52.0, 0.0]);
    let load = Load::Traction { facets: "x_max".into(), value: [0.0, 1.0 / 16.0, 0.0] };
    let membrane = scene(LinearElastic, mesh, vec![load], vec![Support::clamped("x_min")]);
    let body = membrane.lower().unwrap();
    let theta = plate(1.0, 1.0 / 3.0);
    let solution = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
    let rise = solution.displacement[3 * middle + 1];
    assert!((rise - 23.96).abs() < 0.02, "{rise}");
}
