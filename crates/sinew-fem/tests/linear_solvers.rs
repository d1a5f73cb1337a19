//! The iterative linear solver against the direct one.

mod support;

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Prescribed, Scene, Support, Units};
use sinew_fem::{LinearSolver, Options, Solution, Solver};
use sinew_mesh::box_tetrahedra;
use support::{difference, gravity, lower, parameters};

const THETA: [f64; 2] = [75.0, 75.0];
/// Both end at the rounding floor of the forces; the beam's softest mode makes that 1e-10 of the displacement.
const SAME: f64 = 1e-9;

fn beam(cells: [usize; 3]) -> Body {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], cells);
    lower(NeoHookean, mesh, gravity(1.0), vec![Support::clamped("x_min")])
}

fn both(potential: &Body, theta: &[f64]) -> [Solution; 2] {
    [LinearSolver::Direct, LinearSolver::Iterative].map(|choice| {
        let mut solver = Solver::with_linear_solver(potential, choice).unwrap();
        solver.solve(theta, &Options::default()).unwrap()
    })
}

/// Poisson's ratio as λ/μ.
fn theta(poisson: f64) -> [f64; 2] {
    [75.0, 75.0 * 2.0 * poisson / (1.0 - 2.0 * poisson)]
}

#[test]
fn both_find_the_same_equilibrium_up_to_incompressibility() {
    // The last is too slow to iterate, so it is factorised after all.
    let potential = beam([20, 6, 6]);
    for poisson in [0.0, 0.25, 0.45, 0.49, 0.4999] {
        let [direct, iterative] = both(&potential, &theta(poisson));
        let distance = difference(&iterative.displacement, &direct.displacement);
        assert!(distance < SAME, "Poisson's ratio {poisson}: {distance:e}");
        assert!(iterative.is_stable());
        assert!(iterative.iterations() <= direct.iterations() + 1, "Poisson's ratio {poisson}");
    }
}

#[test]
fn components_that_are_held_alone_are_left_out() {
    let roller = Prescribed::Uniform([None, Some(0.0), None]);
    let supports =
        vec![Support::clamped("x_min"), Support { nodes: "y_min".into(), displacement: roller }];
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [16, 4, 4]);
    let potential = lower(NeoHookean, mesh, gravity(1.0), supports);
    let [direct, iterative] = both(&potential, &theta(0.3));
    assert!(difference(&iterative.displacement, &direct.displacement) < SAME);
}

/// The rigid motions that precondition the iteration must be along the axes of inclined supports.
#[test]
fn inclined_supports_take_no_more_iterations() {
    let iterations = [[1.0, 0.0], [0.8, 0.6]].map(|[cos, sin]| {
        let turned = |[x, y, z]: [f64; 3]| [x, cos * y - sin * z, sin * y + cos * z];
        let mut mesh = box_tetrahedra([100.0, 10.0, 10.0], [24, 6, 6]);
        mesh.points.iter_mut().for_each(|x| *x = turned(*x));
        let roller = Support::roller_on_plane("z_min", turned([0.0, 0.0, 1.0]));
        let supports = vec![Support::clamped("x_min"), roller];
        let load = Load::BodyForce(turned([0.0, 2e-3, 0.0]));
        let potential = lower(NeoHookean, mesh, vec![load], supports);
        let [direct, iterative] = both(&potential, &THETA);
        assert!(difference(&iterative.displacement, &direct.displacement) < SAME);
        let mut solver = Solver::with_linear_solver(&potential, LinearSolver::Iterative).unwrap();
        solver.solve(&THETA, &Options::default()).unwrap();
        solver.linear_iterations().expect("no factor took over")
    });
    assert!(iterations[1] <= iterations[0] + 1, "{iterations:?}");
}

#[test]
fn wider_couplings_are_solved_too() {
    let scene = Scene {
        name: "beam".into(),
        units: Units::mm_kpa(),
        mesh: box_tetrahedra([100.0, 10.0, 10.0], [16, 4, 4]),
        law: NeoHookean,
        directions: vec![],
        parameters: parameters(&["mu", "lambda"]),
        loads: gravity(1.0),
        supports: vec![Support::clamped("x_min")],
    };
    let [direct, iterative] = both(&scene.lower_averaged().unwrap(), &theta(0.49));
    assert!(difference(&iterative.displacement, &direct.displacement) < SAME);
    let Scene { name, units, mesh, law, directions, parameters, loads, supports } = scene;
    let mesh = mesh.quadratic();
    let scene = Scene { name, units, mesh, law, directions, parameters, loads, supports };
    let [direct, iterative] = both(&scene.lower().unwrap(), &theta(0.3));
    assert!(difference(&iterative.displacement, &direct.displacement) < SAME);
}

#[test]
fn negative_curvature_is_noticed() {
    // Shortened beyond its buckling load, in a symmetric mesh: only the curvature tells.
    let mesh = box_tetrahedra([100.0, 4.0, 4.0], [20, 1, 1]);
    let slide = Support::uniform("x_max", [Some(-10.0), Some(0.0), Some(0.0)]);
    let column = lower(NeoHookean, mesh, vec![], vec![Support::clamped("x_min"), slide]);
    let [straight, found] = both(&column, &THETA);
    assert!(!straight.is_stable());
    // An inexact step has a part across the column, and so leads out to where it has bowed.
    assert!(found.is_stable() && found.energy < straight.energy);
    let options = Options::default();
    let mut direct = Solver::with_linear_solver(&column, LinearSolver::Direct).unwrap();
    let bowed = direct.solve_from(&found.displacement, &THETA, &options).unwrap();
    assert!(bowed.is_stable() && (bowed.energy / found.energy - 1.0).abs() < 1e-12);
    // From the straight state itself there is no force to follow.
    let mut iterative = Solver::with_linear_solver(&column, LinearSolver::Iterative).unwrap();
    let again = iterative.solve_from(&straight.displacement, &THETA, &options).unwrap();
    assert!(!again.is_stable());
}

#[test]
fn sensitivities_agree() {
    let potential = beam([16, 4, 4]);
    let slopes = [LinearSolver::Direct, LinearSolver::Iterative].map(|choice| {
        let mut solver = Solver::with_linear_solver(&potential, choice).unwrap();
        let solution = solver.solve(&[75.0, 75.0], &Options::default()).unwrap();
        solver.sensitivity(&solution).unwrap().concat()
    });
    let largest = slopes[0].iter().map(|u| u.abs()).fold(0.0, f64::max);
    for (a, b) in slopes[0].iter().zip(&slopes[1]) {
        assert!((a - b).abs() < 1e-7 * largest, "{a} {b}");
    }
}

#[test]
fn iterates_do_not_depend_on_the_number_of_threads() {
    let potential = beam([24, 8, 8]);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver =
                Solver::with_linear_solver(&potential, LinearSolver::Iterative).unwrap();
            let solution = solver.solve(&THETA, &Options::default()).unwrap();
            let iterations = solver.linear_iterations().expect("no factor took over");
            assert!(iterations < 20, "{iterations}");
            solution.displacement
        })
    };
    assert!(on(1) == on(3));
}
