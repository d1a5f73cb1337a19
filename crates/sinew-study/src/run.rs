//! The whole study: scenes, simulations, emulators, rivals, report.

use crate::evaluate::{Evaluation, TestSet};
use crate::manifest::Manifest;
use crate::options::{BackendChoice, BeamOptions, Method};
use crate::plan::{Plan, Samples};
use crate::pod::{PodConfig, PodRegression};
use crate::report::{
    self, MethodRow, Report, SampleRow, SceneReport, SceneSamples, Times, TrainingHistory,
};
use crate::scenes::{Beam, once_clamped, twice_clamped};
use crate::simulate::{self, Simulations};
use crate::timing::{WallClock, median_seconds};
use crate::train::{Body, Workshop};
use crate::{graph, present, progress, store};
use anyhow::{Context, Result, ensure};
use burn::tensor::Device;
use serde::{Deserialize, Serialize};
use sinew_energy::Barriers;
use sinew_gnn::{Backend, ParameterScaling};
use sinew_graph::AugmentationConfig;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

/// Repetitions behind every prediction time.
const TIMING_REPEATS: usize = 15;
/// Parameter sets in a batch whose time per set is reported.
const TIMING_BATCH: usize = 200;

/// What one method contributes to the report; stored, so that a resumed run does not repeat it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) row: MethodRow,
    pub(crate) samples: Vec<SampleRow>,
    pub(crate) history: Option<TrainingHistory>,
    pub(crate) median_and_worst: [usize; 2],
    /// Reasons not to trust the method's errors to be what it can do.
    pub(crate) concerns: Vec<String>,
    #[serde(skip)]
    pub(crate) predictions: Vec<Vec<f64>>,
}

/// Runs `reproduce-beam` and writes its report; the path of `report.html`.
///
/// # Errors
/// Whatever keeps the report from being made: options that contradict an interrupted run, a solver or a
/// training that fails, files that cannot be written.
pub fn reproduce_beam(options: &BeamOptions) -> Result<PathBuf> {
    let manifest = Manifest::of_this_run(options.seed);
    let clock = begin(options)?;
    store::write_json(&options.out.join("manifest.json"), &manifest)?;
    let device = match options.backend {
        BackendChoice::Flex => Backend::Flex,
        BackendChoice::Ndarray => Backend::NdArray,
    }
    .device()?;
    let mut scenes = Vec::new();
    let mut samples = Vec::new();
    let mut notes = notes(options);
    for name in options.scene.names() {
        let beam = if *name == "once" { once_clamped() } else { twice_clamped() };
        let run = run_scene(options, &beam, &device, &clock)?;
        scenes.push(run.scene);
        samples.push(run.samples);
        notes.extend(run.notes.iter().map(|note| format!("{}: {note}", beam.title)));
    }
    let wall = clock.save()?;
    let report = Report {
        schema: report::SCHEMA,
        command: manifest.command,
        finished: report::utc_timestamp(SystemTime::now()),
        wall_s: wall.as_secs_f64(),
        threads: manifest.threads,
        seed: manifest.seed,
        revision: manifest.revision,
        machine: manifest.machine,
        versions: manifest.versions,
        config: toml::to_string_pretty(options)?,
        notes,
        scenes,
    };
    report::write_all(&options.out, &report, &samples)?;
    if options.json {
        println!("{}", report::to_json(&report)?);
    }
    Ok(options.out.join("report.html"))
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
    scene: SceneReport,
    samples: SceneSamples,
    notes: Vec<String>,
}

