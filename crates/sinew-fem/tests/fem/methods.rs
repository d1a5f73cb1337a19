//! Conjugate gradients with smoothed aggregation against factors: the same equilibria, verdicts and derivatives.

use crate::support::ventricle::scene;
use crate::support::{difference, gravity, lower, once};
use crate::ventricles::ventricles;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Support};
use sinew_fem::{Method, Options, Solution, SolveError, Solver};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// Digits of energies: rounding errors of sums over ten thousand cells.
const ENERGY: f64 = 1e-12;
/// Digits of displacements \[relative to the largest\]: both residuals are rounding errors, amplified by the stiffness.
const DISPLACEMENT: f64 = 1e-8;
const VENTRICLE: [f64; 5] = [0.17, 2.4, 3.0, 2.5, 0.9];

fn by(body: &Body, theta: &[f64], method: Method) -> Result<Solution, SolveError> {
    Solver::new(body)?.solve(theta, &Options { method, ..Options::default() })
}

/// Solves by both methods; returns the solution by aggregation.
fn assert_same(name: &str, body: &Body, theta: &[f64]) -> Solution {
    let [direct, iterated] = [Method::Factor, Method::Aggregation]
        .map(|method| by(body, theta, method).unwrap_or_else(|e| panic!("{name}, {method:?}: {e}")));
    println!(
        "{name}: {} nodes, {} and {} iterations, {} of conjugate gradients",
        body.nodes,
        direct.iterations(),
        iterated.iterations(),
        iterated.linear_iterations
    );
    let energy = (iterated.energy - direct.energy).abs() / direct.energy.abs();
    assert!(energy <= ENERGY, "{name}: {energy:.1e}");
    let apart = difference(&iterated.displacement, &direct.displacement);
    assert!(apart <= DISPLACEMENT, "{name}: {apart:.1e}");
    assert_eq!(iterated.negative_pivots, direct.negative_pivots, "{name}");
    assert!(direct.linear_iterations == 0 && iterated.linear_iterations > 0, "{name}");
    assert!(iterated.counted, "{name}");
    iterated
}

fn ventricle() -> TetMesh {
    ventricles().remove(0).1
}

#[test]
fn ventricles_have_the_same_equilibria() {
    for bulk_modulus in [25.0, 1e3] {
        let scene = scene(ventricle(), bulk_modulus);
        let plain = assert_same("plain", &scene.clone().lower().unwrap(), &VENTRICLE);
        assert!(plain.jumped, "the search meets indefinite stiffnesses");
        assert_same("averaged", &scene.averaged().lower().unwrap(), &VENTRICLE);
    }
    let held = Load::Foundation { facets: "base".into(), normal: 1.0, tangential: 0.5 }; // kPa/mm
    let mut springs = scene(ventricle(), 25.0);
    springs.loads.push(held);
    springs.supports = vec![Support::roller_on_plane("base", [0.0, 0.6, 0.8])];
    assert_same("springs, inclined supports", &springs.lower().unwrap(), &VENTRICLE);
}

#[test]
fn slender_and_nearly_incompressible_beams_have_the_same_equilibria() {
    let beam = |cells| box_tetrahedra([100.0, 10.0, 10.0], cells);
    let clamped = || vec![Support::clamped("x_min")];
    let body = lower(NeoHookean, beam([48, 5, 5]), gravity(1.0), clamped());
    for ratio in [1.0, 100.0, 1e4] {
        assert_same("bending beam", &body, &[75.0, 75.0 * ratio]);
    }
    let long = box_tetrahedra([400.0, 4.0, 4.0], [200, 2, 2]);
    assert_same("long beam", &lower(NeoHookean, long, gravity(0.01), clamped()), &[75.0, 75.0]);
    let moved = vec![Support::clamped("x_min"), Support::uniform("x_max", [Some(30.0), Some(0.0), Some(-20.0)])];
    assert_same("moved end", &lower(NeoHookean, beam([24, 4, 4]), vec![], moved), &[75.0, 75.0]);
}

/// Conjugate gradients do not converge in a body of needles; factors do.
#[test]
fn a_body_where_conjugate_gradients_fail_is_factorised() {
    let needles = box_tetrahedra([1000.0, 1.0, 0.01], [40, 4, 4]);
    let supports = || vec![Support::clamped("x_min"), Support::clamped("x_max")];
    let body = lower(NeoHookean, needles, gravity(1e-3), supports());
    let [direct, iterated] = [Method::Factor, Method::Aggregation]
        .map(|method| by(&body, &[75.0, 7.5e6], method).unwrap());
    let energy = (iterated.energy - direct.energy).abs() / direct.energy.abs();
    println!("{} of conjugate gradients, {energy:.1e}", iterated.linear_iterations);
    assert!(energy <= ENERGY, "{energy:.1e}");
}

#[test]
fn derivatives_with_a_factor_in_single_precision_are_accurate() {
    let body = once();
    let theta = [75.0, 75.0];
    let slope: Vec<f64> = (0..3 * body.nodes).map(|i| (i % 7) as f64 - 3.0).collect();
    let of = |method| {
        let mut solver = Solver::new(&body).unwrap();
        let found = solver.solve(&theta, &Options { method, ..Options::default() }).unwrap();
        let columns = solver.sensitivity(&found).unwrap();
        (columns.concat(), solver.adjoint_sensitivity(&found, &slope).unwrap())
    };
    let [direct, single] = [Method::Factor, Method::Aggregation].map(of);
    // Residuals of 1e-10, amplified by a slender body; single precision alone leaves 1e-3.
    assert!(difference(&single.0, &direct.0) < 1e-7);
    assert!(difference(&single.1, &direct.1) < 1e-7);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let body = scene(ventricle(), 25.0).lower().unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| by(&body, &VENTRICLE, Method::Aggregation).unwrap().displacement)
    };
    let one = on(1);
    for threads in [2, 7] {
        assert!(one == on(threads), "{threads} threads");
    }
}
