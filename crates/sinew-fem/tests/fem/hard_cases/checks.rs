//! Checks of every result.

pub(crate) use crate::support::difference;
use sinew_energy::Body;
use sinew_fem::{NotConverged, Options, Solution, SolveError, Solver};

/// Unbalanced forces relative to loads and reactions: rounding in sums of some thousand terms.
const BALANCE: f64 = 1e-9;

/// A cold solve with the usual options.
pub(crate) fn solve(potential: &Body, theta: &[f64]) -> Result<Solution, SolveError> {
    let solution = Solver::new(potential)?.solve(theta, &Options::default())?;
    println!(
        "{} iterations, {} load steps, min J {:.3}, residual {:.1e}, {:.1} ms",
        solution.history.iterations.len(),
        solution.load_steps,
        solution.least_volume_ratio,
        solution.residual,
        1e3 * solution.seconds
    );
    Ok(solution)
}

/// A stable equilibrium, see [`assert_equilibrium`].
#[track_caller]
pub(crate) fn assert_sound(potential: &Body, solution: &Solution) {
    assert_equilibrium(potential, solution);
    assert!(solution.is_stable());
    assert_minimum(potential, solution);
}

/// Supports obeyed, forces balanced, no cell inverted: by the potential, not by the solver's own assembly.
#[track_caller]
pub(crate) fn assert_equilibrium(potential: &Body, solution: &Solution) {
    let Solution { displacement, theta, .. } = solution;
    let (gradient, energy) = gradient_and_energy(potential, displacement, theta);
    assert!(energy.is_finite() && solution.least_volume_ratio > 0.0);
    // Two orders of summation.
    let terms =
        energy.abs().max(displacement.iter().zip(&gradient).map(|(u, g)| (u * g).abs()).sum());
    assert!((energy - solution.energy).abs() <= 1e-9 * terms, "{energy} {}", solution.energy);
    let (mut free, mut held) = (0.0, 0.0);
    for (i, prescribed) in potential.prescribed.iter().enumerate() {
        match prescribed {
            Some(target) => {
                assert_eq!(displacement[i], *target);
                held += gradient[i] * gradient[i];
            }
            None => free += gradient[i] * gradient[i],
        }
    }
    let last = solution.history.iterations.last().unwrap();
    let scale = f64::sqrt(held) + norm(&potential.nodal_force);
    let allowed = last.tolerance.max(BALANCE * scale);
    assert!(f64::sqrt(free) <= allowed, "{:e} > {allowed:e}\n{}", free.sqrt(), solution.history);
}

/// No disturbance lowers the energy: scattered ones of three sizes, and more or less of the same motion.
#[track_caller]
pub(crate) fn assert_minimum(potential: &Body, solution: &Solution) {
    let Solution { displacement, theta, energy, .. } = solution;
    let largest = displacement.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
    let size = if largest > 0.0 { largest } else { 1.0 };
    let scattered = |i: usize| size * (((i * 7919 + 13) % 101) as f64 / 50.0 - 1.0);
    // Rounding in a sum over the cells, and in the terms of first order in the strain that cancel in an
    // isochoric invariant: about the root of energy times modulus.
    let modulus = theta.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    let volume: f64 = potential.volumes.iter().sum();
    let first_order = (2.0 * energy.abs() * modulus * volume).sqrt();
    let noise = 1e-12 * energy.abs().max(f64::MIN_POSITIVE) + 16.0 * f64::EPSILON * first_order;
    for scale in [0.1, -1e-3, 1e-5] {
        for direction in [&scattered as &dyn Fn(usize) -> f64, &|i| displacement[i]] {
            let disturbed: Vec<_> = (0..displacement.len())
                .map(|i| match potential.prescribed[i] {
                    Some(target) => target,
                    None => displacement[i] + scale * direction(i),
                })
                .collect();
            let raised = potential.value(&disturbed, theta) - energy;
            assert!(
                raised >= -noise,
                "a disturbance of {scale} changes the energy by {raised:e}, noise {noise:e}\n{}",
                solution.history
            );
        }
    }
}

/// Derivative of the potential in every degree of freedom, and its value.
pub(crate) fn gradient_and_energy(
    potential: &Body,
    displacement: &[f64],
    theta: &[f64],
) -> (Vec<f64>, f64) {
    let mut gradient = vec![0.0; displacement.len()];
    let energy = potential.value_and_gradient(displacement, theta, &mut gradient);
    (gradient, energy)
}

/// The force \[stress·length²\] that holds the nodes of a set.
pub(crate) fn reaction(potential: &Body, solution: &Solution, nodes: &[usize]) -> [f64; 3] {
    let (gradient, _) = gradient_and_energy(potential, &solution.displacement, &solution.theta);
    std::array::from_fn(|i| nodes.iter().map(|node| gradient[3 * node + i]).sum())
}

/// The failure of a solve that has no solution.
#[track_caller]
pub(crate) fn failure(result: Result<Solution, SolveError>) -> NotConverged {
    match result {
        Err(SolveError::NotConverged(failure)) => {
            println!("{failure}");
            assert!(failure.displacement.iter().all(|u| u.is_finite()));
            *failure
        }
        Err(other) => panic!("expected no convergence, got {other}"),
        Ok(solution) => panic!("expected no convergence, got an energy of {}", solution.energy),
    }
}

/// The error of a solver that cannot be prepared.
#[track_caller]
pub(crate) fn refusal(potential: &Body) -> SolveError {
    match Solver::new(potential) {
        Err(error) => {
            println!("{error}");
            error
        }
        Ok(_) => panic!("the solver accepted it"),
    }
}

#[track_caller]
pub(crate) fn assert_close(value: f64, expected: f64, relative: f64) {
    let error = (value - expected).abs();
    assert!(error <= relative * expected.abs(), "{value} is not {expected}, off by {error:e}");
}

pub(crate) fn norm(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}
