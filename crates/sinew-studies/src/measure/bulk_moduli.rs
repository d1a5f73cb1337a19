//! Newton iterations from rest by the bulk modulus: beams under gravity and ventricles under pressure.

use super::mean_ventricle::ventricle;
use anyhow::{Context, Result};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;
use std::time::Instant;

/// Parameter sets of a body.
const SETS: usize = 8;

fn beam() -> Scene {
    Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 30.0..=200.0))
        .parameter(Parameter::log("lambda", "kPa", 30.0..=2e6))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // kPa/mm
        .support(Support::clamped("x_min"))
}

fn quadratic_beam() -> Result<Body> {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [6, 2, 2]).quadratic();
    let Scene { parameters, loads, supports, .. } = beam();
    Ok(Scene { parameters, loads, supports, ..Scene::new(mesh, NeoHookean) }.lower()?)
}

/// A permutation of places for each parameter, from the lower end of its range to the upper one.
fn thetas(ranges: &[[f64; 2]]) -> Vec<Vec<f64>> {
    let at = |set: usize, entry: usize| (set * [1, 3, 5, 7][entry % 4] + 2 * entry) % SETS;
    let value = |set: usize, (entry, range): (usize, &[f64; 2])| {
        let share = at(set, entry) as f64 / (SETS - 1) as f64;
        range[0] * (range[1] / range[0]).powf(share)
    };
    (0..SETS).map(|set| ranges.iter().enumerate().map(|r| value(set, r)).collect()).collect()
}

fn measure(name: &str, body: &Body, thetas: &[Vec<f64>]) -> Result<()> {
    let mut solver = Solver::new(body)?;
    let (start, mut counts, mut failed) = (Instant::now(), Vec::new(), 0);
    for theta in thetas {
        match solver.solve(theta, &Options::default()) {
            Ok(solution) => counts.push(solution.history.iterations.len()),
            Err(_) => failed += 1,
        }
    }
    let mean = counts.iter().sum::<usize>() as f64 / counts.len() as f64;
    let most = counts.iter().max().context("no set has an equilibrium")?;
    let seconds = start.elapsed().as_secs_f64() / thetas.len() as f64;
    println!(
        "{name:36} {mean:5.1} iterations, at most {most}, {seconds:.2} s a set, {failed} failed"
    );
    Ok(())
}

/// Prints a line for each body.
pub(super) fn run() -> Result<()> {
    let (averaged, quadratic) = (beam().averaged().lower()?, quadratic_beam()?);
    for ratio in [1.0, 1e2, 1e4] {
        let mut sets = thetas(&[[30.0, 200.0]]);
        sets.iter_mut().for_each(|theta| theta.push(ratio * theta[0]));
        measure(&format!("averaged beam, lambda {ratio} mu"), &averaged, &sets)?;
        measure(&format!("quadratic beam, lambda {ratio} mu"), &quadratic, &sets)?;
    }
    for bulk_modulus in [25.0, 1e3, 1e4, 1e5] {
        for (kind, is_averaged) in [("plain", false), ("averaged", true)] {
            let body = ventricle([2, 16, 8], bulk_modulus, is_averaged)?;
            let ranges: Vec<[f64; 2]> = body.parameters.iter().map(|p| p.range).collect();
            let name = format!("{kind} ventricle, K {bulk_modulus} kPa");
            measure(&name, &body, &thetas(&ranges))?;
        }
    }
    Ok(())
}