fn run_scene(
    options: &BeamOptions,
    beam: &Beam,
    device: &Device,
    clock: &WallClock,
) -> Result<SceneRun> {
    eprintln!("\n{}: {}", beam.title, beam.description);
    let folder = options.out.join(beam.name);
    let counts = Samples::of(options);
    let potential = beam.scene.lower()?;
    let simulations = simulate::run(beam, &potential, counts, options.seed, &folder)?;
    clock.save()?;
    let guarded = potential.clone().with_barriers(Barriers::default());
    let test_set = |set: &simulate::Set| TestSet {
        potential: guarded.clone(),
        thetas: set.thetas.clone(),
        displacements: set.fields.clone(),
    };
    let (validation, test) = (test_set(&simulations.validation), test_set(&simulations.test));

    let graph_start = Instant::now();
    let (topology, geometry) = graph::geometry(
        &beam.scene.mesh,
        &potential,
        AugmentationConfig {
            seed: options.seed,
            ..AugmentationConfig::for_nodes(beam.scene.mesh.points.len())
        },
    )?;
    let graph_s = graph_start.elapsed().as_secs_f64();
    let ranges: Vec<[f64; 2]> = beam.scene.parameters.iter().map(|p| p.range).collect();
    let (lower, upper): (Vec<f64>, Vec<f64>) = ranges.iter().map(|[a, b]| (*a, *b)).unzip();
    let body = Body {
        exact: potential.clone(),
        potential: guarded.clone(),
        topology,
        geometry,
        parameters: ParameterScaling::logarithmic(&lower, &upper)?,
        thetas: simulations.training.thetas.clone(),
        linear_response: simulations.linear_response.clone(),
        centre: simulations.centre.clone(),
    };

    let mut outcomes = Vec::new();
    for &method in &options.method {
        let run =
            EmulatorRun { options, beam, device, body: &body, simulations: &simulations, graph_s };
        outcomes.push(run.outcome(method, &validation, &test, &folder.join(method.key()))?);
        clock.save()?;
    }
    outcomes.push(pod_outcome(&simulations, &test, &folder)?);
    outcomes.extend(fem_outcomes(&simulations, &guarded)?);

    present::write_fields(&folder.join("fields"), beam, &simulations, &outcomes)?;
    let scene = present::scene_report(beam, &potential, &simulations, &outcomes)?;
    let notes = scene_notes(simulations.fixture.discretisation_mm, &outcomes);
    let theta_names =
        beam.scene.parameters.iter().map(|p| format!("{}_{}", p.name, p.unit)).collect();
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

/// Trains, times and evaluates one emulator.
struct EmulatorRun<'a> {
    options: &'a BeamOptions,
    beam: &'a Beam,
    device: &'a Device,
    body: &'a Body,
    simulations: &'a Simulations,
    graph_s: f64,
}

impl EmulatorRun<'_> {
    fn outcome(
        &self,
        method: Method,
        validation: &TestSet,
        test: &TestSet,
        folder: &Path,
    ) -> Result<Outcome> {
        let (result, predictions) = (folder.join("result.json"), folder.join("predictions.npy"));
        if self.options.resume
            && let Some(outcome) = store::read_json::<Outcome>(&result)?
        {
            eprintln!("{:<28} kept from the interrupted run", format!("train {}", method.key()));
            return Ok(Outcome { predictions: store::read_table(&predictions)?, ..outcome });
        }
        let plan = Plan::of(self.options, self.beam.name, method);
        let set = &self.simulations.training;
        let fields = (method != Method::Pi).then_some(&set.fields[..]);
        let workshop = Workshop {
            body: self.body,
            method,
            fields,
            validation,
            device: self.device,
            folder,
            resume: self.options.resume,
        };
        let trained = workshop.train(&plan)?;

        let (surrogate, geometry) = (&trained.surrogate, &trained.geometry);
        let fixed = surrogate.fixed_geometry(geometry)?;
        let prediction = fixed.predict(&test.thetas)?;
        let fields: Vec<_> =
            (0..test.thetas.len()).map(|case| prediction.field(case).to_vec()).collect();
        let evaluation = test.evaluate(&fields)?;

        let one = std::slice::from_ref(&test.thetas[0]);
        let many: Vec<_> = test.thetas.iter().cycle().take(TIMING_BATCH).cloned().collect();
        let batch_s = median_seconds(3, || fixed.predict(&many))?;
        let simulated_s =
            if method == Method::Pi { self.simulations.linear_s } else { set.seconds };
        let times = Times {
            prepare_s: self.graph_s + simulated_s + trained.prepare_s,
            train_s: trained.seconds,
            steps: trained.steps,
            predict_full_s: median_seconds(TIMING_REPEATS, || surrogate.predict(geometry, one))?,
            predict_decoder_s: median_seconds(TIMING_REPEATS, || fixed.predict(one))?,
            predict_batch_per_theta_s: batch_s / TIMING_BATCH as f64,
        };
        let description = match method {
            Method::Dd => format!("emulator trained on {} simulations", set.thetas.len()),
            Method::Fdd => {
                format!(
                    "emulator trained on {} simulations with their deformation gradients",
                    set.thetas.len()
                )
            }
            Method::Hybrid => format!(
                "emulator trained on {} simulations, errors weighed by the stiffness about one of them",
                set.thetas.len()
            ),
            Method::Pi => {
                "emulator trained by minimum potential energy, without simulations; one linear solve sets its scale"
                    .to_string()
            }
        };
        let outcome =
            finish(method.into(), &description, &evaluation, times, Some(trained.history), fields)?;
        let outcome = Outcome { concerns: trained.concerns, ..outcome };
        store::write_table(&predictions, &outcome.predictions)?;
        store::write_json(&result, &outcome)?;
        Ok(outcome)
    }
}

