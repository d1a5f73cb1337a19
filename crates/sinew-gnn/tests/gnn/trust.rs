//! Error estimates of emulators, corrections, and misuse.

use crate::support::{beam, beam_held_at, small_network, steps};
use sinew_emulate::{
    Budget, Design, Emulator, Error, Observer, Progress, TestSet, TrainingOptions, Warning,
    simulate,
};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::Solver;
use sinew_gnn::recipe::{DataDriven, Regression};
use sinew_gnn::{OutputCoordinates, Recipe};
use std::ops::ControlFlow;
use std::path::Path;

fn quick_network(count: usize) -> Recipe {
    let base = DataDriven::default();
    let training = steps(&base.training, count);
    DataDriven { simulations: 30, network: small_network(), training, ..base }.into()
}

fn test_set<'b>(body: &'b sinew_emulate::Body, count: usize) -> TestSet<'b> {
    let thetas = Design::Uniform.sample(&body.parameters, count, 77).unwrap();
    TestSet::new(body, simulate(body, &thetas, "test", None, &mut ()).unwrap())
}

#[test]
fn estimates_are_within_a_factor_of_two_and_corrections_converge() {
    let body = beam(1.0);
    let emulator = quick_network(300).train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let test = test_set(&body, 40);
    let prediction = emulator.predict(&test.thetas).unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let mut within = 0;
    for (case, (theta, truth)) in test.thetas.iter().zip(&test.fields).enumerate() {
        let estimate = emulator.estimate(&prediction, case).unwrap();
        let distance = estimate.distance.expect("an equilibrium is near");
        let difference =
            |u: &[f64]| -> Vec<f64> { u.iter().zip(truth).map(|(a, b)| a - b).collect() };
        let error = solver.energy_norm(truth, theta, &difference(prediction.field(case))).unwrap();
        let ratio = error / distance.energy_norm;
        within += usize::from((0.5..2.0).contains(&ratio));
        assert!(distance.mean <= distance.largest && estimate.seconds > 0.0);
        assert!(estimate.residual.unwrap() > 0.0 && estimate.warnings.is_empty());

        let corrected = emulator.correct(theta, 2).unwrap();
        assert_eq!(corrected.steps.len(), 2);
        let after = solver.energy_norm(truth, theta, &difference(&corrected.displacement)).unwrap();
        assert!(after < 1e-2 * error, "{error:e} before, {after:e} after");
    }
    println!("{within} of 40 estimates within a factor of two; {:?}", emulator.record.calibration);
    assert!(within >= 38, "{within} of 40");
}

/// Mean relative distance to the truth.
fn relative(test: &TestSet<'_>, found: &[Vec<f64>]) -> f64 {
    let norm = |u: &mut dyn Iterator<Item = f64>| u.map(|u| u * u).sum::<f64>().sqrt();
    let of = |(truth, u): (&Vec<f64>, &Vec<f64>)| {
        norm(&mut truth.iter().zip(u).map(|(a, b)| a - b)) / norm(&mut truth.iter().copied())
    };
    test.fields.iter().zip(found).map(of).sum::<f64>() / found.len() as f64
}

/// Whatever predicts, steps with a frozen stiffness bring it nearer and nearer, the same on any number of threads.
#[test]
fn predictions_are_refined_with_one_stiffness() {
    let body = beam(1.0);
    let test = test_set(&body, 20);
    let options = TrainingOptions::default();
    let network = quick_network(50).train(&body, &options, &mut ()).unwrap();
    for emulator in [network, Emulator::taylor(&body, 1).unwrap()] {
        let after = |steps: usize| {
            let refined = emulator.refine(&test.thetas, steps).unwrap();
            relative(&test, &refined.fields())
        };
        let errors = [0, 4, 6, 8].map(after);
        println!("{errors:?}");
        let raw = relative(&test, &emulator.predict(&test.thetas).unwrap().fields());
        assert!((errors[0] / raw - 1.0).abs() < 1e-12);
        assert!(errors.windows(2).all(|pair| pair[1] < 0.3 * pair[0]), "{errors:?}");
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let on_one = alone.install(|| emulator.refine(&test.thetas, 3).unwrap());
        assert_eq!(on_one, emulator.refine(&test.thetas, 3).unwrap());
        assert!(emulator.refine(&[vec![f64::NAN, 1.0]], 3).is_err());
    }
}

