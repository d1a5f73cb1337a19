//! Every recipe beside the solver. The bounds are three times what was measured.

use crate::support::{beam, small_network, steps};
use sinew_emulate::{
    Design, Emulator, Errors, Observer, TestSet, TrainingOptions, Warning, simulate,
};
use sinew_fem::{Options, Solver};
use sinew_gnn::recipe::{DataDriven, PhysicsInformed, Regression};
use sinew_gnn::{OutputCoordinates, Recipe};

/// Errors over cases that the emulator has not seen, neither in training nor in calibration.
fn errors(emulator: &Emulator<'_>) -> Errors {
    let body = emulator.body();
    let thetas = Design::Uniform.sample(&body.parameters, 40, 77).unwrap();
    let test = TestSet::new(body, simulate(body, &thetas, "test", None, &mut ()).unwrap());
    test.errors(&emulator.predict(&test.thetas).unwrap().fields()).unwrap()
}

fn check(emulator: &Emulator<'_>, relative: f64, energy_pct: f64) {
    let errors = errors(emulator);
    println!(
        "{}: relative {:.1e} (worst {:.1e}), err_u {:.1e} mm, err_F {:.1e} %, err_Pi {:.1e} %, {:?}",
        emulator.record.recipe,
        errors.relative.q50,
        errors.relative.max,
        errors.err_u.q50,
        errors.err_f.q50,
        errors.err_pi.q50,
        emulator.record.calibration,
    );
    assert!(errors.relative.q50 < relative, "{:.2e}", errors.relative.q50);
    assert!(errors.err_pi.q50 < energy_pct, "{:.2e}", errors.err_pi.q50);
    assert!(emulator.record.calibration.within_two >= 0.95, "{:?}", emulator.record.calibration);
    assert_eq!(emulator.record.warnings, []);
}

#[test]
fn regression_on_few_simulations_is_nearly_exact() {
    let body = beam(1.0);
    let recipe = Recipe::from(Regression { simulations: 16, ..Regression::default() });
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    assert_eq!(emulator.record.simulations, 16);
    check(&emulator, 1e-4, 1e-4);
}

#[test]
fn a_second_order_expansion_needs_no_training() {
    let body = beam(1.0);
    let emulator = Recipe::Taylor.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    assert_eq!((emulator.record.simulations, emulator.record.steps), (1, 0));
    check(&emulator, 5e-3, 0.02);
    // At the centre of the ranges it is the solution, and its derivatives are those of the solution.
    let (centre, mut solver) = (body.centre(), Solver::new(&body).unwrap());
    let solution = solver.solve(&centre, &Options::default()).unwrap();
    let at_centre = emulator.predict(std::slice::from_ref(&centre)).unwrap();
    assert!(apart(at_centre.field(0), &solution.displacement) < 1e-9);
    let truth = solver.sensitivity(&solution).unwrap();
    for (found, truth) in emulator.sensitivity(&centre).unwrap().iter().zip(&truth) {
        assert!(apart(found, truth) < 1e-4);
    }
    // It comes back from its files.
    let folder = tempfile::tempdir().unwrap();
    emulator.save(folder.path()).unwrap();
    let theta = [vec![60.0, 90.0]];
    let loaded = sinew_gnn::load(folder.path(), &body).unwrap().predict(&theta).unwrap();
    let stored = emulator.predict(&theta).unwrap();
    assert!(apart(loaded.field(0), stored.field(0)) < 1e-12);
}

#[test]
fn networks_learn_what_several_solutions_leave() {
    let body = beam(1.0);
    let options = TrainingOptions { anchors: 4, ..TrainingOptions::default() };
    let expansion = Recipe::Taylor.train(&body, &options, &mut ()).unwrap();
    let recipe = PhysicsInformed::default();
    let training = steps(&recipe.training, 1);
    let recipe = Recipe::from(PhysicsInformed { network: small_network(), training, ..recipe });
    let emulator = recipe.train(&body, &options, &mut ()).unwrap();
    assert_eq!(emulator.record.simulations, 4);
    assert!(emulator.record.about.contains("4 solutions"), "{}", emulator.record.about);
    // After one step it is still the expansion, but for single precision and that step.
    let theta = vec![9.0, 15.0];
    let thetas = std::slice::from_ref(&theta);
    let found = emulator.predict(thetas).unwrap();
    let off = apart(found.field(0), expansion.predict(thetas).unwrap().field(0));
    assert!(off < 1e-2, "{off:e}");
    // Its exact derivatives are those by differences.
    let exact = emulator.sensitivity(&theta).unwrap();
    for (p, exact) in exact.iter().enumerate() {
        const STEP: f64 = 1e-2;
        let at = |sign: f64| {
            let mut moved = theta.clone();
            moved[p] += sign * STEP;
            emulator.predict(&[moved]).unwrap().displacement
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        let slope = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * STEP));
        // Single precision over the step.
        assert!(apart(&slope.collect::<Vec<_>>(), exact) < 3e-3, "{p}");
    }
    let folder = tempfile::tempdir().unwrap();
    emulator.save(folder.path()).unwrap();
    let loaded = sinew_gnn::load(folder.path(), &body).unwrap().predict(thetas).unwrap();
    assert_eq!(loaded, found);
}

