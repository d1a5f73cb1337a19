//! The study of populations, from bodies to the report.

use super::measure::Group;
use super::options::{Options, keys};
use super::rivals::{Rival, coarse, rivals};
use super::section::{Study, section};
use super::stage::{INFLATED, Individual, RECTANGLES, SPEED, Stage};
use super::{inflated, rectangles};
use crate::program::Growing;
use anyhow::{Context, Result};
use sinew_emulate::Emulator;
use sinew_fem::FrozenStiffness;
use sinew_report::{Report, Section};
use std::path::PathBuf;

/// Streams that individuals are drawn from: simulated for regressions, and tested on.
const STREAMS: [u64; 2] = [23, 47];

/// Runs all populations that are asked for and writes the report, anew after each; the path of `report.html`.
///
/// # Errors
/// Whatever keeps a population from being learned, and files that cannot be written. Populations that are done are kept.
pub fn reproduce(options: &Options) -> Result<PathBuf> {
    let about = "Errors on shapes that no method has seen, beside CPU time; the truth is our finite-element solution.";
    let names = ["Populations of shapes", about];
    let mut growing = Growing::new(names, (options.seed, options.quick), options, headline)?;
    let mut page = options.out.join("report.html");
    for key in keys().into_iter().filter(|key| options.wants(key)) {
        let section = match key {
            RECTANGLES => rectangles::section(options),
            INFLATED => inflated::section(options),
            SPEED => inflated::speed(options),
            _ => {
                let studies = options.study(key, |options| study(options, key));
                studies.and_then(|studies| section(key, &studies))
            }
        };
        let section = section.with_context(|| format!("population {key}"))?;
        page = growing.add(section, &options.out)?;
    }
    Ok(page)
}

/// The method with the least median error, raw, on the bodies of each population.
fn headline(report: &Report) -> String {
    let best = |section: &Section| -> Option<String> {
        let rows = section.tables().take(1).flat_map(|table| &table.rows);
        let rows = rows.filter(|row| row.subject.is_empty() || row.subject == POPULATION);
        let errors = rows.filter_map(|row| Some((row.errors.first()?.value.median()?, row)));
        let (_, row) = errors.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!("{}: {}", section.name, row.method))
    };
    let all: Vec<String> = report.sections.iter().filter_map(best).collect();
    format!("Nearest raw, by the median, on bodies of the population: {}.", all.join("; "))
}

/// Name of the group of bodies that are drawn as those trained on.
const POPULATION: &str = "population";

impl Options {
    fn wants(&self, key: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|only| only == key)
    }

    fn stream(&self, which: usize) -> u64 {
        self.seed.wrapping_mul(1000) + STREAMS[which]
    }

    /// Individuals tested on, and simulations of the rivals.
    fn size(&self, key: &str) -> (u64, &'static [usize]) {
        match (self.quick, key) {
            (true, _) => (3, &[8]),
            (_, "rings") => (200, &[50, 200, 400]),
            (_, "beams") => (200, &[100, 400]),
            (_, "infarcts") => (60, &[300]),
            _ => (60, &[100, 300]),
        }
    }
}

fn study(options: &Options, key: &str) -> Result<Study> {
    let (stage, (tests, simulations)) = (Stage::new(key, options.quick)?, options.size(key));
    eprintln!("\n{}", stage.about);
    let groups = groups(options, &stage, tests)?;
    let mut study = Study::default();
    for group in &groups {
        let nodes: Vec<usize> = group.individuals.iter().map(|i| i.body.nodes).collect();
        let least = nodes.iter().min().copied().unwrap_or_default();
        let most = nodes.iter().max().copied().unwrap_or_default();
        let nodes = if least == most { least.to_string() } else { format!("{least} to {most}") };
        let [seconds, iterations] = group.solve;
        let fact = format!(
            "{} solved, {} without an equilibrium left out, {nodes} nodes; a cold solve takes {iterations:.0} iterations (median) and {:.0} ms",
            group.truths.len(),
            group.unsolved,
            1e3 * seconds
        );
        study.facts.push((group.name.clone(), fact));
    }
    for &count in simulations.iter().filter(|_| !options.no_rivals) {
        for Rival { names: [name, about], cpu_s, predict } in
            rivals(&stage, options.stream(0), count)?
        {
            study.outcomes.push(groups[0].measure([&name, &about], cpu_s, predict)?);
        }
    }
    expanded(options, &stage, &groups, &mut study)?;
    Ok(study)
}

