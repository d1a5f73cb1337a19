//! Convergence of Newton's method on the gravity beams, and values of independent FEniCS runs.

use crate::support::{gravity, lower, once};
use sinew_energy::Support;
use sinew_energy::laws::NeoHookean;
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;

/// θ of the published values, μ = λ [kPa].
const THETA: [f64; 2] = [75.0, 75.0];

#[test]
fn refinement_follows_the_published_energies_and_deflections() {
    // Own FEniCS runs: Π [kPa mm³] and, where printed, u_z [mm] at the middle of the tip, to all printed digits.
    let cases: [([usize; 3], f64, Option<f64>); 2] =
        [([12, 4, 5], -766.97068, None), ([24, 8, 10], -1118.42188, Some(-50.4575))];
    for (cells, energy, tip) in cases {
        let mesh = box_tetrahedra([100.0, 10.0, 10.0], cells);
        let middle = mesh.points.iter().position(|&p| p == [100.0, 5.0, 5.0]);
        let potential = lower(NeoHookean, mesh, gravity(1.0), vec![Support::clamped("x_min")]);
        let mut solver = Solver::new(&potential).unwrap();
        let solution = solver.solve(&THETA, &Options::default()).unwrap();
        assert!((solution.energy - energy).abs() < 1e-5, "{}", solution.energy);
        if let Some(tip) = tip {
            let node = middle.expect("an even mesh has a node in the middle");
            assert!((solution.displacement[3 * node + 2] - tip).abs() < 5e-5);
        }
    }
}

#[test]
fn convergence_is_quadratic() {
    let potential = once();
    let solution = Solver::new(&potential).unwrap().solve(&THETA, &Options::default()).unwrap();
    let history = &solution.history.iterations;
    let relative = |i: usize| history[i].residual / solution.force_scale;
    let fast = (1..history.len()).filter(|&i| relative(i - 1) < 1e-2 && relative(i - 1) > 1e-6);
    for i in fast.clone() {
        // Constant of quadratic convergence of this beam with room to spare: measured 0.02–10.
        assert!(relative(i) < 100.0 * relative(i - 1).powi(2) + 1e-12, "{history:#?}");
    }
    assert!(fast.count() >= 1);
    assert!(solution.iterations() <= 8, "{}", solution.iterations());
    let last = history.last().unwrap();
    assert!(last.residual <= last.tolerance);
}

#[test]
fn a_solve_from_the_solution_takes_one_step() {
    let potential = once();
    let mut solver = Solver::new(&potential).unwrap();
    let cold = solver.solve(&THETA, &Options::default()).unwrap();
    let warm = solver.solve_from(&cold.displacement, &THETA, &Options::default()).unwrap();
    assert_eq!(warm.iterations(), 1);
    assert!(crate::support::difference(&warm.displacement, &cold.displacement) < 1e-12);
}

#[test]
fn the_energy_is_that_of_the_potential() {
    let potential = once();
    let solution = Solver::new(&potential).unwrap().solve(&THETA, &Options::default()).unwrap();
    let energy = potential.value(&solution.displacement, &THETA);
    assert!((solution.energy / energy - 1.0).abs() < 1e-13);
}
