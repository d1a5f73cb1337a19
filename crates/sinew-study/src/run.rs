//! The whole study: scenes, simulations, emulators, rivals, report.

use crate::options::{BackendChoice, BeamOptions, Method};
use crate::outcome::Outcome;
use crate::recipes::{self, Samples};
use crate::report::{self, SceneSamples, Times};
use crate::scenes::{Beam, once_clamped, twice_clamped};
use crate::simulate::{self, Simulations};
use crate::timing::WallClock;
use crate::{manifest, present};
use anyhow::{Context, Result, ensure};
use sinew_emulate::{Body, Recipe, Terminal, store};
use sinew_gnn::Backend;
use sinew_report::Section;
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
    Backend::from(options.backend).device()?;
    let mut scenes = Vec::new();
    let mut samples = Vec::new();
    let mut notes = notes(options);
    for name in options.scene.names() {
        let beam = if *name == "once" { once_clamped() } else { twice_clamped() };
        let run = run_scene(options, &beam, &clock)?;
        scenes.push(run.scene);
        samples.push(run.samples);
        notes.extend(run.notes.iter().map(|note| format!("{}: {note}", beam.title)));
    }
    let provenance = provenance.finished(clock.save()?.as_secs_f64());
    let report = present::report(provenance, notes, scenes);
    let page = report.write(&options.out)?;
    let mut table: Vec<u8> = Vec::new();
    report::write_samples(&samples, &mut table)?;
    store::write_bytes(&options.out.join("samples.csv"), &table)?;
    if options.json {
        println!("{}", report.to_json()?);
    }
    Ok(page)
}

/// Prepares the output folder; the clock goes on where that of the run that is resumed was last saved.
fn begin(options: &BeamOptions) -> Result<WallClock> {
    let config = options.out.join("config.json");
    if !options.resume {
        for name in ["once", "twice"] {
            let old = options.out.join(name);
            if old.exists() {
                ensure!(
                    config.exists(),
                    "{} exists but is not of an earlier run; choose another --out",
                    old.display()
                );
                std::fs::remove_dir_all(&old)
                    .with_context(|| format!("{} could not be emptied", old.display()))?;
            }
        }
        store::write_json(&config, options)?;
        return Ok(WallClock::start(&options.out));
    }
    let stored: BeamOptions = store::read_json(&config)?.with_context(|| {
        format!("there is no run to resume in {}; start it without --resume", options.out.display())
    })?;
    let same = BeamOptions { resume: true, json: options.json, ..stored.clone() } == *options;
    ensure!(
        same,
        "the run in {} was started with other options ({}); repeat them, or start without --resume",
        options.out.display(),
        toml::to_string(&stored)?.trim().replace('\n', ", ")
    );
    WallClock::resume(&options.out)
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
    samples: SceneSamples,
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
    for &method in &options.method {
        let recipe = recipes::recipe(options, method);
        outcomes.push(run.outcome(method.into(), method.key(), &recipe)?);
        clock.save()?;
    }
    outcomes.push(run.outcome(report::Method::Pod, "pod", &recipes::regression(options))?);
    outcomes.extend(fem_outcomes(&simulations)?);

    present::write_fields(&folder.join("fields"), beam, &simulations, &outcomes)?;
    let training = Samples::of(options).training;
    let scene = present::section(beam, &body, training, &simulations, &outcomes)?;
    let notes = scene_notes(simulations.fixture.discretisation_mm, &outcomes);
    let theta_names = body.parameters.iter().map(|p| format!("{}_{}", p.name, p.unit)).collect();
    let rows = outcomes.into_iter().flat_map(|outcome| outcome.samples).collect();
    let samples = SceneSamples { scene: beam.name.to_string(), theta_names, rows };
    Ok(SceneRun { scene, samples, notes })
}

fn scene_notes(discretisation_mm: f64, outcomes: &[Outcome]) -> Vec<String> {
    let discretisation = format!(
        "at mu = lambda = 75 kPa this mesh of linear tetrahedra is {discretisation_mm:.2} mm (median over the nodes) \
         from a solution with quadratic ones. Emulators inherit that error; no row shows it."
    );
    let concerns = outcomes.iter().flat_map(|outcome| {
        let method = outcome.row.method().key();
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
    fn outcome(&self, method: report::Method, key: &str, recipe: &Recipe) -> Result<Outcome> {
        let folder = self.folder.join(key);
        let training = recipes::training(self.options, recipe, &folder);
        let emulator = recipe.train(self.body, &training, &mut Terminal::default())?;
        let test = &self.simulations.test;
        let evaluation = emulator.evaluate(test, CORRECTIONS)?;
        store::write_json(&folder.join("evaluation.json"), &evaluation)?;
        let (record, costs) = (&emulator.record, evaluation.times);
        let times = Times {
            prepare_s: record.prepare_s + record.simulate_s,
            train_s: record.train_s,
            steps: record.steps,
            predict_full_s: costs.predict_full_s,
            predict_decoder_s: costs.predict_decoder_s,
            predict_batch_per_theta_s: costs.predict_batch_per_theta_s,
        };
        let description = description(recipe, record.choice.as_ref());
        let fields = emulator.predict(&test.thetas)?.fields();
        let outcome = Outcome::new(method, &description, test, times, fields)?;
        let concerns = record.warnings.iter().map(ToString::to_string).collect();
        Ok(Outcome { history: record.history.clone(), concerns, ..outcome })
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
            "emulator trained by minimum potential energy, without simulations; one linear \
             solve sets its scale"
                .to_string()
        }
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
    let row = |method, description, fields: &[Vec<f64>], solve_s: f64, batch_s: f64| {
        let times = Times {
            prepare_s: 0.0,
            train_s: 0.0,
            steps: 0,
            predict_full_s: solve_s,
            predict_decoder_s: solve_s,
            predict_batch_per_theta_s: batch_s,
        };
        Outcome::new(method, description, &fixture.independent, times, fields.to_vec())
    };
    Ok(vec![
        row(
            report::Method::FemCold,
            "our Newton solver from rest, one thread",
            &fixture.cold,
            simulations.cold_s,
            simulations.cold_s,
        )?,
        row(
            report::Method::FemWarm,
            "our Newton solver in a sweep, each solve starting from a neighbour's solution",
            &fixture.warm,
            simulations.test.median_solve_s,
            simulations.test_s / simulations.test.thetas.len() as f64,
        )?,
    ])
}

impl From<BackendChoice> for Backend {
    fn from(choice: BackendChoice) -> Self {
        match choice {
            BackendChoice::Flex => Self::Flex,
            BackendChoice::Ndarray => Self::NdArray,
        }
    }
}

impl From<Method> for report::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Dd => report::Method::Dd,
            Method::Pi => report::Method::Pi,
            Method::Hybrid => report::Method::Hybrid,
            Method::Fdd => report::Method::Fdd,
        }
    }
}
