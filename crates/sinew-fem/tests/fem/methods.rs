//! Conjugate gradients with smoothed aggregation against factors: the same equilibria, verdicts and derivatives.

use crate::support::ventricle::scene;
use crate::support::{difference, gravity, lower, once};
use crate::ventricles::ventricles;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Scene, Support};
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
    let [direct, iterated] = [Method::Factor, Method::Aggregation].map(|method| {
        by(body, theta, method).unwrap_or_else(|e| panic!("{name}, {method:?}: {e}"))
    });
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
    assert!(direct.linear_iterations == 0 && iterated.counted, "{name}");
    iterated
}

fn ventricle() -> TetMesh {
    ventricles().remove(0).1
}

#[test]
fn ventricles_have_the_same_equilibria() {
    let soft = scene(ventricle(), 25.0);
    let plain = assert_same("plain", &soft.clone().lower().unwrap(), &VENTRICLE);
    assert!(plain.jumped, "the search meets indefinite stiffnesses");
    // Not by factors that took over: a system takes some twenty iterations.
    let (iterations, steps) = (plain.linear_iterations, plain.iterations());
    assert!((1..=60 * steps).contains(&iterations), "{iterations} in {steps} steps");
    assert_same("averaged", &soft.averaged().lower().unwrap(), &VENTRICLE);
    // K = 6000 a; at 0.9 kPa there are several equilibria.
    let [a, b, a_f, b_f, _] = VENTRICLE;
    let stiff = scene(ventricle(), 1e3);
    assert_same("stiff", &stiff.clone().lower().unwrap(), &[a, b, a_f, b_f, 0.3]);
    assert_same("averaged, stiff", &stiff.averaged().lower().unwrap(), &[a, b, a_f, b_f, 0.3]);
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
    let moved = vec![
        Support::clamped("x_min"),
        Support::uniform("x_max", [Some(30.0), Some(0.0), Some(-20.0)]),
    ];
    assert_same("moved end", &lower(NeoHookean, beam([24, 4, 4]), vec![], moved), &[75.0, 75.0]);
}

#[test]
fn a_body_on_springs_and_inclined_rollers_has_the_same_equilibrium() {
    let held = Load::Foundation { facets: "x_min".into(), normal: 2.0, tangential: 1.0 }; // kPa/mm
    let pulled = Load::Traction { facets: "x_max".into(), value: [10.0, 0.0, 2.0] }; // kPa
    let rollers = vec![Support::roller_on_plane("y_min", [0.1, 1.0, 0.0])];
    let mesh = box_tetrahedra([30.0, 10.0, 10.0], [18, 6, 6]);
    let body = lower(NeoHookean, mesh, vec![held, pulled], rollers);
    assert!(!body.frames.is_empty());
    assert_same("springs", &body, &[75.0, 75.0]);
}

#[test]
fn conjugate_gradients_without_a_load_have_nothing_to_do() {
    let clamped = vec![Support::clamped("x_min")];
    let body = lower(NeoHookean, box_tetrahedra([10.0; 3], [4; 3]), vec![], clamped);
    let found = by(&body, &[75.0, 75.0], Method::Aggregation).unwrap();
    assert!(found.displacement.iter().all(|&u| u == 0.0));
    assert_eq!(found.linear_iterations, 0);
}

/// Conjugate gradients with a bulk modulus of 10⁶ μ take more iterations than a factor is worth.
#[test]
fn a_body_where_conjugate_gradients_fail_is_factorised() {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [48, 5, 5]);
    let body = lower(NeoHookean, mesh, gravity(1.0), vec![Support::clamped("x_min")]);
    let iterated = assert_same("constrained beam", &body, &[75.0, 75e6]);
    // The most of one system, which failed, and the factors of all.
    assert_eq!(iterated.linear_iterations, 0);
}

