//! Loads that are too large, too small, on nothing or on the wrong surface.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{HolzapfelOgden, NeoHookean};
use sinew_energy::{Body, Load, Magnitude, Sampling, Scene, SceneError, Support};
use sinew_fem::Advice;
use sinew_mesh::{Facet, TetMesh, box_tetrahedra};

fn pressure(facets: &str, magnitude: Magnitude) -> Load {
    Load::Pressure { facets: facets.into(), magnitude }
}

/// Error of lowering a clamped cube under these loads.
#[track_caller]
fn refused(loads: Vec<Load>) -> SceneError {
    let error = Scene { loads, ..scene(NeoHookean, cube(2)) }.lower().unwrap_err();
    println!("{error}");
    error
}

#[test]
fn an_unknown_facet_set_is_refused_with_those_that_exist() {
    let loads = [traction("top", [1.0; 3]), pressure("top", Magnitude::Fixed(1.0))];
    for load in loads {
        let error = refused(vec![load]);
        let text = error.to_string();
        let known = text.strip_prefix("there is no facet set `top`; the mesh has ");
        assert_eq!(known.expect("those that exist").split(", ").count(), 6);
    }
}

#[test]
fn an_empty_facet_set_is_refused() {
    let mut mesh = cube(1);
    mesh.facet_sets.insert("none".into(), vec![]);
    let loads = vec![pressure("none", Magnitude::Fixed(1.0))];
    let error = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap_err();
    assert_eq!(error, SceneError::Loads("facet set `none` is empty, so its load acts on nothing; remove the load or name the facets".into()));
}

#[test]
fn a_facet_listed_twice_is_refused() {
    // Its load would count twice, silently.
    let mut mesh = cube(1);
    let facet = mesh.facet_sets["x_max"][1];
    mesh.facet_sets.get_mut("x_max").unwrap().push(facet);
    let loads = vec![traction("x_max", [1.0, 0.0, 0.0])];
    let error = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap_err();
    let Facet { cell, opposite } = facet;
    assert_eq!(
        error,
        SceneError::Loads(format!(
            "facet set `x_max` lists the facet of cell {cell} opposite to its vertex {opposite} twice; list it once"
        ))
    );
}

#[test]
fn a_load_on_a_facet_inside_the_body_is_refused() {
    let mesh = cube(1);
    let boundary = sinew_mesh::boundary_facets(&mesh);
    let facets =
        (0..mesh.cells.len()).flat_map(|cell| (0..4).map(move |opposite| Facet { cell, opposite }));
    let inner = facets.into_iter().find(|facet| !boundary.contains(facet)).unwrap();
    let foundation = |facets: String| Load::Foundation { facets, normal: 1.0, tangential: 1.0 };
    for load in [
        traction("mixed", [1.0, 0.0, 0.0]),
        pressure("mixed", Magnitude::Fixed(1.0)),
        foundation("mixed".into()),
    ] {
        let mut mesh = mesh.clone();
        mesh.facet_sets.insert("mixed".into(), vec![boundary[0], inner]);
        let error = Scene { loads: vec![load], ..scene(NeoHookean, mesh) }.lower().unwrap_err();
        let Facet { cell, opposite } = inner;
        assert_eq!(
            error,
            SceneError::Loads(format!(
                "facet set `mixed` names the facet of cell {cell} opposite to its vertex {opposite}, which lies inside the body; loads act on its surface: leave inner facets out"
            ))
        );
    }
}

#[test]
fn loads_that_are_no_numbers_are_refused() {
    for value in [f64::NAN, f64::INFINITY] {
        let loads = [
            Load::BodyForce([0.0, value, 0.0]),
            traction("x_max", [0.0, 0.0, value]),
            pressure("x_max", Magnitude::Fixed(value)),
        ];
        for load in loads {
            assert!(matches!(refused(vec![load]), SceneError::NotFinite { .. }));
        }
    }
}

#[test]
fn loads_whose_sum_overflows_are_refused() {
    for load in [Load::BodyForce([f64::MAX; 3]), traction("x_max", [f64::MAX; 3])] {
        assert!(matches!(refused(vec![load; 40]), SceneError::NotFinite { .. }));
    }
}

#[test]
fn a_pressure_on_a_surface_with_a_free_rim_is_refused_with_an_edge_of_the_rim() {
    let error = refused(vec![pressure("z_max", Magnitude::Fixed(1.0))]);
    let SceneError::LooseRim(text) = error else { panic!("{error}") };
    let before = "the pressure on `z_max` has no potential: its rim at nodes ";
    let edge = text.strip_prefix(before).and_then(|rest| rest.split_once(" is neither"));
    let edge = edge.expect("an edge").0.split(" and ").map(|node| node.parse().unwrap());
    let mesh = cube(2);
    assert!(edge.clone().count() == 2);
    assert!(edge.into_iter().all(|node: usize| mesh.node_sets["z_max"].contains(&node)));
}

