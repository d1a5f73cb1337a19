//! Coverage of error estimates: how often an answer is farther from the solver than it says, on bodies and ranges that nothing was
//! tuned for (`cargo xtask coverage-estimates`).

mod bodies;
mod outcome;

use crate::program;
use anyhow::{Context, Result};
use bodies::Shapes;
use clap::Parser;
use outcome::{Answer, GOOD, Outcome, solutions};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew::case::{RecipeName, Training};
use sinew::{Body, Emulator, Parameter, TrainingOptions};
use sinew_emulate::{Budget, Design, Error, Estimate, Prediction, split_seed, store};
use sinew_fem::{FrozenStiffness, Solver};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Compare error estimates with true errors: bodies × recipes × parameter sets, half of these uniform in the ranges, half at their edges
/// and up to 1.5 times outside. Every prediction is also refined by four quasi-Newton steps and corrected by a Newton step.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask coverage-estimates", version, max_term_width = 110)]
pub struct Options {
    /// Parts of names of bodies, separated by commas [default: all bodies]
    #[arg(long, value_delimiter = ',')]
    pub only: Vec<String>,
    /// Recipes to train
    #[arg(long, value_delimiter = ',', value_enum, default_value = "taylor,regression,dd,pi")]
    pub recipe: Vec<RecipeName>,
    /// Parameter sets of each body
    #[arg(long, default_value_t = 40)]
    pub cases: usize,
    /// Training steps of networks relative to their recipe; below 1, since poor networks are tested too
    #[arg(long, default_value_t = 0.15)]
    pub effort: f64,
    /// Folder with left_ventricle.vtk and liver.vtk; optional
    #[arg(long, default_value = "../shared/meshes")]
    pub meshes: PathBuf,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for tables and stored results
    #[arg(long, default_value = "out/coverage-estimates")]
    pub out: PathBuf,
    /// Keep the finished parts of an earlier run with the same options
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

/// Simulations that a regression, and networks, learn from.
const SIMULATIONS: usize = 25;
/// Quasi-Newton steps of refined answers.
const REFINED: usize = 4;
/// Bodies of random shape, and quasi-Newton steps with the stiffness of the mean one.
const UNSEEN: u64 = 40;
const STEPS: [usize; 2] = [8, 32];

/// Runs all of it and writes `coverage.json` and `coverage.md`; the path of that.
///
/// # Errors
/// A body that cannot be made, files that cannot be written.
pub fn run(options: &Options) -> Result<PathBuf> {
    let wanted = |name: &str| {
        options.only.is_empty() || options.only.iter().any(|part| name.contains(part.as_str()))
    };
    let mut outcomes = Vec::new();
    for (name, body) in bodies::all(&options.meshes)?.iter().filter(|(name, _)| wanted(name)) {
        let file = options.out.join(format!("{}.json", name.replace(' ', "-")));
        let of_body = || of_body(options, name, body).with_context(|| name.clone());
        outcomes.extend(program::kept(&file, options.resume, of_body)?);
        write(options, &outcomes)?;
    }
    for shapes in Shapes::ALL.into_iter().filter(|shapes| wanted(shapes.name())) {
        let file = options.out.join(format!("{}.json", shapes.name().replace(' ', "-")));
        let unseen = || unseen(options, shapes).with_context(|| shapes.name());
        outcomes.extend(program::kept(&file, options.resume, unseen)?);
        write(options, &outcomes)?;
    }
    print!("{}", table(&outcomes));
    Ok(options.out.join("coverage.md"))
}

fn write(options: &Options, outcomes: &[Outcome]) -> Result<()> {
    store::write_json(&options.out.join("coverage.json"), &(options, outcomes))?;
    Ok(store::write_bytes(&options.out.join("coverage.md"), table(outcomes).as_bytes())?)
}

/// All recipes on one body.
fn of_body(options: &Options, name: &str, body: &Body) -> Result<Vec<Outcome>> {
    eprintln!("{name}: {} nodes", body.nodes);
    let thetas = thetas(body, options.cases, options.seed)?;
    let truths = solutions(body, &thetas)?;
    let mut outcomes = Vec::new();
    for recipe in &options.recipe {
        let emulator = match train(options, *recipe, body) {
            Ok(emulator) => emulator,
            Err(error) => {
                eprintln!("{name}: no emulator by {recipe:?}: {error}");
                continue;
            }
        };
        let mut judge = |what: &str, prediction: &Prediction| -> Result<()> {
            let estimates = emulator.estimates(prediction)?;
            let predictor = format!("{}{what}", emulator.record.recipe);
            let answers: Vec<Answer<'_>> = estimates
                .into_iter()
                .enumerate()
                .map(|(case, estimate)| Answer {
                    theta: &thetas[case],
                    displacement: prediction.field(case),
                    estimate,
                    truth: truths[case].as_deref(),
                })
                .collect();
            outcomes.push(Outcome::of((name, body), &predictor, &answers)?);
            Ok(())
        };
        judge("", &emulator.predict(&thetas)?)?;
        judge(&format!(", {REFINED} quasi-Newton steps"), &emulator.refine(&thetas, REFINED)?)?;
        let corrected: Vec<Vec<f64>> =
            thetas.par_iter().map(|theta| corrected(&emulator, theta)).collect::<Result<_>>()?;
        let prediction = emulator.predict(&thetas)?;
        judge(", a Newton step", &Prediction { displacement: corrected.concat(), ..prediction })?;
        if let Some(last) = outcomes.last() {
            eprintln!("{}", row(last));
        }
    }
    Ok(outcomes)
}

/// The displacement after a Newton step, or the prediction where that inverts a cell.
fn corrected(emulator: &Emulator<'_>, theta: &[f64]) -> Result<Vec<f64>> {
    match emulator.correct(theta, 1) {
        Ok(corrected) => Ok(corrected.displacement),
        Err(Error::Solve(_)) => Ok(emulator.predict(&[theta.to_vec()])?.displacement),
        Err(other) => Err(other.into()),
    }
}

fn train<'b>(
    options: &Options,
    name: RecipeName,
    body: &'b Body,
) -> sinew_emulate::Result<Emulator<'b>> {
    let training = Training {
        recipe: Some(name),
        samples: Some(SIMULATIONS),
        target: Some(0.0),
        ..Training::default()
    };
    let recipe = training.recipe();
    let options = TrainingOptions {
        budget: Budget::Effort(options.effort),
        seed: options.seed,
        held_out: 4,
        evaluations: 2,
        ..TrainingOptions::default()
    };
    recipe.train(body, &options, &mut ())
}

