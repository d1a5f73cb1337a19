//! Bodies whose rims move under a pressure in their cavity, with lids, against an independent program and themselves.

use crate::support::difference;
use crate::unload::check;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{Method, Options, Solver, Unload, UnloadOptions, compare_formulations, locking};
use sinew_mesh::{AnyMesh, FieldValues, Mesh, TetMesh, TruncatedEllipsoid, boundary_facets};
use std::path::Path;

/// Largest difference from the independent program \[mm\]; its own last step is 5e-15 mm.
const APART: f64 = 1e-8;

fn scene(mesh: impl Into<AnyMesh>, facets: &str, pressure: f64) -> Scene {
    Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 5.0..=200.0))
        .parameter(Parameter::log("lambda", "kPa", 5.0..=200.0))
        .load(Load::CavityPressure { facets: facets.into(), magnitude: Magnitude::Fixed(pressure) })
}

fn springs(facets: &str, normal: f64, tangential: f64) -> Load {
    Load::Foundation { facets: facets.into(), normal, tangential }
}

/// A left ventricle that springs hold at its outer surface and at its base.
fn ventricle(mesh: impl Into<AnyMesh>) -> Scene {
    scene(mesh, "endo", 1.5).load(springs("epi", 0.1, 0.05)).load(springs("base", 0.2, 0.1))
}

fn wall() -> sinew_mesh::Wall {
    TruncatedEllipsoid { short: [20.0, 30.0], long: [52.0, 62.0], base: 15.0 }.wall([1, 8, 4])
}

const THETA: [f64; 2] = [14.0, 40.0];

fn solved(body: &Body, options: &Options) -> Vec<f64> {
    let solution = Solver::new(body).unwrap().solve(&THETA, options).unwrap();
    assert!(solution.has_potential && solution.is_stable());
    solution.displacement
}

#[test]
fn a_tube_with_two_lids_agrees_with_an_independent_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/lid");
    let read = |name: &str| sinew_mesh::read_npy(folder.join(name)).unwrap().values;
    let (points, cells, expected) =
        (read("points.npy"), read("cells.npy"), read("displacement.npy"));
    let (FieldValues::Float(points), FieldValues::Integer(cells), FieldValues::Float(expected)) =
        (points, cells, expected)
    else {
        panic!("points and displacements are floats, cells are integers")
    };
    let cells: Vec<_> = cells.iter().map(|&node| usize::try_from(node).unwrap()).collect();
    let mut mesh = TetMesh {
        points: points.as_chunks().0.to_vec(),
        cells: cells.as_chunks().0.to_vec(),
        ..Mesh::default()
    };
    for (name, side) in [("inner", 0), ("outer", 1)] {
        let on = |facet: &sinew_mesh::Facet| mesh.nodes_of_facet(*facet).all(|n| n % 2 == side);
        let facets = boundary_facets(&mesh).into_iter().filter(on).collect();
        mesh.facet_sets.insert(name.into(), facets);
    }
    let body = scene(mesh, "inner", 2.0).load(springs("outer", 0.3, 0.1)).lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[10.0, 40.0], &Options::default()).unwrap();
    let apart = solution.displacement.iter().zip(&expected).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    let volumes =
        [&vec![0.0; expected.len()], &solution.displacement].map(|u| body.cavity_volumes(u)[0]);
    println!("{apart:.1e} mm apart, volume {volumes:?}, {} iterations", solution.iterations());
    assert!(apart < APART, "{apart:e}");
    assert!((volumes[0] - 3620.386720).abs() < 1e-6 && (volumes[1] - 5404.347848).abs() < 1e-6);
}

#[test]
fn loaded_bodies_are_unloaded_and_come_back() {
    let half = Scene {
        supports: vec![Support::clamped("tip"), Support::uniform("base", [None, None, Some(0.5)])],
        ..ventricle({
            let mut mesh = wall().tetrahedra();
            let low = (0..mesh.points.len()).filter(|&n| mesh.points[n][2] < -61.0).collect();
            mesh.node_sets.insert("tip".into(), low);
            mesh
        })
    };
    let bodies = [
        ("tetrahedra", ventricle(wall().tetrahedra())),
        ("averaged hexahedra", ventricle(wall().hexahedra()).averaged()),
        ("quadratic tetrahedra", ventricle(wall().quadratic_tetrahedra())),
        ("a base that its support lifts", half),
    ];
    for (name, scene) in bodies {
        let body = scene.lower().unwrap();
        check(name, Unload::new(&body).unwrap(), &THETA);
    }
}

#[test]
fn rest_and_loading_are_inverse() {
    let body = ventricle(wall().tetrahedra()).lower().unwrap();
    let mut unload = Unload::new(&body).unwrap();
    let unloaded = unload.solve(&THETA, &UnloadOptions::default()).unwrap();
    let loaded = solved(&unloaded.rest, &Options::default());
    let back = loaded.iter().zip(&unloaded.motion).map(|(u, w)| (u + w).abs()).fold(0.0, f64::max);
    println!("{back:.1e} mm off the image");
    assert!(back < APART, "{back:e}");
}

#[test]
fn conjugate_gradients_find_the_same() {
    let body = ventricle(wall().hexahedra()).lower().unwrap();
    let of = |method| solved(&body, &Options { method, ..Options::default() });
    let [factor, iterated] = [Method::Factor, Method::Aggregation].map(of);
    let apart = difference(&factor, &iterated);
    assert!(apart < 1e-9, "{apart:e}");
}

#[test]
fn what_linear_elements_lose_under_a_lid_is_foreseen() {
    let wall = wall();
    let [body, better] = [AnyMesh::from(wall.tetrahedra()), wall.tetrahedra().quadratic().into()]
        .map(|mesh| ventricle(mesh).lower().unwrap());
    let [own, other] = [&body, &better].map(|body| solved(body, &Options::default()));
    let lost = compare_formulations(&body, &own, &better, &other).unwrap().displacement_loss();
    let expected = locking(&body, &THETA, &own).unwrap().map_or(0.0, |found| found.expected_share);
    println!("{expected:.4} foreseen, {lost:.4} lost");
    assert!(expected < 2.0 * lost && lost < 2.0 * expected, "{expected} for {lost}");
}

/// A lid pulls at the rim: without it the base of an inflated ventricle moves otherwise.
#[test]
fn a_lid_changes_what_a_loose_rim_does() {
    let closed = ventricle(wall().tetrahedra());
    let mut loose = closed.clone();
    loose.loads[0] = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(1.5) };
    let (closed, loose) = (closed.lower().unwrap(), loose.loose_rims().lower().unwrap());
    let closed = solved(&closed, &Options::default());
    let loose = Solver::new(&loose).unwrap().solve(&THETA, &Options::default()).unwrap();
    let apart = difference(&closed, &loose.displacement);
    let mean = |u: &[f64]| {
        u.as_chunks::<3>().0.iter().map(|u| sinew_num::norm(u)).sum::<f64>() / (u.len() / 3) as f64
    };
    let means = [&closed, &loose.displacement].map(|u| mean(u));
    println!("{apart:.3} of the largest displacement, means {means:.2?} mm");
    assert!(apart > 0.01, "{apart}");
}
