//! The best network and the best fit are kept, by one measure; runs share their simulations, and none is replaced unasked.

use crate::support::{beam, small_network, steps};
use sinew_emulate::{Emulator, Error, Observer, Progress, TrainingOptions, simulate};
use sinew_gnn::recipe::{DataDriven, PhysicsInformed, Regression};
use sinew_gnn::{OutputCoordinates, Recipe};
use std::ops::ControlFlow;
use std::path::Path;

/// A training that warms up to steps which are too large for it to stay where it is best.
fn reckless() -> Recipe {
    let base = DataDriven::default();
    let mut training = steps(&base.training, 100);
    (training.learning_rate, training.evaluations) = (0.5, 50);
    DataDriven { simulations: 20, network: small_network(), training, ..base }.into()
}

#[test]
fn the_network_that_is_stored_is_the_best_of_its_curve() {
    let body = beam(1.0);
    let folder = tempfile::tempdir().unwrap();
    for seed in [1, 2, 3] {
        let run = folder.path().join(seed.to_string());
        let folder = Some(run.clone());
        let options = TrainingOptions { seed, folder, evaluations: 50, ..Default::default() };
        reckless().train(&body, &options, &mut ()).unwrap();
        let emulator = sinew_gnn::load(&run.join("emulator"), &body).unwrap();
        let (record, history) = (&emulator.record, &emulator.record.history);
        let errors = || history.iter().map(|point| (point.error.unwrap(), point.step));
        let best = errors().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let worst = errors().map(|(error, _)| error).fold(0.0, f64::max);
        let kept = record.kept.unwrap();
        println!("seed {seed}: {kept:?}, at worst {worst:.1e}");
        assert!(worst > 3.0 * best.0 && kept.returns > 0, "steps that lose nothing test nothing");
        assert_eq!((kept.error, kept.step), (Some(best.0), best.1));
        // What is stored is what was measured there.
        let found = record.held_out.as_ref().unwrap().err_u.q50;
        let of_kept = history.iter().find(|point| point.step == kept.step).unwrap();
        assert_eq!(found, of_kept.medians.unwrap()[0]);
    }
}

/// A second stage whose steps destroy what it begins with leaves the network of the first.
#[test]
fn the_network_of_an_earlier_stage_is_kept_where_it_is_the_best() {
    let body = beam(1.0);
    let base = PhysicsInformed::default();
    let OutputCoordinates::MotionsAfter(first) = &base.coordinates else {
        panic!("another default")
    };
    let coordinates = OutputCoordinates::MotionsAfter(steps(first, 100));
    let mut training = steps(&base.training, 40);
    training.learning_rate = 1e3;
    let recipe = PhysicsInformed { network: small_network(), coordinates, training, ..base };
    let folder = tempfile::tempdir().unwrap();
    let train = |name: &str, resume, calls| {
        let folder = Some(folder.path().join(name));
        let options = TrainingOptions { folder, resume, ..TrainingOptions::default() };
        let mut observer = Counting { calls, ..patient() };
        let emulator = Recipe::from(recipe.clone()).train(&body, &options, &mut observer)?;
        let predicted = emulator.predict(&[vec![9.0, 14.0]])?.displacement;
        Ok::<_, Error>((emulator.record.clone(), predicted))
    };
    let (record, predicted) = train("whole", false, usize::MAX).unwrap();
    let kept = record.kept.unwrap();
    println!("{kept:?} of {} steps", record.steps);
    assert!(kept.step <= 100 && record.steps == 140, "{kept:?}");
    let errors = record.history.iter().filter_map(|point| point.error);
    assert_eq!(kept.error, Some(errors.fold(f64::INFINITY, f64::min)));
    // Killed in the second stage it keeps the same.
    assert!(train("pieces", false, 150).is_err());
    assert_eq!(train("pieces", true, usize::MAX).unwrap().1, predicted);
    // And it comes back from its files.
    let stored = sinew_gnn::load(&folder.path().join("whole/emulator"), &body).unwrap();
    assert_eq!(stored.predict(&[vec![9.0, 14.0]]).unwrap().displacement, predicted);
}

/// Root mean square of the relative error on the held-out cases of a run, solved again.
fn held_out_error(emulator: &Emulator<'_>, options: &TrainingOptions) -> f64 {
    let (body, seed) = (emulator.body(), sinew_emulate::split_seed(options.seed, 1));
    let held_out = sinew_emulate::Design::Uniform;
    let thetas = held_out.sample(&body.parameters, options.held_out, seed).unwrap();
    let truth = simulate(body, &thetas, "again", None, &mut ()).unwrap();
    let found = emulator.predict(&thetas).unwrap();
    let norm = |u: &mut dyn Iterator<Item = f64>| u.map(|u| u * u).sum::<f64>();
    let square = |(case, truth): (usize, &Vec<f64>)| {
        let difference = &mut found.field(case).iter().zip(truth).map(|(a, b)| a - b);
        norm(difference) / norm(&mut truth.iter().copied())
    };
    let squares: f64 = truth.fields.iter().enumerate().map(square).sum();
    (squares / thetas.len() as f64).sqrt()
}

#[test]
fn a_regression_measures_all_candidates_by_the_held_out_cases() {
    let body = beam(1.0);
    for simulations in [3, 12] {
        let recipe = Recipe::from(Regression { simulations, most: 12, target: 1e-12 });
        let options = TrainingOptions { held_out: 8, ..TrainingOptions::default() };
        let emulator = recipe.train(&body, &options, &mut ()).unwrap();
        let choice = emulator.record.choice.as_ref().unwrap();
        println!("{choice}");
        let own = &choice.candidates[choice.taken];
        let found = held_out_error(&emulator, &options);
        // Solves agree to the solver's tolerance.
        assert!((own.error / found - 1.0).abs() < 1e-6, "{} for {found}", own.error);
        let least = choice.candidates.iter().map(|c| c.error).fold(f64::INFINITY, f64::min);
        assert_eq!(own.error, least, "{choice}");
        assert_eq!(emulator.record.simulations, own.simulations);
    }
}