#[test]
fn a_correction_from_far_away_says_so() {
    let body = beam(1.0);
    let Recipe::DataDriven(base) = quick_network(1) else { unreachable!("it is data-driven") };
    let recipe = Recipe::from(DataDriven { coordinates: OutputCoordinates::Components, ..base });
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    // An untrained emulator without a Taylor polynomial is too far away for a step, at least at the ends of the ranges.
    let corrected = emulator.correct(&[8.0, 8.0], 1).unwrap();
    let far =
        |w: &Warning| matches!(w, Warning::FarForCorrection { relative, .. } if *relative > 0.04);
    assert!(corrected.warnings.iter().any(far), "{:?}", corrected.warnings);
    println!("{}", corrected.warnings[0]);
    // Whatever a step does, it raises no energy and inverts no cell.
    for step in &corrected.steps {
        assert!(step.energy_after <= step.energy_before && step.energy_after.is_finite());
    }
}

#[test]
fn parameters_outside_their_ranges_are_marked() {
    let body = beam(1.0);
    let recipe = Recipe::from(Regression { simulations: 9, ..Regression::default() });
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let prediction = emulator.predict(&[vec![8.0, 16.0], vec![20.0, 12.0]]).unwrap();
    assert_eq!(prediction.warnings[0], []);
    let message = prediction.warnings[1][0].to_string();
    assert!(message.contains("mu = 20") && message.contains("16"), "{message}");
    assert_eq!(emulator.estimate(&prediction, 1).unwrap().warnings, prediction.warnings[1]);
    assert_eq!(emulator.correct(&[20.0, 12.0], 1).unwrap().warnings[0], prediction.warnings[1][0]);

    let error = emulator.predict(&[vec![8.0]]).unwrap_err().to_string();
    assert!(error.contains("mu, lambda"), "{error}");
    assert!(emulator.predict(&[vec![-1.0, 9.0]]).is_err());
    let none = emulator.estimate(&prediction, 2).unwrap_err().to_string();
    assert_eq!(none, "there is no case 2 in a prediction of 2");
}

fn saved_and_loaded(recipe: &Recipe) {
    let body = beam(1.0);
    let folder = tempfile::tempdir().unwrap();
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    emulator.save(folder.path()).unwrap();
    let loaded = sinew_gnn::load(folder.path(), &body).unwrap();
    assert_eq!(loaded.record, emulator.record);
    let thetas = [vec![9.0, 14.0], vec![30.0, 12.0]];
    assert_eq!(loaded.predict(&thetas).unwrap(), emulator.predict(&thetas).unwrap());

    let heavier = beam(1.1);
    let error = sinew_gnn::load(folder.path(), &heavier).err().unwrap().to_string();
    assert!(error.contains("another body") && error.contains("work"), "{error}");
    let nothing = sinew_gnn::load(&folder.path().join("nothing"), &body).err().unwrap();
    assert!(matches!(nothing, Error::NoEmulator { .. }), "{nothing}");
}

#[test]
fn an_emulator_survives_storage_and_knows_its_body() {
    saved_and_loaded(&Regression { simulations: 9, ..Regression::default() }.into());
    saved_and_loaded(&quick_network(10));
}

/// Breaks after some calls, as a person with a key does.
struct Impatient {
    calls: usize,
}

