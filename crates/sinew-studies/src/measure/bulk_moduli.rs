//! Newton iterations from rest by the bulk modulus: beams under gravity and ventricles under pressure.

use anyhow::{Context, Result};
use sinew_energy::laws::{HolzapfelOgden, NeoHookean};
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_fem::{Options, Solver};
use sinew_mesh::{VentricleShape, box_tetrahedra};
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

fn ventricle(bulk_modulus: f64, averaged: bool) -> Result<Body> {
    let mesh = VentricleShape::new(&[])?.tetrahedra([2, 16, 8])?;
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY)?;
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    let law = HolzapfelOgden.nearly_incompressible(bulk_modulus); // kPa
    let fibres = frames.iter().map(|&[fibre, _, _]| [fibre]).collect();
    let scene = Scene::new(mesh, law.along(fibres))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 0.53..=1.33))
        .load(pressure)
        .support(Support::clamped("base"));
    Ok(if averaged { scene.averaged().lower()? } else { scene.lower()? })
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
            let body = ventricle(bulk_modulus, is_averaged)?;
            let ranges: Vec<[f64; 2]> = body.parameters.iter().map(|p| p.range).collect();
            let name = format!("{kind} ventricle, K {bulk_modulus} kPa");
            measure(&name, &body, &thetas(&ranges))?;
        }
    }
    Ok(())
}
