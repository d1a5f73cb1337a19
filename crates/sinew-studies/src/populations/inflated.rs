//! Ventricles of the thesis' chapter 2: networks on simulations of many shapes, told more or less of the shape (Tables A.8 to A.13).
//!
//! Times of the thesis' network on the thesis' mesh (Table 2.1).

mod hull;
mod methods;
mod perceptron;
mod ventricle;

use super::options::Options;
use super::rows::{Measured, table};
use super::simulated::{Compared, Simulated, Targets};
use super::stage::INFLATED as KEY;
use super::variant::{Inputs, Variant};
use super::{stage, verdict};
use crate::program::cpu_seconds;
use crate::ventricle_shape::VentricleShape;
use anyhow::{Context, Result, ensure};
use methods::{COARSE, COARSE_FULL, Data, PACE, coarse_alone, one_stiffness};
use serde::{Deserialize, Serialize};
use sinew_gnn::{Activation, Surrogate};
use sinew_report::{Block, Chart, Column, Distribution, Row, Section, Table};
use std::ops::Range;
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
    embedding: Option<Chart>,
}

/// The section of the report.
pub(super) fn section(options: &Options) -> Result<Section> {
    let mut studies = options.study(KEY, study)?;
    let measured = studies.iter().map(|study| study.population.iter().chain(&study.one_shape));
    let who_wins = verdict::of_measured(measured)?;
    let study = studies.swap_remove(0);
    let about = "Left ventricles of 32 smooth modes, hexahedra with one volume ratio each, Holzapfel and Ogden's law over two decades in \
                 each parameter, 8 mmHg in the cavity: networks on simulations, told none to all of the numbers of a shape; the same about \
                 the solution of the ventricle on a coarse mesh; and regression.";
    let cases = cases(&study)?;
    let mut blocks = vec![
        Block::Text(about.into()),
        Block::Facts(study.facts),
        Block::Table(table(&study.population)?),
    ];
    let one_shape = "One shape that no network has seen, and what some simulations of it add:";
    let volumes = "Volumes of cavities by methods that find no displacements:";
    let single = "Volumes of single cases, chosen as in the thesis (§2.4.5):";
    for (about, table) in
        [(one_shape, table(&study.one_shape)?), (volumes, table(&study.volumes)?), (single, cases)]
    {
        if !table.rows.is_empty() {
            blocks.extend([Block::Text(about.into()), Block::Table(table)]);
        }
    }
    blocks.extend(who_wins);
    if let Some(embedding) = study.embedding {
        let about = "Embeddings of a ventricle's nodes, by their place from apex to base.";
        blocks.push(Block::charts("What nodes are to the network", about, [embedding]));
    }
    Ok(Section { name: KEY.into(), title: "Inflated ventricles".into(), blocks })
}

/// Errors of the volume of single cases: that which the plain network misses most, and quartiles of networks that were trained further on one
/// shape, beside those that were not.
fn cases(study: &Study) -> Result<Table> {
    let mut table = Table::new(
        [Column::new("case", "%").about("|V − V̂| / V of the cavity in one case")],
        [Column::new("answer", "s")],
        [],
    );
    let mut push = |subject: &str, row: &Measured, case: usize| -> Result<()> {
        let error = 100.0 * row.volumes[case];
        let row = Row::new(&*row.method, error, row.answer_s)?;
        Ok(table.push(Row { subject: subject.into(), ..row })?)
    };
    let plain = study.volumes.iter().find(|row| row.method == "MLP 2, patience none, best weights");
    if let Some(worst) = plain.and_then(|row| ranked(row).pop()) {
        let networks = study.population.iter().filter(|row| row.method.starts_with("K = "));
        for row in plain.into_iter().chain(networks) {
            push("largest error of MLP 2", row, worst)?;
        }
    }
    for pair in
        study.one_shape.windows(2).filter(|pair| pair[1].method.ends_with(", trained further"))
    {
        let order = ranked(&pair[1]);
        for percent in [25, 50, 75] {
            let case = order[percent * (order.len() - 1) / 100];
            for row in pair {
                push(&format!("{percent} % of those trained further"), row, case)?;
            }
        }
    }
    Ok(table)
}

/// Cases of a method by their errors of the volume, the least first.
fn ranked(row: &Measured) -> Vec<usize> {
    let mut cases: Vec<usize> = (0..row.volumes.len()).collect();
    cases.sort_by(|&a, &b| row.volumes[a].total_cmp(&row.volumes[b]));
    cases
}

/// Ventricles of the population by their number. Those to test stay the same when more are drawn.
struct Draw {
    count: usize,
    validation: Range<usize>,
    unseen: Range<usize>,
}