#[test]
fn a_load_that_reads_a_missing_entry_of_theta_is_refused() {
    for index in [0, 1, 3] {
        let mut scene = scene(NeoHookean, cube(1));
        scene.parameters = parameters(&["mu", "lambda", "p"]);
        scene.loads = vec![pressure("x_max", Magnitude::Theta(index))];
        let expected = SceneError::Parameters(format!(
            "a load reads entry {index} of theta, but only entry 2 is free for loads: the law reads those before it"
        ));
        assert_eq!(scene.lower().unwrap_err(), expected);
    }
    let mut scene = scene(NeoHookean, cube(1));
    scene.loads = vec![pressure("x_max", Magnitude::Theta(2))];
    let error = scene.lower().unwrap_err().to_string();
    assert!(error.contains("list one for the load after them, which becomes entry 2"), "{error}");
}

#[test]
fn zero_loads_leave_exactly_nothing() {
    let mut loads = gravity(0.0);
    loads.push(traction("x_max", [0.0; 3]));
    let beam = Scene { loads, ..scene(NeoHookean, cube(3)) }.lower().unwrap();
    let solution = solve(&beam, &[1.0, 1.0]).unwrap();
    assert!(solution.displacement.iter().all(|&u| u == 0.0));
    assert_eq!((solution.energy, solution.residual), (0.0, 0.0));
    assert!(solution.is_stable());
}

#[test]
fn a_load_of_1e_minus_12_keeps_its_digits() {
    // At vanishing load displacement ∝ load; its change is quadratic.
    let displacement = |factor: f64| {
        let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
        let beam = lower(NeoHookean, mesh, gravity(factor), vec![Support::clamped("x_min")]);
        let solution = solve(&beam, &[75.0, 75.0]).unwrap();
        solution.displacement.iter().map(|u| u / factor).collect::<Vec<_>>()
    };
    let reference = displacement(1e-8);
    for factor in [1e-12, 1e-20, 1e-100] {
        let off = difference(&displacement(factor), &reference);
        assert!(off < 1e-6, "{factor:e}: {off:e}");
    }
    // Better than the difference from linearity at 1e-8: two tiny loads agree to rounding.
    assert!(difference(&displacement(1e-12), &displacement(1e-14)) < 1e-9);
}

/// A cube between rollers under a pressure on the three sides that face away: a closed surface by the rule for
/// rims that slide.
fn pressed(law: sinew_energy::NearlyIncompressible<HolzapfelOgden>, magnitude: Magnitude) -> Body {
    let mut mesh = distorted_cube(2);
    let sides = ["x_max", "y_max", "z_max"].map(|side| mesh.facet_sets[side].clone());
    mesh.facet_sets.insert("away".into(), sides.concat());
    let mut scene = Scene {
        loads: vec![pressure("away", magnitude)],
        supports: corner_rollers(),
        ..with_directions(law, mesh, [[0.0, 0.0, 1.0]])
    };
    if let Magnitude::Theta(_) = magnitude {
        scene.parameters = parameters(&["a", "b", "a_f", "b_f", "p"]);
        scene.parameters[4].sampling = Sampling::Linear;
    }
    scene.lower().unwrap()
}

const BULK: sinew_energy::NearlyIncompressible<HolzapfelOgden> =
    HolzapfelOgden.nearly_incompressible(10.0);

#[test]
fn hydrostatic_pressure_and_suction_from_theta_change_the_volume_as_the_closed_form_says() {
    let cube = pressed(BULK, Magnitude::Theta(4));
    for p in [6.0, 1.0, -1.0, -30.0] {
        let solution = solve(&cube, &[1.0, 1.0, 2.0, 1.0, p]).unwrap();
        assert_equilibrium(&cube, &solution);
        // ½P(J − 1)² + pJ is stationary at J = 1 − p/P; the shape stays.
        let stretch = (1.0 - p / BULK.volume.bulk_modulus).cbrt();
        let corner = solution.displacement[3 * cube.nodes - 3..].iter();
        for u in corner {
            assert!((u - (stretch - 1.0)).abs() < 1e-9, "p = {p}: {u}");
        }
    }
}

#[test]
fn a_pressure_beyond_what_the_volume_carries_is_refused_at_the_load_that_it_did_carry() {
    let cube = pressed(BULK, Magnitude::Fixed(20.0));
    let failure = failure(solve(&cube, &[1.0, 1.0, 2.0, 1.0]));
    // Half of it flattens the body: J = 1 − p/P.
    assert!(failure.load_factor > 0.45 && failure.load_factor < 0.5, "{}", failure.load_factor);
    assert!(matches!(failure.advice, Advice::Squeezed { volume_ratio, .. } if volume_ratio < 0.05));
    let text = failure.to_string();
    assert!(text.contains("cell") && text.contains("reduce"), "{text}");
}