/// A step takes more iterations the larger K/μ, a factor none.
#[test]
fn the_method_is_the_cheaper_one() {
    let clamped = vec![Support::clamped("x_min")];
    let body = lower(NeoHookean, box_tetrahedra([10.0; 3], [20; 3]), gravity(10.0), clamped);
    let soft = by(&body, &[75.0, 75.0], Method::Automatic).unwrap();
    assert!(soft.linear_iterations > 0);
    let [single, double] = [Method::Automatic, Method::Factor]
        .map(|method| by(&body, &[75.0, 2000.0 * 75.0], method).unwrap());
    assert_eq!(single.linear_iterations, 0);
    assert!((single.energy - double.energy).abs() <= ENERGY * double.energy.abs());
    assert_eq!([single.negative_pivots, double.negative_pivots], [0, 0]);
}

/// The linear response after a solve whose factors are in single precision is that of a new solver.
#[test]
fn a_linear_response_is_refined_after_factors_in_single_precision() {
    let clamped = vec![Support::clamped("x_min")];
    let body = lower(NeoHookean, box_tetrahedra([10.0; 3], [20; 3]), gravity(10.0), clamped);
    let (stiff, mut solver) = (vec![75.0, 2000.0 * 75.0], Solver::new(&body).unwrap());
    let first = solver.linear_response(&stiff).unwrap();
    assert_eq!(solver.solve(&stiff, &Options::default()).unwrap().linear_iterations, 0);
    let again = solver.linear_response(&stiff).unwrap();
    // Residuals of 1e-10, amplified; single precision alone has an error above 1e-6.
    assert!(difference(&again, &first) < 1e-7, "{:e}", difference(&again, &first));
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
    // Residuals of 1e-10, amplified by a slender body; single precision alone has an error of 1e-3.
    assert!(difference(&single.0, &direct.0) < 1e-7);
    assert!(difference(&single.1, &direct.1) < 1e-7);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let beam = |averaged: bool| {
        let mesh = box_tetrahedra([100.0, 30.0, 30.0], [28, 10, 10]);
        let scene = Scene::new(mesh, NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
            .parameter(Parameter::log("lambda", "kPa", 1.0..=1e4))
            .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
            .support(Support::clamped("x_min"));
        let scene = if averaged { scene.averaged() } else { scene };
        (scene.lower().unwrap(), vec![75.0, 75.0])
    };
    let bodies = [
        (scene(ventricle(), 25.0).lower().unwrap(), VENTRICLE.to_vec()),
        // Nodal forces and energies are divided from some 16 000 points on.
        beam(false),
        beam(true),
    ];
    for (body, theta) in bodies {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| by(&body, &theta, Method::Aggregation).unwrap());
            (
                found.displacement,
                found.energy,
                found.residual,
                body.value(&vec![0.0; 3 * body.nodes], &theta),
            )
        };
        let one = on(1);
        for threads in [2, 7] {
            assert!(one == on(threads), "{} nodes, {threads} threads", body.nodes);
        }
    }
}

/// Guards against as many shares as threads, where the last digits would change from a few thousand unknowns on.
#[test]
fn a_factor_does_not_depend_on_the_number_of_threads() {
    /// Entries from which the dense blocks of a factor are divided.
    const LARGE: usize = 2_000_000;
    let clamped = vec![Support::clamped("x_min")];
    let body = lower(NeoHookean, box_tetrahedra([10.0; 3], [14; 3]), gravity(1.0), clamped);
    let solver = Solver::new(&body).unwrap();
    let [_, entries] = solver.stored_entries();
    assert!(entries > LARGE, "{entries} entries are not divided");
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut solver = solver.fresh().unwrap();
        let rest = vec![0.0; 3 * body.nodes];
        let mut steps = pool.install(|| solver.newton_steps(&rest, &[75.0, 75.0], 1).unwrap());
        steps.remove(0).displacement
    };
    let one = on(1);
    assert!(one.iter().any(|&u| u != 0.0));
    for threads in [2, 3, 5] {
        assert!(one == on(threads), "{threads} threads");
    }
}
