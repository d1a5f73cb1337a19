//! One network for unseen beams.

use sinew_emulate::Body;
use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
use sinew_fem::{Options, Solver};
use sinew_gnn::Budget;
use sinew_mesh::BeamShape;
use sinew_networks::{Error, Population, Start, StreamProgress};
use std::ops::ControlFlow;

/// A beam whose length, thickness and bend are different for every number.
fn beam(index: u64, cells: [usize; 3]) -> Body {
    let number = |k: u64| ((index % 1009 + 1) * (2 * k + 3) % 17) as f64 / 8.5 - 1.0;
    let numbers: Vec<f64> = (0..BeamShape::NUMBERS as u64).map(number).collect();
    let mesh = BeamShape::new(&numbers).unwrap().tetrahedra(cells).unwrap();
    Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap()
}

fn small(newton_steps: usize, steps: usize) -> Population {
    let mut recipe = Population { start: Start::Near { newton_steps }, ..Population::default() };
    recipe.network.width = 32;
    recipe.network.latent = 16;
    recipe.network.message_passing_steps = 2;
    recipe.training.budget = Budget::Steps(steps);
    recipe.training.evaluations = 2;
    recipe
}

fn distance(found: &[f64], truth: &[f64]) -> f64 {
    let squares: f64 = found.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / truth.iter().map(|u| u * u).sum::<f64>()).sqrt()
}

/// Errors raw, after a Newton step, and followed from the network's state after a Newton step; on a beam of the population and on one of another mesh.
#[test]
fn a_network_learns_beams_that_it_has_never_seen() {
    let recipe = small(1, 100);
    let draw = |index: u64| Ok(beam(index, [6, 2, 2]));
    let mut seen: Vec<StreamProgress> = Vec::new();
    let emulator = recipe
        .train(&draw, 3, &mut |progress, _| {
            seen.push(progress);
            Ok(ControlFlow::Continue(()))
        })
        .unwrap();
    assert_eq!(seen.iter().map(|progress| progress.step).collect::<Vec<_>>(), [50, 100]);
    let untrained = recipe.prepare(&draw, 3).unwrap();
    let again = recipe.train(&draw, 3, &mut |_, _| Ok(ControlFlow::Continue(()))).unwrap();
    for (index, cells) in [(501, [6, 2, 2]), (777, [7, 2, 3])] {
        let body = beam(index, cells);
        let theta = vec![60.0, 90.0];
        let truth = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
        let thetas = std::slice::from_ref(&theta);
        let error = |found: &[f64]| distance(found, &truth.displacement);
        let met = emulator.on(&body).unwrap();
        let predicted = met.predict(thetas).unwrap().displacement;
        let without = untrained.on(&body).unwrap().predict(thetas).unwrap().displacement;
        let without = error(&without);
        // A hundred steps take a part of what the first state lacks, on either mesh.
        assert!(error(&predicted) < 0.9 * without, "{} for {without}", error(&predicted));
        let corrected = met.correct(&theta, 3).unwrap();
        assert!(error(&corrected.displacement) < error(&predicted));
        // The same seed makes the same network, whatever thread prepared its bodies.
        let same = again.on(&body).unwrap().predict(thetas).unwrap().displacement;
        assert_eq!(same, predicted);
        // A state in equilibrium leaves the third order of the parameters.
        let carried = error(&emulator.expansion_on(&body, thetas, 8).unwrap()[0]);
        assert!(carried < 1e-2, "{carried}");
    }
}

#[test]
fn a_body_that_cannot_be_drawn_ends_a_training() {
    let draw = |index: u64| match index {
        3 => Err(Error::Draw { index, reason: "no shape".into() }),
        _ => Ok(beam(index, [4, 1, 1])),
    };
    let end = small(0, 50).train(&draw, 1, &mut |_, _| Ok(ControlFlow::Continue(())));
    let Err(error) = end else { panic!("the fourth body is none") };
    let error = error.to_string();
    assert!(error.contains("body 3 of the population could not be made: no shape"), "{error}");
}