/// Counts solves, and stops after some calls.
struct Counting {
    solves: usize,
    calls: usize,
}

impl Observer for Counting {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        self.solves += usize::from(progress.stage.starts_with("simulate"));
        self.calls = self.calls.saturating_sub(1);
        if self.calls == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

fn patient() -> Counting {
    Counting { solves: 0, calls: usize::MAX }
}

fn few() -> Recipe {
    Regression { simulations: 6, most: 6, target: 0.0 }.into()
}

fn in_case(case: &Path, name: &str) -> TrainingOptions {
    TrainingOptions {
        folder: Some(case.join(name)),
        shared: Some(case.join("simulations")),
        held_out: 5,
        ..TrainingOptions::default()
    }
}

#[test]
fn recipes_of_one_case_share_their_simulations() {
    let (body, folder) = (beam(1.0), tempfile::tempdir().unwrap());
    let solves = |recipe: &Recipe, name: &str| {
        let mut observer = patient();
        let emulator = recipe.train(&body, &in_case(folder.path(), name), &mut observer).unwrap();
        let predicted = emulator.predict(&[vec![9.0, 14.0]]).unwrap().displacement;
        (observer.solves, predicted, emulator.record.simulate_s)
    };
    let (first, predicted, seconds) = solves(&few(), "first");
    let (again, same, of_log) = solves(&few(), "again");
    assert!(first > 0 && seconds > 0.0);
    // What they took is told all the same.
    assert_eq!((again, &same, of_log), (0, &predicted, seconds));
    assert_eq!(solves(&Recipe::Taylor, "taylor").0, 0, "the held-out cases are there");
    // Other samples and other bodies are solved.
    let seeded = TrainingOptions { seed: 2, ..in_case(folder.path(), "seeded") };
    let mut observer = patient();
    few().train(&body, &seeded, &mut observer).unwrap();
    let heavier = beam(1.1);
    let mut other = patient();
    few().train(&heavier, &in_case(folder.path(), "heavier"), &mut other).unwrap();
    assert_eq!((observer.solves, other.solves), (first, first));
    // Replacing a run leaves what it shared.
    let restarted = TrainingOptions { restart: true, ..in_case(folder.path(), "first") };
    let mut observer = patient();
    few().train(&body, &restarted, &mut observer).unwrap();
    assert_eq!(observer.solves, 0);
    // Damage is not learned from.
    for entry in std::fs::read_dir(folder.path().join("simulations")).unwrap() {
        let fields = entry.unwrap().path().join("displacement.npy");
        let mut bytes = std::fs::read(&fields).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
        std::fs::write(&fields, bytes).unwrap();
    }
    let refused = few().train(&body, &in_case(folder.path(), "damaged"), &mut ());
    let refused = refused.err().unwrap().to_string();
    assert!(refused.contains("displacement.npy was changed after it was stored"), "{refused}");
}

#[test]
fn two_runs_at_once_share_without_harm() {
    let (body, folder) = (beam(1.0), tempfile::tempdir().unwrap());
    let run = |name: &str| {
        let emulator = few().train(&body, &in_case(folder.path(), name), &mut ()).unwrap();
        emulator.predict(&[vec![9.0, 14.0]]).unwrap().displacement
    };
    let found: Vec<_> = std::thread::scope(|scope| {
        let runs: Vec<_> = ["a", "b", "c"].map(|name| scope.spawn(move || run(name))).into();
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    assert!(found.iter().all(|predicted| *predicted == found[0]));
}

#[test]
fn a_run_is_replaced_only_when_asked_to() {
    let (body, folder) = (beam(1.0), tempfile::tempdir().unwrap());
    let train = |name: &str, resume, restart, calls| {
        let options = TrainingOptions { resume, restart, ..in_case(folder.path(), name) };
        let mut observer = Counting { calls, ..patient() };
        let made = reckless().train(&body, &options, &mut observer);
        made.map(|emulator| emulator.record.kept).map_err(|error| error.to_string())
    };
    // Interrupted while it trains.
    assert!(train("run", false, false, 60).unwrap_err().contains("interrupted"));
    let refused = train("run", false, false, usize::MAX).unwrap_err();
    let names = ["not finished", "--resume goes on with it", "--restart replaces it"];
    assert!(names.iter().all(|name| refused.contains(name)), "{refused}");
    assert!(folder.path().join("run/train").exists(), "the checkpoint stays");
    let kept = train("run", true, false, usize::MAX).unwrap();
    let refused = train("run", false, false, usize::MAX).unwrap_err();
    assert!(refused.contains("is finished: --resume reads its emulator"), "{refused}");
    assert_eq!(train("run", true, false, usize::MAX).unwrap(), kept);
    assert_eq!(train("run", false, true, usize::MAX).unwrap(), kept);
    // A run that left nothing may be begun again.
    let none: Recipe = DataDriven { simulations: 1, ..DataDriven::default() }.into();
    let options = in_case(folder.path(), "none");
    for _ in 0..2 {
        let failed = none.train(&body, &options, &mut ()).err().unwrap();
        assert!(failed.to_string().contains("simulations succeeded"), "{failed}");
    }
}