/// Individuals of the population, and others: of other meshes, beyond its spread, of a person.
fn groups(options: &Options, stage: &Stage, tests: u64) -> Result<Vec<Group>> {
    let draw = |stage: &Stage, count: u64| {
        let (stage, stream) = (stage.clone(), options.stream(1));
        (0..count).map(move |index| stage.draw(stream, index))
    };
    let mut groups = vec![Group::new(POPULATION, draw(stage, tests))?];
    if !options.quick {
        let fewer = tests / 4;
        for (name, cells) in ["coarser meshes", "finer meshes"].into_iter().zip(stage.other_cells) {
            groups.push(Group::new(name, draw(&Stage { cells, ..stage.clone() }, fewer))?);
        }
        if stage.scars > 0 {
            let two = Stage { scars: 2, ..stage.clone() };
            groups.push(Group::new("two infarcts", draw(&two, fewer))?);
        }
        let beyond = Stage { spread: 1.5, ..stage.clone() };
        groups.push(Group::new("1.5 times the spread", draw(&beyond, fewer))?);
        let hearts = stage.hearts(&options.hearts)?;
        if !hearts.is_empty() {
            groups.push(Group::new("a person's heart", hearts.into_iter().map(Ok))?);
        }
    }
    Ok(groups)
}

fn expanded(options: &Options, stage: &Stage, groups: &[Group], study: &mut Study) -> Result<()> {
    let about = "the same body on a mesh of few cells, by moving least squares";
    study.outcomes.push(groups[0].measure(["coarse solution", about], 0.0, |individual| {
        Ok(coarse(stage, individual)?.unwrap_or_else(|| individual.rest()))
    })?);
    for group in groups {
        one_stiffness(stage, group, study)?;
        series(options, group, study)?;
    }
    Ok(())
}

/// Quasi-Newton steps that predictions are refined by, and that the stiffness of one body is given for others.
const REFINED: usize = 4;
const FROM_ANOTHER: [usize; 2] = [16, 32];

/// The answer after quasi-Newton steps.
fn after(emulator: &Emulator<'_>, theta: &[f64], steps: usize) -> Result<Vec<f64>> {
    Ok(emulator.refine(&[theta.to_vec()], steps)?.displacement)
}

const TAYLOR: &str = "Taylor expansion";

fn refined(method: &str) -> String {
    format!("{method}, {REFINED} quasi-Newton steps")
}

/// The mean body of the population, on the mesh of a group.
fn one_stiffness(stage: &Stage, group: &Group, study: &mut Study) -> Result<()> {
    let Some(mean) = stage.mean_like(&group.individuals[0].body)? else { return Ok(()) };
    let stiffness = FrozenStiffness::new(&mean)?;
    for steps in FROM_ANOTHER {
        let name = format!("frozen stiffness, {steps} steps");
        let about = "from solution and stiffness of the mean body, one solve in all";
        study.outcomes.push(group.measure([&name, about], 0.0, |individual| {
            Ok(stiffness.descend(&individual.body, &individual.theta, steps)?.displacement)
        })?);
    }
    Ok(())
}

/// One solve of each body, followed, and refined with its stiffness.
fn series(options: &Options, group: &Group, study: &mut Study) -> Result<()> {
    let about = "Taylor expansion of second order about one solve";
    for (name, steps) in [(TAYLOR.into(), 0), (refined(TAYLOR), REFINED)] {
        study.outcomes.push(group.measure([&name, about], 0.0, |individual| {
            let emulator = Emulator::taylor(&individual.body, options.seed)?;
            after(&emulator, &individual.theta, steps)
        })?);
    }
    if group.name == POPULATION {
        let body = &group.individuals[0].body;
        let start = std::time::Instant::now();
        let emulator = Emulator::taylor(body, options.seed)?;
        let fact = answers(group, (start, &emulator))?;
        study.facts.push((format!("answers, {TAYLOR}"), fact));
    }
    Ok(())
}

/// Times of the first individual, in words: from `start` until its first answer, for the next, for each of many, plain and refined.
fn answers(group: &Group, (start, met): (std::time::Instant, &Emulator<'_>)) -> Result<String> {
    const MANY: usize = 200;
    let Individual { body, theta, .. } = &group.individuals[0];
    met.predict(std::slice::from_ref(theta))?;
    let first = 1e3 * start.elapsed().as_secs_f64();
    let time = |count: usize, steps: usize| -> Result<f64> {
        let thetas = vec![theta.clone(); count];
        let start = std::time::Instant::now();
        met.refine(&thetas, steps)?;
        Ok(1e3 * start.elapsed().as_secs_f64() / count as f64)
    };
    let (next, many) = (time(1, 0)?, time(MANY, 0)?);
    // The stiffness is factorised with the first.
    time(1, REFINED)?;
    let fine = time(MANY, REFINED)?;
    Ok(format!(
        "{} nodes: the first after {first:.0} ms, the next after {next:.2} ms, {many:.2} ms each of {MANY} together, {fine:.1} ms with {REFINED} quasi-Newton steps; {} threads",
        body.nodes,
        rayon::current_num_threads()
    ))
}
