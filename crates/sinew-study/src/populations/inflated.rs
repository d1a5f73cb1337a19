//! Ventricles of the thesis' chapter 2: networks on simulations of many shapes, told more or less of the shape (Tables A.8 to A.13).

mod hull;
mod methods;
mod perceptron;
mod ventricle;
mod volumes;

use super::measure::cpu_seconds;
use super::options::Options;
use super::simulated::{Compared, Measured, Seen, Variant, table};
use super::stage;
use super::verdict;
use anyhow::{Result, ensure};
use methods::{Data, PACE, coarse_alone, one_stiffness};
use serde::{Deserialize, Serialize};
use sinew_emulate::Shard;
use sinew_mesh::VentricleShape;
use sinew_report::{Block, Chart, Figure, Map, Panel, Section};
use std::path::PathBuf;
use std::time::Instant;
use ventricle::Ventricles;

/// Virtual nodes on the small mesh and on the thesis'.
const VIRTUAL_NODES: [&[usize]; 2] = [&[60, 8], &[848, 106, 13]];
/// Ventricles with larger cavities are not tested \[mm³\].
const LARGEST: f64 = 850e3;
/// Ventricles whose simulations are timed.
const TIMED: usize = 5;

/// Everything measured.
#[derive(Default, Serialize, Deserialize)]
struct Study {
    facts: Vec<(String, String)>,
    population: Vec<Measured>,
    one_shape: Vec<Measured>,
    #[serde(default)]
    volumes: Vec<Measured>,
    /// log₁₀ of the median error \[mm\] over b, each over a.
    map: Vec<Vec<Option<f64>>>,
    embedding: Option<Chart>,
}

/// The section of the report.
pub(super) fn section(options: &Options) -> Result<Section> {
    let mut studies = options.study(stage::INFLATED, study)?;
    let measured = studies.iter().map(|study| study.population.iter().chain(&study.one_shape));
    let who_wins = verdict::of_measured(measured)?;
    let study = studies.swap_remove(0);
    let about = "Left ventricles of 32 smooth modes, hexahedra with one volume ratio each, Holzapfel and Ogden's law over two decades in \
                 each parameter, 8 mmHg in the cavity: networks on simulations, told none to all of the numbers of a shape; the same about \
                 the solution of the ventricle on a coarse mesh; and regression.";
    let mut blocks = vec![
        Block::Text(about.into()),
        Block::Facts(study.facts),
        Block::Table(table(&study.population)?),
    ];
    if !study.one_shape.is_empty() {
        let about = "One shape that no network has seen, and what some simulations of it add:";
        blocks.extend([Block::Text(about.into()), Block::Table(table(&study.one_shape)?)]);
    }
    if !study.volumes.is_empty() {
        let about = "Volumes of cavities by methods that find no displacements:";
        blocks.extend([Block::Text(about.into()), Block::Table(table(&study.volumes)?)]);
    }
    blocks.extend(who_wins);
    if let Some(embedding) = study.embedding {
        blocks.push(Block::Figure(figure(study.map)));
        let about = "Embeddings of a ventricle's nodes, by their place from apex to base.";
        blocks.push(Block::charts("What nodes are to the network", about, [embedding]));
    }
    Ok(Section { name: stage::INFLATED.into(), title: "Inflated ventricles".into(), blocks })
}

/// Errors over two parameters.
fn figure(rows: Vec<Vec<Option<f64>>>) -> Figure {
    let range = [0.1f64, 10.0].map(f64::log10);
    let map = Map {
        title: "log₁₀ of the median err_u [mm]".into(),
        axes: ["log₁₀ a [kPa]", "log₁₀ b"].map(String::from),
        ranges: [range, range],
        scale: Map::range(&rows),
        rows,
        marks: Vec::new(),
    };
    Figure {
        title: "Errors over two parameters".into(),
        caption: "Of the network about the coarse solution on one shape, a_f = 1 kPa, b_f = 1."
            .into(),
        panels: vec![Panel::Map(map)],
    }
}

/// Simulates one part of the ventricles of every seed.
pub(super) fn simulate(options: &Options, shard: Shard) -> Result<PathBuf> {
    let count = counts(options).iter().sum();
    for options in options.of_each_seed() {
        Ventricles::new(&options)?.simulated(
            count,
            |_| true,
            &simulations(&options),
            Some(shard),
        )?;
    }
    Ok(simulations(options))
}

/// Ventricles to train, to choose weights, to test.
fn counts(options: &Options) -> [usize; 3] {
    if options.quick { [6, 2, 3] } else { [850, 50, 100] }
}