/// Bodies of random shape by a frozen stiffness.
fn unseen(options: &Options, shapes: Shapes) -> Result<Vec<Outcome>> {
    let mean = shapes.body(None)?;
    let stiffness = FrozenStiffness::new(&mean)?;
    let mut sums: Vec<Outcome> = Vec::new();
    for number in 0..UNSEEN {
        let body = shapes.body(Some(split_seed(options.seed + 1, number)))?;
        let theta = thetas(&body, 2, split_seed(options.seed, number))?;
        let truths = solutions(&body, &theta)?;
        let mut judge = |predictor: &str, fields: Vec<Vec<f64>>| -> Result<()> {
            let mut solver = Solver::new(&body)?;
            let mut answers = Vec::new();
            for (case, field) in fields.iter().enumerate() {
                let estimate = Estimate::from(solver.error_estimate(field, &theta[case])?);
                let truth = truths[case].as_deref();
                answers.push(Answer { theta: &theta[case], displacement: field, estimate, truth });
            }
            let outcome = Outcome::of((shapes.name(), &body), predictor, &answers)?;
            add(&mut sums, outcome);
            Ok(())
        };
        for steps in STEPS {
            let found = theta.iter().map(|theta| stiffness.descend(&body, theta, steps));
            let fields = found.map(|found| Ok(found?.displacement)).collect::<Result<_>>()?;
            judge(&format!("frozen stiffness, {steps} steps"), fields)?;
        }
    }
    Ok(sums)
}

/// Parameter sets: half uniform in the ranges, half at edges and up to 1.5 times outside.
fn thetas(body: &Body, count: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
    /// Farthest outside of a range \[relative to its end\].
    const FARTHEST: f64 = 1.5;
    let mut found = Design::Uniform.sample(&body.parameters, count / 2, seed)?;
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(seed, 1));
    while found.len() < count {
        let mut end = |p: &Parameter| {
            let factor = FARTHEST.powf((2.0 * random.random::<f64>() - 1.0).max(0.0));
            let [low, high] = p.range;
            if random.random() { high * factor } else { low / factor }
        };
        let theta: Vec<f64> = body.parameters.iter().map(&mut end).collect();
        // Some have no meaning, such as a Poisson's ratio above one half.
        if body.check_theta(&theta).is_ok() {
            found.push(theta);
        }
    }
    Ok(found)
}

/// All rows, with sums over the bodies for every predictor and over all, as Markdown.
fn table(outcomes: &[Outcome]) -> String {
    let mut text = format!(
        "| body | predictor | solved | understated ×2 | ×10 | worst | other equilibrium | refused | good (≤ {:.0} %) | good refused | \
         no equilibrium | estimated there | an estimate |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        100.0 * GOOD
    );
    let mut sums: Vec<Outcome> = Vec::new();
    let mut all = Outcome { body: "all".into(), predictor: "all".into(), ..Outcome::default() };
    for outcome in outcomes {
        let _ = writeln!(text, "{}", row(outcome));
        all.add(outcome);
        add(&mut sums, Outcome { body: "all".into(), ..outcome.clone() });
    }
    for sum in sums.iter().chain([&all]) {
        let _ = writeln!(text, "{}", row(sum));
    }
    text
}

/// Adds an outcome to the sum of its predictor.
fn add(sums: &mut Vec<Outcome>, outcome: Outcome) {
    match sums.iter_mut().find(|sum| sum.predictor == outcome.predictor) {
        Some(sum) => sum.add(&outcome),
        None => sums.push(outcome),
    }
}

fn row(outcome: &Outcome) -> String {
    let Outcome { body, predictor, solved, refused, good, good_refused, hopeless, .. } = outcome;
    let Outcome { hopeless_estimated, elsewhere, estimate_s, .. } = outcome;
    let [twice, ten] = [2.0, 10.0].map(|factor| outcome.understated(factor));
    let (worst, ms) = (outcome.worst(), 1e3 * estimate_s);
    format!(
        "| {body} | {predictor} | {solved} | {twice} | {ten} | {worst:.2} | {elsewhere} | {refused} | {good} | {good_refused} | \
         {hopeless} | {hopeless_estimated} | {ms:.0} ms |"
    )
}
