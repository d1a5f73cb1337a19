//! Sweeps over θ and derivatives in θ.

use crate::support::{difference, once, twice};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Sampling, Scene, SceneError, Support};
use sinew_fem::{Options, Progress, Solution, SolveError, Solver, neighbours, resume_sweep, sweep};
use sinew_mesh::box_tetrahedra;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Log-uniform Latin hypercube over [50, 100]² by a fixed permutation.
fn thetas(count: usize) -> Vec<Vec<f64>> {
    let stiffness = |place: usize| 50.0 * 2.0_f64.powf((place as f64 + 0.5) / count as f64);
    // 77 has no factor in common with the counts used here, so each column is a permutation.
    (0..count).map(|i| vec![stiffness(i), stiffness((i * 77 + 31) % count)]).collect()
}

#[test]
fn the_order_visits_every_point_once_and_neighbours_in_a_row() {
    let line: Vec<_> = [1.0, 100.0, 10.0, 1000.0].map(|x| vec![x]).to_vec();
    assert_eq!(neighbours(&line), [0, 2, 1, 3]);
    assert!(neighbours(&[]).is_empty());
}

#[test]
fn senseless_values_have_a_place_too() {
    assert_eq!(neighbours(&[vec![f64::NAN], vec![-1.0], vec![2.0]]).len(), 3);
    // As if they were equal.
    assert_eq!(neighbours(&[vec![f64::INFINITY], vec![]]), [0, 1]);
}

#[test]
fn results_are_those_of_single_solves_in_the_order_given_for_any_number_of_threads() {
    let potential = once();
    let thetas = thetas(60);
    let count = AtomicUsize::new(0);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let progress = || {
            count.fetch_add(1, Ordering::Relaxed);
        };
        pool.install(|| sweep(&potential, &thetas, &Options::default(), progress)).unwrap()
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(count.load(Ordering::Relaxed), 120);
    let mut solver = Solver::new(&potential).unwrap();
    for (i, (a, b)) in one.iter().zip(&two).enumerate() {
        let (a, b) = (a.as_ref().unwrap(), b.as_ref().unwrap());
        assert_eq!(a.displacement, b.displacement, "bit for bit");
        assert_eq!(a.theta, thetas[i]);
        if i % 20 == 0 {
            let cold = solver.solve(&thetas[i], &Options::default()).unwrap();
            assert!(difference(&a.displacement, &cold.displacement) < 1e-10);
        }
    }
}

#[test]
fn warm_starts_take_few_iterations() {
    let thetas = thetas(50);
    let swept = sweep(&once(), &thetas, &Options::default(), || ()).unwrap();
    let mut iterations: Vec<_> =
        swept.iter().map(|result| result.as_ref().unwrap().iterations()).collect();
    iterations.sort_unstable();
    assert!(iterations[25] <= 4, "{iterations:?}");
}

#[test]
fn every_state_of_every_solve_of_a_sweep_can_be_watched() {
    let (found, states) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let each = |_, result: Result<Solution, SolveError>| {
        found.fetch_add(result.unwrap().history.iterations.len(), Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let watch = |state: &Progress<'_>| {
        let told = (state.in_words(), state.iteration, state.seconds_left);
        states.lock().unwrap().push(told);
    };
    resume_sweep(&once(), &thetas(3), &[], &Options::default(), each, watch).unwrap();
    let states = states.into_inner().unwrap();
    assert_eq!(states.len(), found.into_inner());
    let (first, _, left) = &states[0];
    assert!(first.starts_with("load ") && first.contains(", iteration 0, residual "), "{first}");
    assert_eq!(*left, None);
    // Time is left until the residual is below the tolerance.
    let known = states.iter().filter_map(|(_, now, left)| Some((now, (*left)?)));
    let known: Vec<_> = known.collect();
    assert!(known.len() >= 3);
    assert!(known.iter().all(|(now, left)| (*left > 0.0) == (now.residual > now.tolerance)));
}

#[test]
fn failed_samples_have_their_error_and_the_others_stay() {
    let mut thetas = thetas(10);
    thetas[4] = vec![f64::NAN, 75.0];
    thetas[7] = vec![-1.0, 75.0];
    let swept = sweep(&twice(), &thetas, &Options::default(), || ()).unwrap();
    for (i, result) in swept.iter().enumerate() {
        assert_eq!(matches!(result, Err(SolveError::Theta(_))), i == 4 || i == 7, "{i}");
    }
}

/// A plate clamped all around that a pressure bulges; θ = (μ, λ, pressure).
fn plate() -> Body {
    let mut scene = Scene {
        name: "inflated block".into(),
        parameters: crate::support::parameters(&["mu", "lambda", "pressure"]),
        loads: vec![Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Theta(2) }],
        supports: ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec(),
        ..Scene::new(box_tetrahedra([10.0, 10.0, 4.0], [4, 4, 2]), NeoHookean)
    };
    scene.parameters[2].sampling = Sampling::Linear;
    scene.lower().unwrap()
}