impl Draw {
    /// 2250 to train, as in the thesis; 850 on the mesh of 6788 nodes.
    fn of(options: &Options) -> Self {
        match options {
            Options { quick: true, .. } => Self { count: 11, validation: 6..8, unseen: 8..11 },
            Options { full, .. } => Self {
                count: if *full { 1000 } else { 2400 },
                validation: 850..900,
                unseen: 900..1000,
            },
        }
    }

    /// Number of the ventricle among those to train; none if it is not one of them.
    fn training(&self, index: usize) -> Option<usize> {
        let kept = self.validation.start..self.unseen.end;
        (!kept.contains(&index)).then(|| index - if index < kept.start { 0 } else { kept.len() })
    }
}

fn study(options: &Options) -> Result<Study> {
    eprintln!("\nVentricles of random shape, inflated");
    let (ventricles, draw) = (Ventricles::new(options)?, Draw::of(options));
    let start = Instant::now();
    let most = options.simulations.map_or(usize::MAX, |count| count as usize);
    let wanted = |index: usize| draw.training(index).is_none_or(|number| number < most);
    let all =
        ventricles.simulated(draw.count, wanted, &options.out.join(KEY).join("simulations"))?;
    let seconds = start.elapsed().as_secs_f64();
    // By number, so that one without equilibrium moves no other.
    let [mut training, mut validation, mut unseen] = [Vec::new(), Vec::new(), Vec::new()];
    for (index, ventricle) in all {
        let small = ventricle.volume(&ventricle.displacement) < LARGEST;
        match index {
            _ if draw.validation.contains(&index) => validation.push(ventricle),
            _ if !draw.unseen.contains(&index) => training.push(ventricle),
            _ if small => unseen.push(ventricle),
            _ => {}
        }
    }
    let few = "too few ventricles have an equilibrium";
    ensure!(training.len() > 1 && !validation.is_empty() && !unseen.is_empty(), few);
    let targets = Targets::relative(&training, Inputs { numbers: 0, coarse: false })?;
    let clock = cpu_seconds();
    let timed = &unseen[..TIMED.min(unseen.len())];
    let [coarse_s, solver_s] = ventricles.times(options.quick, timed)?;
    let simulation_s = (cpu_seconds() - clock) / timed.len() as f64;
    let (training, validation, unseen) = (&training[..], &validation[..], &unseen[..]);
    let compared = Compared {
        options,
        training,
        validation,
        unseen,
        targets: &targets,
        pace: PACE,
        simulation_s,
        coarse_s,
    };
    let data = Data { ventricles: &ventricles, compared, solver_s };
    let compared = &data.compared;
    let file = format!("without-networks-seed-{}.json", options.seed);
    let mut study = options.kept(&options.out.join(KEY).join(file), || {
        let mut population = vec![coarse_alone(compared)?, one_stiffness(&ventricles, compared)?];
        population.extend(regressions(compared)?);
        let facts = data.facts(draw.count, seconds)?;
        Ok(Study { facts, population, volumes: data.volumes_alone()?, ..Study::default() })
    })?;
    if !options.no_networks {
        networks(options, &data, &mut study)?;
    }
    Ok(study)
}

/// Networks on the population, and what they make of one shape.
fn networks(options: &Options, data: &Data<'_>, study: &mut Study) -> Result<()> {
    let Data { ventricles, compared, .. } = data;
    let variants = variants(options);
    let one_shape = variants.iter().any(|&(_, goes_on)| goes_on);
    let shape = one_shape.then(|| data.one_shape()).transpose()?;
    if let Some(shape) = &shape {
        study.one_shape = shape.without_networks(data)?;
    }
    // A second thread would nearly double the CPU time of a step of one body for a tenth of its wall time.
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for (variant, goes_on) in variants {
        let (numbers, topology) = (variant.told.numbers, ventricles.graph(variant.virtual_nodes)?);
        let steps = variant.pace.unwrap_or(PACE).steps;
        let about =
            format!("network on simulations, told {numbers} numbers of the shape, {steps} steps");
        let method = format!("{}, {numbers} numbers{}", variant.name(), variant.told.name());
        let names = [&method[..], &about];
        let more = |surrogate: &Surrogate| {
            let shape = shape.as_ref().filter(|_| goes_on);
            shape.map(|shape| shape.fine_tuned(data, variant, surrogate)).transpose()
        };
        let train = || compared.kept_network(KEY, names, variant, &topology, more);
        let (measured, more) = one_thread.install(train)?;
        study.population.push(measured);
        let Some(found) = more else { continue };
        study.one_shape.extend(found.rows);
        if study.embedding.is_none() {
            study.embedding = Some(found.embedding);
            study.facts.extend(found.facts);
        }
    }
    Ok(())
}

/// Regression on an eighth of the simulations and on all of them, alone and about the coarse solution.
fn regressions(compared: &Compared<'_, ventricle::Ventricle>) -> Result<Vec<Measured>> {
    let all = compared.training.len();
    let counts = [all.div_ceil(8).max(2), all];
    let variants = counts.into_iter().flat_map(|count| [false, true].map(|coarse| (count, coarse)));
    variants
        .map(|(count, coarse)| compared.regression(count, Inputs { numbers: ALL, coarse }))
        .collect()
}