#[test]
fn a_weight_a_million_times_too_large_is_solved_or_refused_with_its_history() {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 2, 2]);
    let beam = lower(NeoHookean, mesh, gravity(1e6), vec![Support::clamped("x_min")]);
    match solve(&beam, &[75.0, 75.0]) {
        Ok(solution) => {
            assert_equilibrium(&beam, &solution);
            assert!(solution.is_stable());
        }
        Err(sinew_fem::SolveError::NotConverged(failure)) => {
            println!("{failure}");
            assert!(failure.load_factor < 1.0 && !failure.history.iterations.is_empty());
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn a_pressure_a_million_times_too_large_is_refused_with_its_best_state() {
    let cube = pressed(BULK, Magnitude::Fixed(1e7));
    let failure = failure(solve(&cube, &[1.0, 1.0, 2.0, 1.0]));
    assert!(failure.load_factor < 1e-3, "{}", failure.load_factor);
    assert!(!failure.history.iterations.is_empty());
    assert!(!failure.to_string().contains("NaN"));
}

#[test]
fn two_pressures_at_once_are_one_pressure_on_both_surfaces() {
    let mut mesh = box_tetrahedra([2.0, 2.0, 1.0], [4, 4, 2]);
    let both = ["z_min", "z_max"].map(|side| mesh.facet_sets[side].clone()).concat();
    mesh.facet_sets.insert("both".into(), both);
    let held = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec();
    let solved = |loads: Vec<Load>| {
        let plate = Scene { loads, supports: held.clone(), ..scene(NeoHookean, mesh.clone()) };
        let plate = plate.lower().unwrap();
        let solution = solve(&plate, &[1.0, 1.0]).unwrap();
        assert_sound(&plate, &solution);
        solution
    };
    let p = Magnitude::Fixed(0.4);
    let two = solved(vec![pressure("z_min", p), pressure("z_max", p)]);
    let one = solved(vec![pressure("both", p)]);
    assert!(difference(&two.displacement, &one.displacement) < 1e-10);
    assert_close(two.energy, one.energy, 1e-10);
    // One of another sign than the other bends the plate.
    let bent = solved(vec![pressure("z_min", p), pressure("z_max", Magnitude::Fixed(-0.4))]);
    assert!(norm(&bent.displacement) > 3.0 * norm(&two.displacement));
}

#[test]
fn the_pressure_of_the_thesis_is_a_follower_at_vanishing_displacement_only() {
    let held = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec();
    let mesh = box_tetrahedra([2.0, 2.0, 1.0], [4, 4, 2]);
    let solved = |p: f64, thesis: bool| {
        let (facets, magnitude) = ("z_min".to_string(), Magnitude::Fixed(p));
        let load = match thesis {
            true => Load::ThesisPressure { facets, magnitude },
            false => Load::Pressure { facets, magnitude },
        };
        let scene = scene(NeoHookean, mesh.clone());
        let plate = Scene { loads: vec![load], supports: held.clone(), ..scene };
        let plate = plate.lower().unwrap();
        solve(&plate, &[1.0, 1.0]).unwrap().displacement
    };
    let apart = |p: f64| difference(&solved(p, true), &solved(p, false));
    let (small, smaller, large) = (apart(1e-4), apart(1e-6), apart(0.5));
    // The difference in the load is linear in the displacement.
    assert!(small < 1e-3 && large > 1e-2, "{small:e} {large:e}");
    assert_close(small / smaller, 100.0, 0.01);
}

#[test]
fn a_facet_of_vanishing_area_carries_its_share_of_the_load() {
    // A node of the loaded side moved to within 1e-7 of its neighbour: slim facets, the same total.
    let squeezed = |gap: f64| -> (TetMesh, f64) {
        let mut mesh = box_tetrahedra([1.0; 3], [2; 3]);
        for point in &mut mesh.points {
            if point[1] == 0.5 {
                point[1] = gap;
            }
        }
        let loads = vec![traction("x_max", [0.3, 0.0, 0.1])];
        let body = Scene { loads, ..scene(NeoHookean, mesh.clone()) }.lower().unwrap();
        let solution = solve(&body, &[1.0, 1.0]).unwrap();
        assert_sound(&body, &solution);
        let held = reaction(&body, &solution, &mesh.node_sets["x_min"]);
        assert_close(held[0], -0.3, 1e-8);
        assert_close(held[2], -0.1, 1e-8);
        (mesh, solution.energy)
    };
    // Energies of slim and slimmer cells approach each other.
    let (thin, thinner) = (squeezed(1e-5).1, squeezed(1e-7).1);
    assert_close(thin, thinner, 1e-4);
}
