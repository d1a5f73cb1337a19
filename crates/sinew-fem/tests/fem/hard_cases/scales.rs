//! One body in several systems of units.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Support};
use sinew_mesh::box_tetrahedra;

/// A heavy beam with lengths multiplied by `length` and stresses by `stress`; its displacement and energy in the
/// first units, and the number of iterations.
fn solved(length: f64, stress: f64) -> (Vec<f64>, f64, usize) {
    let mut mesh = box_tetrahedra([10.0, 1.0, 1.0], [10, 2, 2]);
    mesh.points.as_flattened_mut().iter_mut().for_each(|x| *x *= length);
    let loads = vec![Load::BodyForce([0.0, 0.0, -3e-3 * stress / length])];
    let beam = lower(NeoHookean, mesh, loads, vec![Support::clamped("x_min")]);
    let solution = solve(&beam, &[stress, 2.0 * stress]).unwrap();
    assert_sound(&beam, &solution);
    let displacement = solution.displacement.iter().map(|u| u / length).collect();
    (displacement, solution.energy / (stress * length.powi(3)), solution.iterations())
}

/// Powers of ten are not powers of two: results differ by rounding.
#[track_caller]
fn assert_same(length: f64, stress: f64) {
    let (reference, scaled) = (solved(1.0, 1.0), solved(length, stress));
    assert!(difference(&scaled.0, &reference.0) < 1e-9);
    assert_close(scaled.1, reference.1, 1e-10);
    assert!(scaled.2.abs_diff(reference.2) <= 1, "{} {}", scaled.2, reference.2);
}

#[test]
fn lengths_a_million_times_as_large_scale_the_solution() {
    assert_same(1e6, 1.0);
}

#[test]
fn lengths_a_millionth_as_large_scale_the_solution() {
    assert_same(1e-6, 1.0);
}

#[test]
fn stresses_a_million_times_as_large_scale_the_solution() {
    assert_same(1.0, 1e6);
}

#[test]
fn stresses_a_millionth_as_large_scale_the_solution() {
    assert_same(1.0, 1e-6);
}

#[test]
fn powers_of_two_as_units_change_no_bit() {
    let (reference, scaled) = (solved(1.0, 1.0), solved(2f64.powi(20), 2f64.powi(-20)));
    assert_eq!(reference, scaled);
}