impl Observer for Impatient {
    fn progress(&mut self, _: &Progress<'_>) -> ControlFlow<()> {
        self.calls = self.calls.saturating_sub(1);
        if self.calls == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn a_resumed_run_equals_an_uninterrupted_one_bit_for_bit() {
    let body = beam(1.0);
    let base = DataDriven::default();
    let training = steps(&base.training, 60);
    let recipe: Recipe =
        DataDriven { simulations: 24, network: small_network(), training, ..base }.into();
    let folder = tempfile::tempdir().unwrap();
    let options = |name: &str, resume| TrainingOptions {
        folder: Some(folder.path().join(name)),
        resume,
        held_out: 6,
        ..TrainingOptions::default()
    };
    let whole = recipe.train(&body, &options("whole", false), &mut ()).unwrap();
    // Held-out cases, simulations and a part of the training; then twice more.
    for (calls, resume) in [(3, false), (20, true), (40, true), (25, true)] {
        let result = recipe.train(&body, &options("pieces", resume), &mut Impatient { calls });
        let error = result.err().expect("it is interrupted");
        assert!(matches!(error, Error::Interrupted { .. }), "{error}");
    }
    let pieces = recipe.train(&body, &options("pieces", true), &mut ()).unwrap();
    let thetas = [vec![9.0, 14.0], vec![13.0, 12.0]];
    assert_eq!(pieces.predict(&thetas).unwrap(), whole.predict(&thetas).unwrap());
    let losses = |emulator: &Emulator<'_>| -> Vec<(u64, Option<[f64; 4]>)> {
        emulator.record.history.iter().map(|point| (point.step, point.medians)).collect()
    };
    let known = losses(&whole);
    // An interruption adds a point to the curve; the others are the same.
    assert!(known.iter().all(|point| losses(&pieces).contains(point)));
    assert!(sinew_gnn::load(&folder.path().join("pieces/emulator"), &body).is_ok());
}

#[test]
fn a_folder_is_neither_mixed_up_nor_overwritten() {
    let body = beam(1.0);
    let recipe = Recipe::from(Regression { simulations: 6, ..Regression::default() });
    let folder = tempfile::tempdir().unwrap();
    let options = |path: &Path, resume| TrainingOptions {
        folder: Some(path.into()),
        resume,
        held_out: 2,
        ..TrainingOptions::default()
    };
    let run = folder.path().join("run");
    recipe.train(&body, &options(&run, false), &mut ()).unwrap();
    let error = |result: sinew_emulate::Result<Emulator<'_>>| result.err().unwrap().to_string();
    let other = Recipe::from(Regression { simulations: 7, ..Regression::default() });
    assert!(error(other.train(&body, &options(&run, true), &mut ())).contains("the recipe"));
    let seeded = TrainingOptions { seed: 2, ..options(&run, true) };
    assert!(error(recipe.train(&body, &seeded, &mut ())).contains("the options"));
    let heavier = beam(1.1);
    assert!(error(recipe.train(&heavier, &options(&run, true), &mut ())).contains("work"));
    let foreign = folder.path().join("foreign");
    std::fs::create_dir(&foreign).unwrap();
    std::fs::write(foreign.join("diary.txt"), "dear diary").unwrap();
    let message = error(recipe.train(&body, &options(&foreign, false), &mut ()));
    assert!(message.contains("not of an earlier training"), "{message}");
    assert!(foreign.join("diary.txt").exists());
}

#[test]
fn failures_are_listed_with_their_parameters() {
    let body = beam(1.0);
    let folder = tempfile::tempdir().unwrap();
    let thetas = vec![vec![9.0, 9.0], vec![-5.0, 9.0], vec![10.0, 9.0]];
    let solve = || simulate(&body, &thetas, "test", Some(folder.path()), &mut ()).unwrap();
    let found = solve();
    assert_eq!((found.fields.len(), found.failures.len()), (2, 1));
    assert_eq!(found.failures[0].theta, thetas[1]);
    assert!(found.failures[0].reason.contains("-5"), "{}", found.failures[0].reason);
    assert_eq!(solve(), found);
    let others = vec![vec![9.0, 9.5]; 3];
    let error = simulate(&body, &others, "test", Some(folder.path()), &mut ()).unwrap_err();
    assert!(matches!(error, Error::OtherSamples { .. }), "{error}");
    // The same parameters of another body are other samples: a heavier one, and one that is held at its other end.
    for other in [beam(1.1), beam_held_at("x_max", 1.0)] {
        let error = simulate(&other, &thetas, "test", Some(folder.path()), &mut ()).unwrap_err();
        assert!(matches!(error, Error::OtherSamples { .. }), "{error}");
    }
}

#[test]
fn errors_relative_to_nothing_are_numbers() {
    let body = beam(0.0);
    let rest = vec![0.0; 3 * body.nodes];
    let test = TestSet {
        body: &body,
        thetas: vec![vec![10.0, 12.0]],
        fields: vec![rest.clone()],
        median_solve_s: 1.0,
    };
    let exact = test.errors(std::slice::from_ref(&rest)).unwrap();
    assert_eq!((exact.relative.max, exact.err_pi.max), (0.0, 0.0));
    let moved = test.cases(&[vec![1e-3; rest.len()]]).unwrap();
    let [case] = &moved[..] else { panic!("one case") };
    assert!(case.relative.is_finite() && case.err_pi.is_finite() && case.energy_excess.is_finite());
    assert!(case.relative > 1e9);
    // Nor is an estimate at rest.
    let emulator = Emulator::taylor(&body, 1).unwrap();
    let estimate = emulator.estimate(&emulator.predict(&test.thetas).unwrap(), 0).unwrap();
    let distance = estimate.distance.unwrap();
    assert_eq!((distance.energy_norm, distance.relative, distance.mean), (0.0, 0.0, 0.0));
}

#[test]
fn budgets_and_counts_that_admit_nothing_are_refused() {
    let body = beam(1.0);
    let train = |recipe: &Recipe, options: TrainingOptions| {
        recipe.train(&body, &options, &mut ()).err().map(|error| error.to_string())
    };
    let recipe = quick_network(5);
    let budget = TrainingOptions { budget: Budget::Seconds(-1.0), ..TrainingOptions::default() };
    assert!(train(&recipe, budget).unwrap().contains("-1"));
    let none = DataDriven { simulations: 1, ..DataDriven::default() }.into();
    assert!(train(&none, TrainingOptions::default()).unwrap().contains("2 are needed"));
}

mod store {
    use sinew_emulate::store::*;
    use std::fs;

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/numbers.json");
        assert_eq!(read_json::<Vec<f64>>(&path).unwrap(), None);
        write_json(&path, &vec![0.1, f64::MIN_POSITIVE]).unwrap();
        assert_eq!(read_json(&path).unwrap(), Some(vec![0.1, f64::MIN_POSITIVE]));
        let rows = vec![vec![1.0, 2.0 / 3.0, -0.0], vec![3e300, 4.0, 5.0]];
        let path = folder.path().join("table.npy");
        write_table(&path, &rows).unwrap();
        assert_eq!(read_table(&path).unwrap(), rows);
        write_table(&path, &[]).unwrap();
        assert_eq!(read_table(&path).unwrap(), Vec::<Vec<f64>>::new());
    }