#[test]
fn derivatives_in_theta_agree_with_central_differences() {
    let potential = plate();
    let theta = [6.0, 9.0, 3.0];
    let mut solver = Solver::new(&potential).unwrap();
    let solution = solver.solve(&theta, &Options::default()).unwrap();
    assert!(solution.displacement.iter().fold(0.0, |m: f64, u| m.max(*u)) > 0.5, "it bulges");
    let columns = solver.sensitivity(&solution).unwrap();
    assert_eq!(columns.len(), 3);
    let weights: Vec<f64> =
        (0..solution.displacement.len()).map(|i| ((i * 31) % 7) as f64 - 3.0).collect();
    let adjoint = solver.adjoint_sensitivity(&solution, &weights).unwrap();
    for (column, entry) in columns.iter().zip(&adjoint) {
        let direct: f64 = column.iter().zip(&weights).map(|(u, w)| u * w).sum();
        assert!((direct - entry).abs() < 1e-10 * direct.abs(), "{direct} {entry}");
    }
    for (index, column) in columns.iter().enumerate() {
        // Relative step that balances truncation and the solver's rounding.
        let step = 1e-4 * theta[index];
        let mut moved = |sign: f64| {
            let mut theta = theta;
            theta[index] += sign * step;
            solver
                .solve_from(&solution.displacement, &theta, &Options::default())
                .unwrap()
                .displacement
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        let quotient: Vec<_> = up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        assert!(
            difference(column, &quotient) < 1e-7,
            "{index}: {:e}",
            difference(column, &quotient)
        );
    }
}

#[test]
fn known_parameters_leave_the_solution_and_the_derivatives_in_the_others() {
    let whole = plate();
    let solved = |body: &Body, theta: &[f64]| {
        let mut solver = Solver::new(body).unwrap();
        let solution = solver.solve(theta, &Options::default()).unwrap();
        let columns = solver.sensitivity(&solution).unwrap();
        (solution.displacement, columns)
    };
    let (displacement, columns) = solved(&whole, &[6.0, 9.0, 3.0]);
    let known: [(&[_], &[f64], &[usize]); 3] = [
        (&[("mu", 6.0)], &[9.0, 3.0], &[1, 2]),
        (&[("pressure", 3.0), ("lambda", 9.0)], &[6.0], &[0]),
        (&[("pressure", 3.0), ("lambda", 9.0), ("mu", 6.0)], &[], &[]),
    ];
    for (known, theta, left) in known {
        let body = whole.clone().with_known(known).unwrap();
        assert_eq!(body.parameters.len(), theta.len());
        let found = solved(&body, theta);
        assert_eq!(found.0, displacement, "bit for bit");
        let expected: Vec<_> = left.iter().map(|&index| columns[index].clone()).collect();
        assert_eq!(found.1, expected);
    }
    let refused = |known| whole.clone().with_known(&[known]).unwrap_err();
    assert!(refused(("nu", 0.4)).to_string().starts_with("there is no parameter `nu`"));
    assert!(matches!(refused(("mu", -1.0)), SceneError::KnownValue { value: -1.0, .. }));
    assert!(matches!(refused(("pressure", f64::NAN)), SceneError::NotFinite { .. }));
    let twice = whole.clone().with_known(&[("mu", 6.0), ("mu", 7.0)]).unwrap_err();
    assert_eq!(
        twice,
        SceneError::Body("`mu` is there twice among the known parameters; keep one value".into())
    );
    let body = whole.with_known(&[("mu", 6.0)]).unwrap().with_known(&[("pressure", 3.0)]).unwrap();
    assert_eq!(body.known, [("mu".to_string(), 6.0), ("pressure".to_string(), 3.0)]);
}
