//! The whole study: scenes, simulations, emulators, rivals, report.

use crate::options::BeamOptions;
use crate::outcome::Outcome;
use crate::recipes::{self, Samples};
use crate::report::{self, Method};
use crate::scenes::{Beam, once_clamped, twice_clamped};
use crate::simulate::{self, Simulations};
use crate::timing::WallClock;
use crate::{manifest, present};
use anyhow::{Result, ensure};
use sinew_emulate::{Body, Recipe, Terminal, store};
use sinew_report::{Section, Value};
use std::path::{Path, PathBuf};

/// Newton steps that predictions are corrected by for the evaluation beside the report.
const CORRECTIONS: usize = 2;

/// Runs `reproduce-beam` and writes its report; the path of `report.html`.
///
/// # Errors
/// Whatever keeps the report from being made: options that contradict an interrupted run, a solver or a
/// training that fails, files that cannot be written.
pub fn reproduce_beam(options: &BeamOptions) -> Result<PathBuf> {
    let provenance = manifest::of_this_run(options.seed, rayon::current_num_threads(), options)?;
    let clock = begin(options)?;
    store::write_json(&options.out.join("manifest.json"), &provenance)?;
    options.backend.device()?;
    let mut scenes = Vec::new();
    let mut samples = String::new();
    let mut notes = notes(options);
    for name in options.scene.names() {
        let beam = if *name == "once" { once_clamped() } else { twice_clamped() };
        let run = run_scene(options, &beam, &clock)?;
        scenes.push(run.scene);
        if samples.is_empty() {
            samples = report::head(&beam.scene.parameters);
        }
        samples += &run.samples;
        notes.extend(run.notes.iter().map(|note| format!("{}: {note}", beam.title)));
    }
    let provenance = provenance.finished(clock.save()?.as_secs_f64());
    let report = present::report(provenance, notes, scenes);
    let page = report.write(&options.out)?;
    store::write_bytes(&options.out.join("samples.csv"), samples.as_bytes())?;
    if options.json {
        println!("{}", report.to_json()?);
    }
    Ok(page)
}

/// Prepares the output folder; the clock goes on where that of the run that is resumed was last saved.
fn begin(options: &BeamOptions) -> Result<WallClock> {
    let folders = ["once", "twice"].map(String::from);
    let (clock, stored) =
        WallClock::begin(&options.out, &folders, options.resume, options.clone())?;
    let same = BeamOptions { resume: options.resume, json: options.json, ..stored.clone() };
    ensure!(
        same == *options,
        "the run in {} was started with other options ({}); repeat them, or start without --resume",
        options.out.display(),
        toml::to_string(&stored)?.trim().replace('\n', ", ")
    );
    Ok(clock)
}

fn notes(options: &BeamOptions) -> Vec<String> {
    let mut notes = vec![
        "Errors are over all test cases and over the nodes that no support holds; the thesis counts all \
         nodes, which makes its medians a little smaller."
            .to_string(),
        "The truth is our finite-element solution on the same linear tetrahedra, as in the thesis. The rows \
         fem_cold and fem_warm compare that solution with an independent program on the same mesh, \
         not with the continuum."
            .to_string(),
    ];
    if options.quick {
        notes.push(
            "A quick check of the code path with few simulations and steps: its errors mean nothing."
                .to_string(),
        );
    }
    notes
}

/// What a scene contributes to the report.
struct SceneRun {
    scene: Section,
    /// Lines of `samples.csv`.
    samples: String,
    notes: Vec<String>,
}

fn run_scene(options: &BeamOptions, beam: &Beam, clock: &WallClock) -> Result<SceneRun> {
    eprintln!("\n{}: {}", beam.title, beam.description);
    let folder = options.out.join(beam.name);
    let body = beam.scene.lower()?;
    let simulations = simulate::run(beam, &body, Samples::of(options), options.seed, &folder)?;
    clock.save()?;
    let run = EmulatorRun { options, body: &body, simulations: &simulations, folder: &folder };
    let mut outcomes = Vec::new();
    for &method in options.method.iter().chain(&[Method::Pod]) {
        outcomes.push(run.outcome(method)?);
        clock.save()?;
    }
    outcomes.extend(fem_outcomes(&simulations)?);

    present::write_fields(&folder.join("fields"), beam, &simulations, &outcomes)?;
    let training = Samples::of(options).training;
    let scene = present::section(beam, &body, training, &simulations, &outcomes)?;
    let notes = scene_notes(simulations.fixture.discretisation_mm, &outcomes);
    let lines = outcomes
        .iter()
        .map(|outcome| report::lines(beam.name, outcome.method, &outcome.thetas, &outcome.cases));
    let samples = lines.collect::<Result<Vec<_>>>()?.concat();
    Ok(SceneRun { scene, samples, notes })
}

