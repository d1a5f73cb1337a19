//! Expansions through several solved states.

use crate::to_an_accuracy::bar;
use sinew_emulate::coordinates::{Motions, halves};
use sinew_emulate::parts::{expand, scaling, with_anchors};
use sinew_emulate::{
    Body, Design, Emulator, Error, Train, TrainingOptions, recipe::Regression, recipe::Taylor,
};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;

fn apart(found: &[f64], truth: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut found.iter().zip(truth).map(|(a, b)| a - b)) / norm(&mut truth.iter().copied())
}

/// Motions through so many states, and the parameters of these.
fn through(body: &Body, count: usize) -> (Motions, Vec<Vec<f64>>) {
    let mut solver = Solver::new(body).unwrap();
    let solved = solver.solve(&body.centre(), &Options::default()).unwrap().displacement;
    let motions = Motions::about(&solved, &halves(&body.positions), body, &body.centre()).unwrap();
    let tried = Design::LatinHypercube.sample(&body.parameters, 16, 1).unwrap();
    let motions = expand(&mut solver, motions, &tried).unwrap().0;
    let motions = with_anchors(&mut solver, motions, count, 1, &mut ()).unwrap();
    let scaling = scaling(body).unwrap();
    let at = motions.anchors().unwrap().parameters();
    let found = at.iter().map(|x| scaling.unstandardise(x).unwrap()).collect();
    (motions, found)
}

#[test]
fn states_and_derivatives_are_met_at_every_anchor_and_no_anchor_is_taken_twice() {
    let body = bar();
    let (motions, anchors) = through(&body, 5);
    assert_eq!(anchors.len(), 5);
    let twice = |i: usize| anchors[..i].iter().any(|other| apart(other, &anchors[i]) < 1e-6);
    assert!(!(1..5).any(twice), "{anchors:?}");
    let (scaling, mut solver) = (scaling(&body).unwrap(), Solver::new(&body).unwrap());
    let at = |x: &[f64]| motions.expansion_at(x, &body).unwrap();
    for theta in &anchors {
        let x = scaling.standardise(theta).unwrap();
        let solution = solver.solve(theta, &Options::default()).unwrap();
        let off = apart(&at(&x), &solution.displacement);
        // Residuals of solves and the interpolation's nugget.
        assert!(off < 1e-5, "{theta:?}: {off:e}");
        let truth = solver.sensitivity(&solution).unwrap();
        for (p, slope) in scaling.slopes(theta).into_iter().enumerate() {
            const STEP: f64 = 1e-2;
            let moved = |sign: f64| {
                let mut x = x.clone();
                x[p] += sign * STEP;
                at(&x)
            };
            let (ahead, behind) = (moved(1.0), moved(-1.0));
            let found = ahead.iter().zip(&behind).map(|(a, b)| slope * (a - b) / (2.0 * STEP));
            let off = apart(&found.collect::<Vec<_>>(), &truth[p]);
            // Truncation of the difference, and the nugget over the step.
            assert!(off < 1e-3, "{theta:?}, {p}: {off:e}");
        }
    }
}

#[test]
fn anchors_lower_the_error_and_one_is_the_expansion_itself() {
    let body = bar();
    let thetas = Design::Uniform.sample(&body.parameters, 40, 5).unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let truth: Vec<Vec<f64>> = thetas
        .iter()
        .map(|theta| solver.solve(theta, &Options::default()).unwrap().displacement)
        .collect();
    let worst = |emulator: &Emulator<'_>| {
        let found = emulator.predict(&thetas).unwrap().fields();
        found.iter().zip(&truth).map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
    };
    let one = Emulator::taylor(&body, 1).unwrap();
    let same = Emulator::taylor_with_anchors(&body, 1, 1).unwrap();
    assert_eq!(one.predict(&thetas).unwrap(), same.predict(&thetas).unwrap());
    let several = Emulator::taylor_with_anchors(&body, 6, 1).unwrap();
    assert_eq!(several.record.simulations, 6);
    let [one, several_worst] = [&one, &several].map(worst);
    println!("largest relative error {several_worst:.1e} for {one:.1e}");
    assert!(several_worst < 0.1 * one, "{several_worst:e} for {one:e}");
    // It comes back from its files.
    let folder = tempfile::tempdir().unwrap();
    several.save(folder.path()).unwrap();
    let loaded = Emulator::load(folder.path(), &body).unwrap();
    assert_eq!(loaded.predict(&thetas).unwrap(), several.predict(&thetas).unwrap());
}

#[test]
fn an_anchor_without_an_equilibrium_is_refused_in_words() {
    // A membrane of rubber that bears no more than a twentieth of the largest pressure.
    let walls = box_tetrahedra([4.0, 4.0, 0.2], [8, 8, 1]);
    let load = Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Theta(2) };
    let mut scene = Scene::new(walls, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 0.9..=1.1))
        .parameter(Parameter::log("lambda", "kPa", 4.5..=5.5))
        .parameter(Parameter::log("p", "kPa", 1e-3..=2.0))
        .load(load);
    for set in ["x_min", "x_max", "y_min", "y_max"] {
        scene = scene.support(Support::clamped(set));
    }
    let body = scene.lower().unwrap();
    let error = Emulator::taylor_with_anchors(&body, 4, 1).map(|_| ()).unwrap_err();
    let words = error.to_string();
    assert!(
        words.starts_with("anchor ")
            && !words.starts_with("anchor 1 ")
            && words.contains("p = ")
            && words.contains("narrow the ranges"),
        "{words}"
    );
}

#[test]
fn numbers_of_anchors_that_make_no_sense_are_refused() {
    let body = bar();
    for anchors in [0, 51] {
        let error = Emulator::taylor_with_anchors(&body, anchors, 1).map(|_| ()).unwrap_err();
        assert!(matches!(error, Error::Setting { .. }), "{error}");
    }
    let options = TrainingOptions { anchors: 3, ..TrainingOptions::default() };
    let error = Regression::default().train(&body, &options, &mut ()).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("`regression` has no anchors"), "{error}");
    let emulator = Taylor.train(&body, &options, &mut ()).unwrap();
    assert_eq!(emulator.record.simulations, 3);
    assert!(emulator.record.about.contains("3 solutions"), "{}", emulator.record.about);
}