fn apart(found: &[f64], truth: &[f64]) -> f64 {
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let difference = squares(&mut found.iter().zip(truth).map(|(a, b)| a - b));
    (difference / squares(&mut truth.iter().copied())).sqrt()
}

#[test]
fn few_simulations_are_regressed_about_the_expansion() {
    let body = beam(1.0);
    let of = |recipe: Recipe| recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let few = of(Regression { simulations: 4, most: 4, target: 0.0 }.into());
    let detail = few.record.choice.as_ref().unwrap().candidates[0].detail.clone();
    assert!(detail.ends_with("of what second order about one solution leaves"), "{detail}");
    assert!(errors(&few).relative.q50 < errors(&of(Recipe::Taylor)).relative.q50);
    // With so many that the Taylor expansion says nothing more, it is not asked.
    let many = of(Regression { simulations: 16, most: 16, target: 0.0 }.into());
    let detail = &many.record.choice.as_ref().unwrap().candidates[0].detail;
    assert!(!detail.contains("second order"), "{detail}");
}

#[test]
fn a_network_learns_from_simulations() {
    let body = beam(1.0);
    let base = DataDriven::default();
    let training = steps(&base.training, 600);
    let recipe = DataDriven { simulations: 40, network: small_network(), training, ..base };
    let emulator = Recipe::from(recipe).train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    check(&emulator, 0.02, 1.0);
}

#[test]
fn a_network_learns_from_the_energy_alone() {
    let body = beam(1.0);
    let base = PhysicsInformed::default();
    let OutputCoordinates::MotionsAfter(first) = &base.coordinates else {
        panic!("another default")
    };
    let coordinates = OutputCoordinates::MotionsAfter(steps(first, 400));
    let training = steps(&base.training, 600);
    let recipe = PhysicsInformed { network: small_network(), coordinates, training, ..base };
    let emulator = Recipe::from(recipe).train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    assert_eq!(emulator.record.simulations, 0);
    check(&emulator, 0.02, 1.0);
}

#[test]
fn a_regression_says_why_it_took_what_it_took() {
    let body = beam(1.0);
    let recipe = Recipe::from(Regression::default());
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let choice = emulator.record.choice.clone().unwrap();
    assert_eq!((choice.candidates.len(), choice.candidates[0].simulations), (1, 25));
    assert!(choice.to_string().contains("meets the target"), "{choice}");
    assert!(errors(&emulator).relative.max < 1e-3);

    // A target out of reach: the simulations double, and the least error decides.
    let recipe = Recipe::from(Regression { simulations: 5, most: 10, target: 1e-12 });
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let choice = emulator.record.choice.clone().unwrap();
    println!("{choice}");
    let tried: Vec<_> = choice.candidates.iter().map(|c| c.simulations).collect();
    assert_eq!(tried, [5, 10]);
    let least = choice.candidates.iter().map(|c| c.error).fold(f64::INFINITY, f64::min);
    assert_eq!(choice.candidates[choice.taken].error, least);
    assert!(choice.to_string().contains("is the least"), "{choice}");
    assert!(
        emulator.record.warnings.iter().any(|w| matches!(w, Warning::TargetMissed { .. })),
        "{:?}",
        emulator.record.warnings
    );
}

/// Keeps what it hears.
#[derive(Default)]
struct Ear {
    warnings: Vec<Warning>,
}

impl Observer for Ear {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(warning.clone());
    }
}

#[test]
fn a_training_that_learned_nothing_says_so() {
    let body = beam(1.0);
    let base = PhysicsInformed::default();
    let OutputCoordinates::MotionsAfter(first) = &base.coordinates else {
        panic!("another default")
    };
    let coordinates = OutputCoordinates::MotionsAfter(steps(first, 2));
    let training = steps(&base.training, 2);
    let recipe = PhysicsInformed { network: small_network(), coordinates, training, ..base };
    let mut ear = Ear::default();
    let emulator =
        Recipe::from(recipe).train(&body, &TrainingOptions::default(), &mut ear).unwrap();
    let warnings = &emulator.record.warnings;
    let far = warnings.iter().any(|w| {
        matches!(w, Warning::FarFromEquilibrium { excess } if *excess > 0.01)
            || matches!(w, Warning::Inverted { .. })
    });
    assert!(far, "{warnings:?}");
    assert!(warnings.iter().all(|warning| ear.warnings.contains(warning)));
    println!("{}", warnings[0]);
}
