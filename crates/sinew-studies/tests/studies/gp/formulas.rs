//! Solutions, derivatives and rows of the experiments.

use super::deep::{WEIGHTS, adam, backward, forward, random_weights};
use super::pentagon::{Pentagon, corners};
use super::problems::*;
use super::row::{Label, Method, Row, Run, Truth};
use super::workers::each;
use anyhow::bail;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Central second difference along an axis, and first along another.
fn slope<const D: usize>(u: &Function<D>, x: [f64; D], axis: usize, order: usize) -> f64 {
    const STEP: f64 = 1e-3;
    let at = |shift: f64| {
        let mut moved = x;
        moved[axis] += shift * STEP;
        u(moved)
    };
    match order {
        1 => (at(1.0) - at(-1.0)) / (2.0 * STEP),
        _ => (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (STEP * STEP),
    }
}

/// Second differences with a step of 1e-3 of functions of size one.
const TOLERANCE: f64 = 1e-4;

#[test]
fn solutions_satisfy_their_equations() {
    let x = [0.37, 0.62];
    for (setting, left) in [
        (heat_1(), [[0.0, 1.0], [-1.0, 0.0]]),
        (wave_1(), [[0.0, 0.0], [-1.0, 1.0]]),
        (wave_2(), [[0.0, 0.0], [-1.0, 1.0]]),
        (advection_diffusion(), [[0.05, 1.0], [-0.025, 0.0]]),
        (helmholtz(), [[0.0, 0.0], [-1.0, -1.0]]),
    ] {
        let setting = setting.unwrap();
        let u = &setting.solution;
        let mut sum = if setting.name == "Helmholtz" { 9.0 * u(x) } else { 0.0 };
        for order in [1, 2] {
            for axis in [0, 1] {
                sum += left[order - 1][axis] * slope(u, x, axis, order);
            }
        }
        assert!((sum - (setting.load)(x)).abs() < TOLERANCE, "{}: {sum}", setting.name);
    }
    let (heat, x) = (heat_2().unwrap(), [0.4, 1.1, 0.3]);
    let u = &heat.solution;
    let sum = slope(u, x, 2, 1) - slope(u, x, 0, 2) - slope(u, x, 1, 2);
    assert!(sum.abs() < TOLERANCE);
    let poisson = poisson_1().unwrap();
    assert!((slope(&poisson.solution, [0.7], 0, 2) + (poisson.load)([0.7])).abs() < TOLERANCE);
}

#[test]
fn a_pentagons_solution_vanishes_on_all_edges_and_satisfies_the_equation() {
    let solution = Pentagon::solve();
    assert!(solution.bound < 1e-8, "{:e}", solution.bound);
    let corners = corners();
    for (k, [ax, ay]) in corners.iter().enumerate() {
        let [bx, by] = corners[(k + 1) % 5];
        let on_edge = [0.7 * ax + 0.3 * bx, 0.7 * ay + 0.3 * by];
        assert!(solution.value(on_edge).abs() < 1e-8);
    }
    const STEP: f64 = 1e-3;
    let u = |dx: f64, dy: f64| solution.value([0.2 + dx, -0.3 + dy]);
    let laplacian = u(STEP, 0.0) + u(-STEP, 0.0) + u(0.0, STEP) + u(0.0, -STEP) - 4.0 * u(0.0, 0.0);
    assert!((laplacian / (STEP * STEP) + 4.0).abs() < 1e-5);
    assert!(solution.value([0.0, 0.0]) > 0.6);
}

#[test]
fn derivatives_equal_differences() {
    const STEP: f64 = 1e-5;
    let weights = random_weights(4);
    let at = |x: f64| forward(&weights, x).output;
    let (after, before, here) = (at(0.3 + STEP), at(0.3 - STEP), at(0.3));
    for order in 0..2 {
        let difference = (after[order] - before[order]) / (2.0 * STEP);
        assert!((difference - here[order + 1]).abs() < 1e-8);
    }
    let adjoint = [0.7, -1.3, 0.4];
    let mut gradient = vec![0.0; WEIGHTS];
    backward(&weights, &forward(&weights, 0.3), adjoint, &mut gradient);
    for (number, slope) in gradient.iter().enumerate() {
        let objective = |step: f64| -> f64 {
            let mut moved = weights.clone();
            moved[number] += step;
            forward(&moved, 0.3).output.iter().zip(adjoint).map(|(o, a)| o * a).sum()
        };
        let difference = (objective(STEP) - objective(-STEP)) / (2.0 * STEP);
        assert!((difference - slope).abs() < 1e-8, "weight {number}");
    }
}

#[test]
fn adam_finds_a_minimum() {
    let mut x = vec![3.0, -2.0];
    adam(&mut x, 2000, [0.1, 1e-4], |x| vec![2.0 * (x[0] - 1.0), 20.0 * (x[1] - 0.5)]);
    assert!((x[0] - 1.0).abs() < 1e-3 && (x[1] - 0.5).abs() < 1e-3, "{x:?}");
}

#[test]
fn every_piece_is_done_once_on_one_thread() {
    let pieces: Vec<usize> = (0..50).collect();
    let done = each(3, &pieces, |number| {
        assert_eq!(rayon::current_num_threads(), 1);
        Ok(2 * number)
    });
    assert_eq!(done.unwrap(), pieces.iter().map(|number| 2 * number).collect::<Vec<_>>());
}

#[test]
fn an_error_stops_the_rest() {
    let done = AtomicUsize::new(0);
    let pieces: Vec<usize> = (0..100).collect();
    let error = each(1, &pieces, |number| {
        done.fetch_add(1, Ordering::Relaxed);
        if *number == 3 { bail!("piece {number}") } else { Ok(()) }
    });
    assert_eq!(error.unwrap_err().to_string(), "piece 3");
    assert!(done.into_inner() < 100);
}

fn label() -> Label {
    Label {
        problem: "Heat".into(),
        setting: String::new(),
        method: Method::Hcgp,
        abscissa: None,
        truth: vec![Truth { name: "theta".into(), value: 1.0 }],
    }
}

#[test]
fn a_run_needs_numbers_that_can_be_told() {
    let run = |err_u, seconds| Run { err_u, seconds, ..Run::default() }.checked();
    assert!(run(1e-3, 0.5).is_ok());
    for (err_u, seconds) in [(f64::NAN, 0.5), (1e-3, f64::INFINITY), (1e-3, -1.0)] {
        assert!(run(err_u, seconds).is_err());
    }
    let theta = vec![0.7, f64::NAN];
    assert!(Run { theta, ..Run::default() }.checked().is_err(), "no median of it could be told");
}

#[test]
fn rows_are_medians_with_ranges_and_need_a_run() {
    assert!(Row::of(label(), Vec::new(), Vec::new()).is_none());
    let run = |theta: f64| Run { theta: vec![theta], ..Run::default() };
    let row = Row::of(label(), [0.98, 1.005, 1.03].map(run).to_vec(), Vec::new()).unwrap();
    let theta = &row.theta()[0];
    assert_eq!((theta.q0, theta.q50, theta.q100), (0.98, 1.005, 1.03));
    assert!((row.err_theta().unwrap().q50 - 0.02).abs() < 1e-12);
}