fn scene_notes(discretisation_mm: f64, outcomes: &[Outcome]) -> Vec<String> {
    let discretisation = format!(
        "at mu = lambda = 75 kPa this mesh of linear tetrahedra is {discretisation_mm:.2} mm (median over the nodes) \
         from a solution with quadratic ones. Emulators inherit that error; no row shows it."
    );
    let concerns = outcomes.iter().flat_map(|outcome| {
        let method = outcome.method.key();
        outcome.concerns.iter().map(move |concern| format!("warning about {method}, {concern}"))
    });
    std::iter::once(discretisation).chain(concerns).collect()
}

/// Trains, times and evaluates the emulators of a scene.
struct EmulatorRun<'a> {
    options: &'a BeamOptions,
    body: &'a Body,
    simulations: &'a Simulations<'a>,
    folder: &'a Path,
}

impl EmulatorRun<'_> {
    fn outcome(&self, method: Method) -> Result<Outcome> {
        let recipe = &recipes::recipe(self.options, method);
        let folder = self.folder.join(method.key());
        let training = recipes::training(self.options, recipe, &folder);
        let emulator = recipe.train(self.body, &training, &mut Terminal::default())?;
        let test = &self.simulations.test;
        let evaluation = emulator.evaluate(test, CORRECTIONS)?;
        store::write_json(&folder.join("evaluation.json"), &evaluation)?;
        let (record, costs) = (&emulator.record, evaluation.times);
        let times = [
            record.prepare_s + record.simulate_s,
            record.train_s,
            costs.predict_full_s,
            costs.predict_decoder_s,
            costs.predict_batch_per_theta_s,
        ];
        let description = description(recipe, record.choice.as_ref());
        let fields = emulator.predict(&test.thetas)?.fields();
        let outcome = Outcome::new(method, &description, test, times, fields)?;
        let concerns = record.warnings.iter().map(ToString::to_string).collect();
        let row = outcome.row.other((record.steps > 0).then_some(record.steps as f64));
        Ok(Outcome { row, history: record.history.clone(), concerns, ..outcome })
    }
}

/// What an emulator is, in one line.
fn description(recipe: &Recipe, choice: Option<&sinew_emulate::recipe::Choice>) -> String {
    match recipe {
        Recipe::DataDriven(recipe) if recipe.gradient_weight > 0.0 => format!(
            "emulator trained on {} simulations with their deformation gradients",
            recipe.simulations
        ),
        Recipe::DataDriven(recipe) => {
            format!("emulator trained on {} simulations", recipe.simulations)
        }
        Recipe::Hybrid(recipe) => format!(
            "emulator trained on {} simulations, errors weighed by the stiffness about one of them",
            recipe.simulations
        ),
        Recipe::PhysicsInformed(_) => {
            "emulator trained by minimum potential energy, without simulations; a few linear \
             solves set its scale and what it follows by itself"
                .to_string()
        }
        Recipe::Series => "one solution, followed to second order in the parameters".to_string(),
        Recipe::Regression(_) | Recipe::Auto(_) => {
            let taken = choice.and_then(|choice| choice.candidates.get(choice.taken));
            taken.map_or_else(String::new, |taken| {
                format!("POD of {} simulations, {}", taken.simulations, taken.detail)
            })
        }
    }
}

/// The solver itself, cold and warm, against the independent solutions.
fn fem_outcomes(simulations: &Simulations<'_>) -> Result<Vec<Outcome>> {
    let fixture = &simulations.fixture;
    let row = |method, description, fields: &[Vec<f64>], [solve_s, batch_s]: [f64; 2]| {
        let times = [0.0, 0.0, solve_s, solve_s, batch_s];
        let found =
            Outcome::new(method, description, &fixture.independent, times, fields.to_vec())?;
        Ok::<_, anyhow::Error>(Outcome { row: found.row.other(Value::Nothing), ..found })
    };
    let batch_s = simulations.test_s / simulations.test.thetas.len() as f64;
    Ok(vec![
        row(
            Method::FemCold,
            "our Newton solver from rest, one thread",
            &fixture.cold,
            [simulations.cold_s; 2],
        )?,
        row(
            Method::FemWarm,
            "our Newton solver in a sweep, each solve starting from a neighbour's solution",
            &fixture.warm,
            [simulations.test.median_solve_s, batch_s],
        )?,
    ])
}
