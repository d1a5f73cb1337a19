//! Many solves of one body: nothing of one may leak into another.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Support, ThetaError};
use sinew_fem::{Options, SolveError, Solver, sweep};
use sinew_mesh::box_tetrahedra;

#[test]
fn a_jump_in_theta_by_a_million_leaves_no_trace_in_the_next_solve() {
    let beam = once();
    let options = Options::default();
    let mut used = Solver::new(&beam).unwrap();
    for theta in [[75.0, 75.0], [7.5e7, 7.5e7], [50.0, 5e5], [75.0, 75.0], [60.0, 0.0]] {
        let warm = used.solve(&theta, &options).unwrap();
        let cold = Solver::new(&beam).unwrap().solve(&theta, &options).unwrap();
        assert_eq!(warm.displacement, cold.displacement, "bit for bit");
        assert_eq!(warm.history, cold.history);
    }
}

#[test]
fn a_failed_solve_leaves_no_trace_in_the_next_one() {
    let mesh = box_tetrahedra([10.0; 3], [2; 3]);
    let squeeze = Support::uniform("x_max", [Some(-9.9), Some(0.0), Some(0.0)]);
    let body = lower(NeoHookean, mesh, vec![], vec![Support::clamped("x_min"), squeeze]);
    let tight = Options { iterations: 30, ..Options::default() };
    let mut used = Solver::new(&body).unwrap();
    let first = used.solve(&[1.0, 1.0], &tight);
    used.solve(&[f64::NAN, 1.0], &tight).unwrap_err();
    let again = used.solve(&[1.0, 1.0], &tight);
    match (first, again) {
        (Ok(a), Ok(b)) => assert_eq!((a.displacement, a.history), (b.displacement, b.history)),
        (Err(a), Err(b)) => assert_eq!(a, b),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sweep_with_senseless_samples_refuses_them_and_solves_the_others() {
    let beam = once();
    let good = |i: usize| vec![50.0 + 5.0 * i as f64, 100.0 - 5.0 * i as f64];
    let mut thetas: Vec<_> = (0..9).map(good).collect();
    thetas[3] = vec![75.0];
    thetas[4] = vec![f64::NAN, 75.0];
    thetas[6] = vec![75.0, f64::INFINITY];
    let swept = sweep(&beam, &thetas, &Options::default(), || ()).unwrap();
    let mut solver = Solver::new(&beam).unwrap();
    for (i, result) in swept.iter().enumerate() {
        if let 3 | 4 | 6 = i {
            assert!(matches!(result, Err(SolveError::Theta(_))), "{i}");
            continue;
        }
        let cold = solver.solve(&good(i), &Options::default()).unwrap();
        let off = difference(&result.as_ref().unwrap().displacement, &cold.displacement);
        assert!(off < 1e-10, "{i}: {off:e}");
    }
    let expected = ThetaError::Length { given: 1, needed: 2, names: vec!["mu", "lambda"] };
    assert_eq!(swept[3].as_ref().unwrap_err(), &SolveError::Theta(expected));
}

#[test]
fn a_sweep_across_ten_orders_of_magnitude_agrees_with_cold_solves() {
    // Neighbours a hundred times as stiff: guesses from the neighbour are bad and must not matter.
    let beam = once();
    let thetas: Vec<_> =
        (0..5).map(|i| vec![50.0 * 100f64.powi(i), 60.0 * 100f64.powi(i)]).collect();
    let swept = sweep(&beam, &thetas, &Options::default(), || ()).unwrap();
    let mut solver = Solver::new(&beam).unwrap();
    for (theta, solution) in thetas.iter().zip(swept.into_iter().map(Result::unwrap)) {
        let cold = solver.solve(theta, &Options::default()).unwrap();
        // Stresses are known to rounding of the modulus: the stiffer, the fewer digits of the strain.
        let known = 1e-10 + 1e-17 * theta[0];
        assert!(difference(&solution.displacement, &cold.displacement) < known, "{theta:?}");
    }
}

#[test]
fn an_empty_sweep_is_empty() {
    let swept = sweep(&once(), &[], &Options::default(), || ()).unwrap();
    assert!(swept.is_empty());
}

#[test]
fn a_sweep_of_a_free_body_is_refused_as_a_whole() {
    let mut mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    mesh.node_sets.insert("corner".into(), vec![0]);
    let beam = lower(NeoHookean, mesh, gravity(1.0), vec![Support::clamped("corner")]);
    let error = sweep(&beam, &[vec![75.0; 2]], &Options::default(), || ()).unwrap_err();
    assert!(matches!(error, SolveError::FreeToMove { .. }));
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    // More samples than a chain has, one of them bad.
    let beam = lower(
        NeoHookean,
        box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]),
        gravity(0.3),
        vec![Support::clamped("x_min")],
    );
    let mut thetas: Vec<_> =
        (0..60).map(|i| vec![1.0 + f64::from(i % 7), 1.0 + f64::from(i * 11 % 60)]).collect();
    thetas[31] = vec![-1.0, 1.0];
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sweep(&beam, &thetas, &Options::default(), || ())).unwrap()
    };
    for (one, two) in run(1).into_iter().zip(run(2)) {
        match (one, two) {
            (Ok(a), Ok(b)) => {
                assert_eq!((a.displacement, a.history), (b.displacement, b.history));
            }
            (Err(a), Err(b)) => assert_eq!(a, b),
            other => panic!("{other:?}"),
        }
    }
}
