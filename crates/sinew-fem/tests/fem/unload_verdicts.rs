//! Images that came from no body at rest, or from one that is no answer: each has its verdict, and none is taken for an answer.

use crate::shells::sphere_octant;
use crate::support::ventricle::{BULK_MODULUS, MMHG, scene, thetas};
use crate::ventricles::ventricles;
use sinew_energy::laws::{NeoHookean, NeoHookeanShape};
use sinew_energy::{Body, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{Options, Solver, Unload, UnloadError, UnloadOptions, Unloaded};
use sinew_mesh::{TetMesh, box_tetrahedra};

fn small() -> TetMesh {
    ventricles().swap_remove(0).1
}

fn unload(body: &Body, theta: &[f64]) -> Result<Unloaded, UnloadError> {
    let found = Unload::new(body)?.solve(theta, &UnloadOptions::default());
    match &found {
        Ok(found) => println!("{theta:?}: {} iterations, {:?}", found.iterations, found.loading),
        Err(error) => println!("{theta:?}: {error}"),
    }
    found
}

/// An octant of a sphere of soft rubber, inflated to radii of 13 and 21.
fn balloon(pressure: f64) -> Body {
    let mesh = sphere_octant([13.0, 21.0], [2, 3]).tetrahedra();
    let sphere = Scene::new(mesh, NeoHookeanShape.nearly_incompressible(200.0))
        .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
        .load(Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Fixed(pressure) });
    let held = |axis: usize| std::array::from_fn(|i| (i == axis).then_some(0.0));
    let sides = ["x_min", "y_min", "z_min"].into_iter().enumerate();
    let sphere =
        sides.fold(sphere, |sphere, (i, side)| sphere.support(Support::uniform(side, held(i))));
    sphere.lower().unwrap()
}

#[test]
fn an_image_without_load_is_at_rest() {
    let body = scene(small(), BULK_MODULUS).lower().unwrap();
    let [a, b, a_f, b_f, _] = thetas(1, 1.0)[1];
    let unloaded = unload(&body, &[a, b, a_f, b_f, 0.0]).unwrap();
    assert!(unloaded.motion.iter().all(|w| *w == 0.0) && unloaded.iterations == 0);
}

#[test]
fn suction_made_the_image_smaller() {
    let body = scene(small(), BULK_MODULUS).lower().unwrap();
    let [a, b, a_f, b_f, _] = thetas(1, 1.0)[1];
    let unloaded = unload(&body, &[a, b, a_f, b_f, -0.5 * MMHG]).unwrap();
    let rest = vec![0.0; unloaded.motion.len()];
    assert!(unloaded.rest.cavity_volumes(&rest)[0] > 1.01 * body.cavity_volumes(&rest)[0]);
}

/// Half of a shallow arch between two plates that bears its weight, moved by a displacement.
fn arch(weight: f64, moved: Option<&[f64]>) -> Body {
    let mut mesh = box_tetrahedra([50.0, 4.0, 4.0], [8, 1, 1]).quadratic();
    mesh.map_points(|[x, y, z]| [x, y, z + 8.0 * (std::f64::consts::PI * x / 100.0).sin()]);
    if let Some(moved) = moved {
        let moves = mesh.points.iter_mut().zip(moved.as_chunks::<3>().0);
        moves.for_each(|(x, u)| (0..3).for_each(|i| x[i] += u[i]));
    }
    let plate = [None, Some(0.0), None];
    let scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, weight]))
        .support(Support::clamped("x_min"))
        .support(Support::uniform("y_min", plate))
        .support(Support::uniform("y_max", plate))
        .support(Support::uniform("x_max", [Some(0.0), None, None]));
    scene.lower().unwrap()
}

/// An arch under a weight below its limit point has two stable states, and is loaded to the upright one. It is no answer for an image of the
/// other, which another arch is loaded to.
#[test]
fn an_arch_that_has_snapped_comes_from_another_one() {
    let (theta, options) = ([75.0, 75.0], Options::default());
    let snapped = Solver::new(&arch(-1e-2, None)).unwrap().solve(&theta, &options).unwrap();
    let weight = -7e-3;
    let body = arch(weight, None);
    let mut solver = Solver::new(&body).unwrap();
    let upright = solver.solve(&theta, &options).unwrap();
    let snapped = solver.solve_from(&snapped.displacement, &theta, &options).unwrap();
    let lowest = |u: &[f64]| u.iter().copied().fold(0.0, f64::min);
    assert!(upright.is_stable() && snapped.is_stable());
    println!("{} {}", lowest(&upright.displacement), lowest(&snapped.displacement));
    assert!(lowest(&upright.displacement) > -5.0 && lowest(&snapped.displacement) < -10.0);
    let unload = |state: &[f64]| {
        let image = arch(weight, Some(state));
        let motion: Vec<f64> = state.iter().map(|u| -u).collect();
        Unload::new(&image)?.solve_near(&motion, &theta, &UnloadOptions::default())
    };
    for (state, same) in [(&upright.displacement, true), (&snapped.displacement, false)] {
        let found = unload(state).map_err(|error| error.to_string()).unwrap();
        let farthest =
            |u: &[f64]| u.iter().zip(&found.motion).map(|(u, w)| (u + w).abs()).fold(0.0, f64::max);
        assert!((farthest(state) < 1e-8) == same, "{}", farthest(state));
        let loaded = Solver::new(&found.rest).unwrap().solve(&theta, &options).unwrap();
        assert!(farthest(&loaded.displacement) < 1e-8, "{}", farthest(&loaded.displacement));
    }
}