    #[test]
    fn a_damaged_file_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("numbers.json");
        fs::write(&path, "[1, 2").unwrap();
        let message = read_json::<Vec<f64>>(&path).unwrap_err().to_string();
        assert!(message.contains("numbers.json") && message.contains("delete"), "{message}");
    }
}

mod quantiles {
    use sinew_emulate::Quantiles;

    #[test]
    fn quantiles_of_a_ladder() {
        let q = Quantiles::of((0..=20).rev().map(f64::from));
        assert_eq!([q.q05, q.q25, q.q50, q.q75, q.q95, q.max], [1.0, 5.0, 10.0, 15.0, 19.0, 20.0]);
        assert_eq!(q.mean, 10.0);
        assert_eq!(Quantiles::of([1.0, 2.0]).q25, 1.25);
        assert!(Quantiles::of([]).q50.is_nan());
        assert_eq!(Quantiles::of([1.0, f64::NAN, 2.0]).max, f64::MAX);
        assert_eq!(Quantiles::of([f64::MAX, f64::MAX]).mean, f64::MAX); // the sum overflows
    }
}

#[test]
fn derivatives_are_those_of_the_solver_and_of_differences() {
    let body = beam(1.0);
    let theta = vec![10.0, 13.0];
    let recipe = Regression { simulations: 16, most: 16, ..Regression::default() };
    let options = TrainingOptions::default();
    let regression = Recipe::from(recipe).train(&body, &options, &mut ()).unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let solution = solver.solve(&theta, &Default::default()).unwrap();
    let truth = solver.sensitivity(&solution).unwrap();
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart = |a: &[f64], b: &[f64]| {
        let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        norm(&difference) / norm(b)
    };
    for (own, truth) in regression.sensitivity(&theta).unwrap().iter().zip(&truth) {
        assert!(apart(own, truth) < 1e-2, "{}", apart(own, truth));
    }
    // A network's own derivative, whatever it has learned; single precision leaves three digits to a difference.
    let network = quick_network(20).train(&body, &options, &mut ()).unwrap();
    for (p, own) in network.sensitivity(&theta).unwrap().iter().enumerate() {
        let at = |sign: f64| {
            let mut moved = theta.clone();
            moved[p] += sign * 0.02 * theta[p];
            network.predict(&[moved]).unwrap().displacement
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        let slope: Vec<f64> =
            ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (0.04 * theta[p])).collect();
        assert!(apart(own, &slope) < 2e-2, "{}", apart(own, &slope));
    }
    assert!(matches!(network.sensitivity(&[10.0]), Err(Error::ThetaLength { .. })));
}

