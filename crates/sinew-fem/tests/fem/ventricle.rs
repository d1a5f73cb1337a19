//! Left ventricles under a true follower pressure: the softest body, points of the thesis' parameter box, and the
//! work of the pressure.

use crate::support::ventricle::{BOX, BULK_MODULUS, MMHG, scene, thetas};
use crate::ventricles::{fixture, ventricles};
use sinew_fem::{Options, Solution, Solver};
use sinew_mesh::TetMesh;

/// Rounding of the nodal forces, relative to the forces themselves.
const BALANCED: f64 = 1e-12;

fn assert_sound(solution: &Solution) {
    println!(
        "{:.3?}: {} iterations, {} load steps, {:.2} s, min J {:.3}",
        solution.theta,
        solution.iterations(),
        solution.load_steps,
        solution.seconds,
        solution.least_volume_ratio
    );
    assert!(solution.residual <= BALANCED * solution.force_scale, "{}", solution.history);
    assert!(solution.is_stable());
    assert!(solution.least_volume_ratio > 0.4);
    // The most of 301 samples is 25, from rest to the whole load at once.
    assert!(solution.history.iterations.len() <= 40, "{}", solution.history);
    assert_eq!(solution.load_steps, 1);
}

#[test]
fn the_fixture_is_what_the_generator_writes() {
    let file = std::fs::read_to_string(fixture("ventricle.vtk")).expect("part of the repository");
    let made = crate::support::organ::file();
    let other = concat!(env!("CARGO_TARGET_TMPDIR"), "/ventricle.vtk");
    if file != made {
        std::fs::write(other, made).expect("a folder for files of tests");
        panic!("the generator writes {other}");
    }
}

#[test]
fn the_softest_body_and_sobol_points_converge_at_ten_mmhg() {
    for (name, mesh) in ventricles() {
        println!("{name}");
        assert_converges(mesh);
    }
}

fn assert_converges(mesh: TetMesh) {
    let potential = scene(mesh, BULK_MODULUS).lower().unwrap();
    let mut solver = Solver::new(&potential).unwrap();
    let samples = thetas(6, 10.0 * MMHG);
    let softest = BOX.map(|(_, range)| range[0]);
    samples[0].iter().zip(softest).for_each(|(a, b)| assert!((a - b).abs() < 1e-15));
    let mut largest = 0.0;
    for (index, theta) in samples.iter().enumerate() {
        let solution = solver.solve(theta, &Options::default()).unwrap();
        assert_sound(&solution);
        let (nodes, _) = solution.displacement.as_chunks::<3>();
        let motion = nodes.iter().map(|u| u[0].hypot(u[1]).hypot(u[2])).fold(0.0, f64::max);
        if index == 0 {
            largest = motion;
        }
        assert!(motion <= largest, "no body moves farther than the softest");
    }
}

#[test]
fn the_pressure_does_its_work_on_the_cavity() {
    for (name, mesh) in ventricles() {
        println!("{name}");
        assert_works_on_the_cavity(mesh);
    }
}

fn assert_works_on_the_cavity(mesh: TetMesh) {
    let scene = scene(mesh, BULK_MODULUS);
    let potential = scene.lower().unwrap();
    let mut solver = Solver::new(&potential).unwrap();
    let [a, b, a_f, b_f, p] = thetas(3, 6.0 * MMHG)[3];
    let solution = solver.solve(&[a, b, a_f, b_f, p], &Options::default()).unwrap();
    assert_sound(&solution);

    // At equilibrium the potential Π(u(p), p) changes with p by −ΔV only: u is stationary.
    let step = 1e-3 * p; // balances the truncation and rounding of a central difference
    let mut energy = |pressure: f64| {
        let theta = [a, b, a_f, b_f, pressure];
        solver.solve_from(&solution.displacement, &theta, &Options::default()).unwrap().energy
    };
    let slope = (energy(p + step) - energy(p - step)) / (2.0 * step);
    let cavity = |u: &[f64]| potential.cavity_volumes(u)[0];
    let rest = vec![0.0; solution.displacement.len()];
    let widened = cavity(&solution.displacement) - cavity(&rest);
    assert!(widened > 0.3 * cavity(&rest), "the cavity widens");
    assert!((slope + widened).abs() < 1e-5 * widened, "{slope} against {widened}");
}