/// Numbers of a shape, and K of the networks that differ in what they are told.
const ALL: usize = VentricleShape::NUMBERS;
const STEPS: usize = 3;

/// Networks of Tables A.8 to A.10, and whether they are fine-tuned on one shape, these first. The thesis' 40 components hold what the 32
/// numbers here do. On the mesh of 6788 nodes, where a training step takes three quarters of a CPU second, one network is trained.
fn variants(options: &Options) -> Vec<(Variant, bool)> {
    let virtual_nodes = VIRTUAL_NODES[usize::from(options.full)];
    let of =
        |steps, numbers, coarse| Variant::new(steps, 40, virtual_nodes, Inputs { numbers, coarse });
    if options.quick {
        let quick = |coarse| Variant { latent: 8, virtual_nodes: &[8], ..of(1, ALL, coarse) };
        return [false, true].map(|coarse| (quick(coarse), true)).to_vec();
    }
    if options.full {
        let network = Variant { activation: Activation::Celu, ..of(STEPS, ALL, true) };
        return vec![(Variant { pace: Some(COARSE_FULL), ..network }, false)];
    }
    let coarse = [STEPS, 1].map(|k| Variant { pace: Some(COARSE), ..of(k, ALL, true) });
    let alone = |k, numbers| Variant { activation: Activation::Celu, ..of(k, numbers, false) };
    let fine_tuned = coarse.into_iter().chain([alone(STEPS, ALL)]);
    let told = [24, 16, 8, 0].map(|numbers| alone(STEPS, numbers));
    let steps = [1, 2, 4, 5, 6].map(|k| alone(k, ALL));
    let raw = Variant { raw: true, ..alone(STEPS, ALL) };
    let others = told.into_iter().chain(steps).chain([raw]);
    fine_tuned
        .map(|variant| (variant, true))
        .chain(others.map(|variant| (variant, false)))
        .collect()
}

/// The section of the report: answers for a shape that changes and for one that stays, beside the solver, all parameters 1.
pub(in crate::populations) fn speed(options: &Options) -> Result<Section> {
    options.kept(&options.out.join(stage::SPEED).join("section.json"), || speed_measured(options))
}

fn speed_measured(options: &Options) -> Result<Section> {
    let options = &Options { full: !options.quick, ..options.clone() };
    let ventricles = Ventricles::new(options)?;
    let numbers = vec![0.0; ALL];
    let found = ventricles.at(&numbers, &[vec![1.0; 4]])?;
    let only =
        found.first().context("the mean ventricle has no equilibrium at all parameters 1")?;
    let one = std::slice::from_ref(only);
    let [coarse_s, solver_s] = ventricles.times(options.quick, one)?;
    let compared = Compared {
        options,
        training: one,
        validation: one,
        unseen: one,
        targets: &Targets::absolute(),
        pace: PACE,
        simulation_s: solver_s,
        coarse_s,
    };
    let told = Inputs { numbers: ALL, coarse: false };
    let virtual_nodes = if options.quick { &[8][..] } else { VIRTUAL_NODES[1] };
    let (steps, latent) = if options.quick { (1, 8) } else { (5, 40) };
    let variant = Variant::new(steps, latent, virtual_nodes, told);
    let topology = ventricles.graph(virtual_nodes)?;
    let surrogate = compared.untrained(variant, &compared.data_set(&topology, told)?)?;
    let errors = only.distances(&compared.predicting(&surrogate, &topology, told)(only)?);
    let data = Data { ventricles: &ventricles, compared, solver_s };
    let [varies_s, stays_s] = data.answer_times(&variant, &surrogate)?;
    let mut table = Table::new(
        [Column::new("err_u", "mm").about("‖u − û‖ at every node; of an untrained network")],
        [Column::new("answer", "s").about("CPU time of one parameter set")],
        [],
    );
    for (method, errors, seconds) in [
        ("network, shape varies", errors.clone(), varies_s),
        ("network, shape stays", errors, stays_s),
        ("coarse solution", only.distances(&only.coarse.displacement), coarse_s),
        ("solver", vec![0.0], solver_s),
    ] {
        let errors = Distribution::of(errors).context("a ventricle without nodes")?;
        table.push(Row::new(method, errors, seconds)?)?;
    }
    let nodes = format!("{} nodes.", only.body.nodes);
    let about = "CPU times of one answer, all parameters 1. The network has random weights, on which times do not depend: its errors mean nothing.";
    let blocks = vec![Block::Text(about.into()), Block::Text(nodes), Block::Table(table)];
    Ok(Section { name: stage::SPEED.into(), title: "Times on the thesis' mesh".into(), blocks })
}