/// A membrane under a pressure that no equilibrium bears: refined fields move on, and neither they nor their estimates pretend to be answers.
#[test]
fn where_there_is_no_equilibrium_refined_fields_and_estimates_say_so() {
    let parameter = |name: &str, range| Parameter::log(name, "kPa", range);
    let load = Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Theta(2) };
    let walls = sinew_mesh::box_tetrahedra([4.0, 4.0, 0.2], [8, 8, 1]);
    let mut scene = Scene::new(walls, NeoHookean)
        .parameter(parameter("mu", 1.0..=2.0))
        .parameter(parameter("lambda", 5.0..=10.0))
        .parameter(parameter("p", 0.02..=0.1))
        .load(load);
    for side in ["x_min", "x_max", "y_min", "y_max"] {
        scene = scene.support(Support::clamped(side));
    }
    let body = scene.lower().unwrap();
    let emulator = Emulator::taylor(&body, 1).unwrap();
    let (within, beyond) = (vec![1.4, 7.0, 0.05], vec![1.0, 5.0, 2.0]);
    let refined = emulator.refine(&[within, beyond], 200).unwrap();
    assert_eq!(refined.warnings[0], []);
    let unbalanced =
        |w: &Warning| matches!(w, Warning::Unbalanced { residual } if *residual > 0.01);
    assert!(refined.warnings[1].iter().any(unbalanced), "{:?}", refined.warnings[1]);
    let estimates = emulator.estimates(&refined).unwrap();
    assert!(estimates[0].distance.is_some_and(|distance| distance.mean < 1e-6));
    assert_eq!(estimates[1].distance, None);
    let words = estimates[1].in_words("mm");
    assert!(words.starts_with("no error estimate: ") && !words.contains("mm"), "{words}");
    let far = |w: &Warning| matches!(w, Warning::NotNearEquilibrium { .. });
    assert!(estimates[1].warnings.iter().any(far));
}
