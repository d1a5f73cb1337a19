//! Learning rates (thesis B.1): four beams trained by energy at several rates, in the thesis' way and in ours.

use crate::organs::options::Options;
use crate::organs::run::{QUICK, begin, train};
use crate::organs::scenes::{BEAMS, OURS, RATE_S, RATES as KEY, THESIS};
use crate::program;
use anyhow::Result;
use serde::{Deserialize, Serialize};
use sinew::recipe::{PhysicsInformed, TrainingConfig};
use sinew::{Body, Case};
use sinew_emulate::{CurvePoint, store};
use sinew_gnn::{Network, OptimiserConfig, OutputCoordinates, Schedule};
use sinew_report::{Block, Cell, Chart, Column, Row, Section, Series, Style, Table};
use std::path::Path;

/// A network trained at one rate.
#[derive(Debug, Serialize, Deserialize)]
struct Outcome {
    rule: String,
    curve: Vec<CurvePoint>,
    train_s: f64,
    /// Why the training ended early.
    failure: Option<String>,
}

/// Trains every beam at every rate.
pub(crate) fn section(options: &Options) -> Result<Section> {
    begin(options, KEY)?;
    let mut blocks = vec![Block::Text(
        "Thesis B.1: learning rates of networks that are trained by energy. In the thesis' way, displacements as they are, one parameter \
         set a step, Adam at a constant rate and message passing to the end; and as this library trains, with the peak of Muon's rate. \
         Every training has the same time. The thesis trains for a million steps, and says that 5e-4 diverged on every beam; here a \
         barrier keeps cells from turning over."
            .into(),
    )];
    let scenes = if options.quick { &BEAMS[..1] } else { &BEAMS };
    for scene in scenes {
        let case = Case::read(Path::new(scene))?;
        let body = case.body()?;
        eprintln!("\nlearning rates, {scene}");
        let mut outcomes = Vec::new();
        for (rule, recipe) in rules(options) {
            let folder = options.out.join(KEY).join(scene).join(rule.replace(", ", "-"));
            outcomes.push(program::kept(&folder.join("outcome.json"), options.resume, || {
                outcome(options, &body, &rule, recipe, &folder)
            })?);
        }
        blocks.extend(report(scene, &outcomes)?);
    }
    Ok(Section { name: KEY.into(), title: "Learning rates".into(), blocks })
}

/// The thesis' schedule (§3.3.1): samples one by one, Adam at a constant rate.
fn thesis_training(learning_rate: f64) -> TrainingConfig {
    TrainingConfig {
        optimiser: OptimiserConfig::adam(),
        learning_rate,
        schedule: Schedule::Constant,
        batch: 1,
        gradient_norm_limit: None,
        ..TrainingConfig::default()
    }
}

/// Names and recipes.
fn rules(options: &Options) -> impl Iterator<Item = (String, PhysicsInformed)> {
    let thesis = THESIS.map(|rate| {
        let training = thesis_training(rate);
        let coordinates = OutputCoordinates::Components;
        // The thesis' sizes (§2.2.4).
        let network = Network { width: 128, ..Network::default() };
        let recipe = PhysicsInformed { parameter_sets: 200, coordinates, network, training };
        (format!("thesis, {rate:.0e}"), recipe)
    });
    let ours = OURS.map(|rate| {
        let mut recipe = PhysicsInformed::default();
        recipe.training.learning_rate = rate;
        if let OutputCoordinates::MotionsAfter(first) = &mut recipe.coordinates {
            first.learning_rate = rate;
        }
        (format!("ours, {rate:.1e}"), recipe)
    });
    let sets = options.quick.then_some(QUICK[1]);
    thesis.into_iter().chain(ours).map(move |(rule, recipe)| {
        let parameter_sets = sets.unwrap_or(recipe.parameter_sets);
        (rule, PhysicsInformed { parameter_sets, ..recipe })
    })
}

fn outcome(
    options: &Options,
    body: &Body,
    rule: &str,
    recipe: PhysicsInformed,
    folder: &Path,
) -> Result<Outcome> {
    let budget = options.training(RATE_S / 60.0, QUICK[2]);
    let trained = train(options, body, &recipe.into(), budget, None, folder);
    let (curve, train_s, failure) = match trained {
        Ok(emulator) => {
            let record = &emulator.record;
            (record.history.clone(), record.prepare_s + record.train_s, None)
        }
        Err(error) => {
            let curve: Vec<CurvePoint> =
                store::read_json(&folder.join("curve.json"))?.unwrap_or_default();
            let train_s = curve.last().map_or(0.0, |point| point.train_s);
            (curve, train_s, Some(format!("{error:#}")))
        }
    };
    Ok(Outcome { rule: rule.into(), curve, train_s, failure })
}

fn report(scene: &str, outcomes: &[Outcome]) -> Result<Vec<Block>> {
    let mut table = Table::new(
        [
            Column::new("err_u", "mm").about("‖u − û‖ at every node that is free to move"),
            Column::new("err_F", "%").about("‖F − F̂‖ / ‖F‖ at every quadrature point"),
        ],
        [Column::new("train", "s").once()],
        [Column::new("steps", "")],
    );
    let mut chart = Chart::new(scene, ["time [s]", "err_u [mm]"], [false, true]);
    let mut texts = vec![Block::Text(scene.into())];
    for Outcome { rule, curve, train_s, failure } in outcomes {
        let mut errors = curve.iter().filter_map(|point| Some((point, point.medians?)));
        let points: Vec<_> = errors.clone().map(|(point, e)| [point.train_s, e[0]]).collect();
        chart = chart.with(Series::new(rule.clone(), Style::Line, points));
        if let Some(failure) = failure {
            texts.push(Block::Text(format!("{rule}: {failure}")));
        }
        if let Some((point, [err_u, err_f, ..])) = errors.next_back() {
            let row = Row::new(rule.clone(), Cell::from(err_u), *train_s)?.error(err_f);
            table.push(row.other(point.step as f64))?;
        }
    }
    texts.push(Block::Table(table));
    texts.push(Block::charts("Error against time", "Median over the held-out cases.", [chart]));
    Ok(texts)
}
