//! Slender bodies of soft material, where a linear step bends and thereby stretches.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use crate::support::GRAVITY;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;

#[test]
fn a_nearly_incompressible_beam_is_solved() {
    let beam = once();
    assert_sound(&beam, &solve(&beam, &[75.0, 7.5e5]).unwrap());
}

/// A step that bends a beam changes its volumes to second order. With the energy of the bulk modulus, the line search would then shorten steps to a
/// hundredth.
#[test]
fn a_large_bulk_modulus_does_not_shorten_steps() {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [6, 2, 2]).quadratic();
    let beam = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 34.0..=150.0))
        .parameter(Parameter::log("lambda", "kPa", 34.0..=1.5e6))
        .load(Load::BodyForce([0.0, 0.0, GRAVITY]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap();
    let iterations = |factor: f64| -> Vec<usize> {
        let solve = |mu: f64| solve(&beam, &[mu, factor * mu]).unwrap().iterations();
        [34.0, 55.0, 90.0, 150.0].map(solve).to_vec()
    };
    for factor in [1.0, 1e2, 1e4] {
        let found = iterations(factor);
        println!("lambda is {factor} mu: {found:?} iterations");
        assert!(found.iter().all(|&count| count <= 30), "lambda is {factor} mu: {found:?}");
    }
}

#[test]
fn the_softest_corner_under_five_times_its_weight_is_solved() {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    let under =
        |weight| lower(NeoHookean, mesh.clone(), gravity(weight), vec![Support::clamped("x_min")]);
    let beam = under(5.0);
    let solution = solve(&beam, &[50.0, 50.0]).unwrap();
    assert_sound(&beam, &solution);
    // The same by loading it in five steps, each from the last.
    let mut displacement = vec![0.0; beam.prescribed.len()];
    for step in 1..=5 {
        let stepped = under(f64::from(step));
        let mut solver = Solver::new(&stepped).unwrap();
        let next = solver.solve_from(&displacement, &[50.0, 50.0], &Options::default()).unwrap();
        displacement = next.displacement;
    }
    assert!(difference(&displacement, &solution.displacement) < 1e-8);
}

#[test]
fn a_membrane_like_beam_a_tenth_as_stiff_as_the_softest_is_solved() {
    let beam = twice();
    assert_sound(&beam, &solve(&beam, &[5.0, 5.0]).unwrap());
}

#[test]
fn a_beam_a_hundred_times_as_long_as_thick_softens_with_refinement_towards_beam_theory() {
    // Small tip force; Euler–Bernoulli: w = F L³ / (3 E I) with L = 100, I = 1/12, E = 2.5 for μ = λ = 1.
    let force = 1e-7;
    let theory = force * 1e6 / (3.0 * 2.5 / 12.0);
    let mut last = 0.0;
    for cells in [[25, 1, 1], [50, 2, 2], [100, 4, 4]] {
        let mesh = box_tetrahedra([100.0, 1.0, 1.0], cells);
        let tip = mesh.node_sets["x_max"][0];
        let loads = vec![traction("x_max", [0.0, 0.0, -force])];
        let beam = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap();
        let solution = solve(&beam, &[1.0, 1.0]).unwrap();
        assert_equilibrium(&beam, &solution);
        // Linear tetrahedra lock: stiffer than the truth on every mesh, less so on finer ones.
        let part = -solution.displacement[3 * tip + 2] / theory;
        println!("{cells:?}: {part:.3} of beam theory");
        assert!(part > 1.5 * last && part < 1.0);
        last = part;
    }
}

#[test]
fn a_whip_that_bends_by_its_own_length_is_solved() {
    let mesh = box_tetrahedra([50.0, 1.0, 1.0], [50, 1, 1]);
    let tip = mesh.node_sets["x_max"][0];
    let loads = vec![traction("x_max", [0.0, 0.0, -2e-2])];
    let whip = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap();
    let solution = solve(&whip, &[1.0, 1.0]).unwrap();
    assert_sound(&whip, &solution);
    assert!(solution.displacement[3 * tip + 2] < -25.0);
}