const AGAINST_FEM: &str = "our finite-element solution on the same mesh";

fn finish(
    method: report::Method,
    description: &str,
    evaluation: &Evaluation,
    times: Times,
    history: Option<TrainingHistory>,
    predictions: Vec<Vec<f64>>,
) -> Result<Outcome> {
    let reference = match method {
        report::Method::FemCold | report::Method::FemWarm => {
            "FEniCS on the same mesh (fixtures/beam)"
        }
        _ => AGAINST_FEM,
    };
    Ok(Outcome {
        row: MethodRow::from_samples(method, description, reference, evaluation.samples(), times)?,
        samples: evaluation.rows(method)?,
        history,
        median_and_worst: evaluation.median_and_worst(),
        concerns: Vec::new(),
        predictions,
    })
}

/// Regression on few simulations: the rival that an emulator of one fixed geometry has to face.
fn pod_outcome(simulations: &Simulations, test: &TestSet, folder: &Path) -> Result<Outcome> {
    let set = &simulations.pod;
    let start = Instant::now();
    let pod = PodRegression::fit(&set.thetas, &set.fields, &PodConfig::default())?;
    let train_s = start.elapsed().as_secs_f64();
    let bar = progress::bar("regression (pod)", 1);
    let fields: Vec<_> =
        test.thetas.iter().map(|theta| pod.predict(theta)).collect::<Result<_, _>>()?;
    let predict_s = median_seconds(10 * TIMING_REPEATS, || pod.predict(&test.thetas[0]))?;
    let times = Times {
        prepare_s: set.seconds,
        train_s,
        steps: 0,
        predict_full_s: predict_s,
        predict_decoder_s: predict_s,
        predict_batch_per_theta_s: predict_s,
    };
    let description = format!(
        "POD of {} simulations, {} modes, {}",
        set.thetas.len(),
        pod.modes(),
        pod.regression()
    );
    let outcome =
        finish(report::Method::Pod, &description, &test.evaluate(&fields)?, times, None, fields)?;
    progress::finish(&bar, &format!("{} modes", pod.modes()));
    store::write_json(&folder.join("pod.json"), &outcome)?;
    Ok(outcome)
}

/// The solver itself, cold and warm, against the independent solutions.
fn fem_outcomes(simulations: &Simulations, guarded: &sinew_energy::Body) -> Result<Vec<Outcome>> {
    let fixture = &simulations.fixture;
    let truth = TestSet {
        potential: guarded.clone(),
        thetas: fixture.thetas.clone(),
        displacements: fixture.independent.clone(),
    };
    let row = |method, description, fields: &[Vec<f64>], solve_s: f64, batch_s: f64| {
        let times = Times {
            prepare_s: 0.0,
            train_s: 0.0,
            steps: 0,
            predict_full_s: solve_s,
            predict_decoder_s: solve_s,
            predict_batch_per_theta_s: batch_s,
        };
        finish(method, description, &truth.evaluate(fields)?, times, None, fields.to_vec())
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
            simulations.warm_s,
            simulations.test.seconds / simulations.test.thetas.len() as f64,
        )?,
    ])
}