#[test]
fn no_balloon_of_this_size_bears_such_a_pressure() {
    // Whatever its radius at rest, it bears 2.2 μ at most: what balances more has turned its inside out.
    for pressure in [32.0, 60.0] {
        let error = unload(&balloon(pressure), &[20.0]).unwrap_err();
        let refused = matches!(
            error,
            UnloadError::NotFound { .. }
                | UnloadError::CrossesItself { .. }
                | UnloadError::Unstable { .. }
        );
        assert!(refused, "{error}");
    }
}

#[test]
fn a_search_that_ends_early_says_how_far_it_came() {
    let options = UnloadOptions { iterations: 3, ..UnloadOptions::default() };
    let body = scene(small(), BULK_MODULUS).lower().unwrap();
    let error =
        Unload::new(&body).unwrap().solve(&thetas(1, 20.0 * MMHG)[1], &options).unwrap_err();
    assert!(matches!(error, UnloadError::NotFound { part: 0.0, iterations: 3, .. }), "{error}");
    let told = error.to_string();
    assert!(told.contains("no unloaded configuration") && told.contains("units"), "{told}");
}

#[test]
fn a_cell_that_is_folded_in_the_image_is_named() {
    let mut mesh = box_tetrahedra([3.0, 1.0, 1.0], [3, 1, 1]);
    let node = mesh.points.iter().position(|x| *x == [1.0, 0.0, 0.0]).unwrap();
    mesh.points[node] = [2.5, 0.5, 0.5];
    let scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
        .support(Support::clamped("x_min"));
    let error = scene.lower().unwrap_err().to_string();
    assert!(error.contains("has the volume -"), "{error}");
}

/// Two beams, one close above the other, of which the upper one is pulled up.
#[test]
fn a_body_that_crosses_itself_at_rest_is_refused() {
    let mut mesh = box_tetrahedra([40.0, 6.0, 6.0], [8, 1, 2]);
    let mut upper = box_tetrahedra([40.0, 6.0, 6.0], [8, 1, 2]);
    upper.points.iter_mut().for_each(|x| *x = [x[0], x[1] + 0.3, x[2] + 6.5]);
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len());
    let clamped = upper.node_sets["x_min"].iter().map(|node| node + nodes).collect::<Vec<_>>();
    let mut pulled = upper.facet_sets["z_max"].clone();
    pulled.iter_mut().for_each(|facet| facet.cell += cells);
    mesh.points.extend(upper.points);
    mesh.cells.extend(upper.cells.iter().map(|cell| cell.map(|node| node + nodes)));
    mesh.node_sets.get_mut("x_min").unwrap().extend(clamped);
    mesh.facet_sets.insert("pulled".into(), pulled);
    let beams = |pull: f64| {
        Scene::new(mesh.clone(), NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
            .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
            .load(Load::Traction { facets: "pulled".into(), value: [0.0, 0.0, pull] })
            .support(Support::clamped("x_min"))
            .lower()
            .unwrap()
    };
    unload(&beams(0.001), &[50.0, 100.0]).unwrap();
    let error = unload(&beams(0.02), &[50.0, 100.0]).unwrap_err();
    let UnloadError::CrossesItself { pairs, cells: [first, second] } = error else {
        panic!("{error}")
    };
    assert!(pairs > 0 && first < cells && second >= cells);
}

#[test]
fn theta_that_makes_no_sense_is_told() {
    let body = scene(small(), BULK_MODULUS).lower().unwrap();
    for theta in [&[f64::NAN, 1.0, 1.0, 1.0, 1.0][..], &[-1.0, 1.0, 1.0, 1.0, 1.0], &[1.0; 4]] {
        assert!(matches!(unload(&body, theta), Err(UnloadError::Body(_))));
    }
}

/// The softest corner of the box, pressures far beyond it, and a pressure in mmHg taken for kPa: whatever comes, it is an answer that holds or
/// an error with a type.
#[test]
fn hard_ventricles_end_in_a_verdict() {
    let body = scene(small(), BULK_MODULUS).lower().unwrap();
    let [softest, middle] = [0, 1].map(|at| thetas(1, 0.0)[at]);
    let options = UnloadOptions { iterations: 60, ..UnloadOptions::default() };
    let at = |[a, b, a_f, b_f, _]: [f64; 5], pressure: f64| [a, b, a_f, b_f, pressure];
    for theta in [
        at(softest, 8.0 * MMHG),
        at(softest, 20.0 * MMHG),
        at(middle, 8.0),
        at(middle, 110.0 * MMHG),
    ] {
        match Unload::new(&body).unwrap().solve(&theta, &options) {
            Ok(found) => assert!(found.loading.unwrap().distance < 1e-8),
            Err(UnloadError::Body(error)) => panic!("{error}"),
            Err(error) => println!("{theta:.3?}: {error}"),
        }
    }
    let stiff = scene(small(), 1000.0 * middle[0]).lower().unwrap();
    assert!(unload(&stiff, &at(middle, 8.0 * MMHG)).unwrap().loading.unwrap().distance < 1e-8);
}