fn study(options: &Options) -> Result<Study> {
    eprintln!("\nVentricles of random shape, inflated");
    let (ventricles, counts) = (Ventricles::new(options)?, counts(options));
    let start = Instant::now();
    let drawn: usize = counts.iter().sum();
    let learned = options.simulations.map_or(counts[0], |count| count as usize);
    let wanted = |index: usize| index < learned || index >= counts[0];
    let all = ventricles.simulated(drawn, wanted, &simulations(options), None)?;
    let seconds = start.elapsed().as_secs_f64();
    // By number, so that one without equilibrium moves no other.
    let [mut training, mut validation, mut unseen] = [Vec::new(), Vec::new(), Vec::new()];
    for (index, ventricle) in all {
        let small = ventricle.volume(&ventricle.displacement) < LARGEST;
        match index {
            _ if index < counts[0] => training.push(ventricle),
            _ if index < counts[0] + counts[1] => validation.push(ventricle),
            _ if small => unseen.push(ventricle),
            _ => {}
        }
    }
    let few = "too few ventricles have an equilibrium";
    ensure!(training.len() > 1 && !validation.is_empty() && !unseen.is_empty(), few);
    let clock = cpu_seconds();
    let timed = &unseen[..TIMED.min(unseen.len())];
    let [coarse_s, solver_s] = ventricles.times(timed)?;
    let simulation_s = (cpu_seconds() - clock) / timed.len() as f64;
    let (training, validation, unseen) = (&training[..], &validation[..], &unseen[..]);
    let compared =
        Compared { options, training, validation, unseen, pace: PACE, simulation_s, coarse_s };
    let data = Data { ventricles: &ventricles, compared, solver_s };
    let compared = &data.compared;
    let facts = data.facts(drawn, seconds)?;
    let mut population = vec![coarse_alone(compared)?, one_stiffness(&ventricles, compared)?];
    // Of a few simulations all are wanted.
    let parts = if options.simulations.is_some() { [2, 1] } else { [4, 2] };
    for count in parts.map(|part| training.len().div_ceil(part).max(2).min(training.len())) {
        for coarse in [false, true] {
            population.push(compared.regression(count, Seen { numbers: ALL, coarse })?);
        }
    }
    let volumes = data.volumes_alone()?;
    let mut study = Study { facts, population, volumes, ..Study::default() };
    if !options.no_networks {
        networks(options, &data, &mut study)?;
    }
    Ok(study)
}

/// Networks on the population, and what they make of one shape.
fn networks(options: &Options, data: &Data<'_>, study: &mut Study) -> Result<()> {
    let Data { ventricles, compared, .. } = data;
    let mut general = Vec::new();
    for variant in variants(options) {
        let (numbers, topology) = (variant.told.numbers, ventricles.graph(variant.virtual_nodes)?);
        let about = format!("network on simulations, told {numbers} numbers of the shape");
        let method = format!("{}, {numbers} numbers{}", variant.name(), variant.told.name());
        let (measured, surrogate) = compared.network([&method, &about], variant, &topology)?;
        study.population.push(measured);
        if numbers == ALL && (variant.told.coarse || variant.steps == STEPS || options.quick) {
            general.push((variant, surrogate));
        }
    }
    (study.one_shape, study.map) = data.one_shape(&general)?;
    let (variant, surrogate) = &general[0];
    let topology = ventricles.graph(variant.virtual_nodes)?;
    let (embedding, fact) = compared.embedding((variant, surrogate), &topology, 2)?;
    study.facts.extend([fact, data.times(&general[0])?]);
    study.embedding = Some(embedding);
    Ok(())
}

/// Numbers of a shape, and K of the networks that differ in what they are told.
const ALL: usize = VentricleShape::NUMBERS;
const STEPS: usize = 3;

fn simulations(options: &Options) -> PathBuf {
    options.out.join(stage::INFLATED).join("simulations")
}

/// Networks of Tables A.8 and A.9, and the one about the coarse solution, with the medians that the thesis prints: err_u \[mm\] and
/// LVV \[%\].
fn variants(options: &Options) -> Vec<Variant> {
    let virtual_nodes = VIRTUAL_NODES[usize::from(options.full)];
    let of = |steps, numbers, coarse, printed| {
        let told = Seen { numbers, coarse };
        Variant { steps, latent: 40, virtual_nodes, told, printed }
    };
    if options.quick {
        let quick =
            |coarse| Variant { latent: 8, virtual_nodes: &[8], ..of(1, ALL, coarse, [None; 2]) };
        return [false, true].map(quick).to_vec();
    }
    let told = [(0, 527.0), (8, 446.0), (16, 413.0), (24, 318.0)];
    let told = told
        .map(|(numbers, micrometres)| of(STEPS, numbers, false, [Some(1e-3 * micrometres), None]));
    // The thesis' 40 components hold what these 32 numbers do.
    let whole = |k, coarse| of(k, ALL, coarse, [Some(0.241), Some(0.49)]);
    let steps = [(1, 0.298), (5, 0.266)].map(|(k, error)| of(k, ALL, false, [Some(error), None]));
    told.into_iter()
        .chain([whole(STEPS, false)])
        .chain(steps)
        .chain([whole(1, true), whole(STEPS, true)])
        .collect()
}
