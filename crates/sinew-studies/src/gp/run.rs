//! Works off the chosen experiments and writes their report.

use crate::gp::experiment::{Experiment, Scale, Task, derived};
use crate::gp::experiments::Name;
use crate::gp::report::section;
use crate::gp::row::{Row, Run};
use crate::gp::workers;
use crate::program::{self, Growing};
use anyhow::{Context, Result, ensure};
use clap::{Parser, ValueEnum};
use serde::{Deserialize, Serialize};
use sinew_emulate::{Counter, Terminal};
use sinew_report::Section;
use std::path::PathBuf;
use std::sync::Mutex;

/// Result of one fit, as it is stored.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Outcome {
    Done(Box<Run>),
    /// The reason why there is no result: part of the result, too.
    Failed(String),
}

/// Options and revision that a run began with, kept in its folder.
#[derive(Serialize, Deserialize)]
struct Beginning {
    options: Options,
    revision: String,
}

/// Runs `reproduce-gp` and writes its report; the path of `report.html`.
///
/// # Errors
/// Whatever keeps the report from being made: options that contradict an interrupted run, problems that cannot
/// be set up, files that cannot be written. A fit that fails is told in the report.
pub fn reproduce_gp(options: &Options) -> Result<PathBuf> {
    let names = [
        "Boundary conditions built in: Gaussian processes and networks",
        "The experiments of chapter 4 and §1.7.3 of the thesis, beside the figures it prints.",
    ];
    let mut growing = Growing::new(names, (options.seed, options.quick), options, |report| {
        let [all, met] = report.verdicts();
        format!("{met} of {all} errors that the thesis prints are met or bettered.")
    })?;
    let provenance = &mut growing.report.provenance;
    provenance.threads = options.threads();
    let earlier = begin(options, &provenance.revision)?;
    growing.report.notes = notes(options, &provenance.revision, &earlier);
    growing.report.definitions = program::definitions(DEFINITIONS);
    let scale = Scale { quick: options.quick };
    let experiments: Vec<(Name, Experiment)> = Name::chosen(&options.only)
        .into_iter()
        .map(|name| Ok((name, name.experiment(scale)?)))
        .collect::<Result<_>>()?;
    let outcomes = outcomes(options, &experiments)?;
    let mut sections = Vec::new();
    for ((name, experiment), outcomes) in experiments.into_iter().zip(outcomes) {
        sections.extend(gather(name, experiment, outcomes, &mut growing.report.notes)?);
    }
    let mut page = None;
    for section in sections {
        page = Some(growing.add(section, &options.out)?);
    }
    let notes = growing.report.notes.join("\n");
    let page = page.with_context(|| format!("no experiment has a result\n{notes}"))?;
    eprintln!("\n{}", growing.report.headline);
    Ok(page)
}

/// Prepares the output folder: empties it of an earlier run, or sees to it that the earlier run can be continued; the revision
/// that it was begun with.
fn begin(options: &Options, revision: &str) -> Result<String> {
    let folders: Vec<String> = Name::value_variants().iter().map(|name| name.key()).collect();
    let beginning = Beginning { options: options.clone(), revision: revision.into() };
    let stored = program::begin_in(&options.out, &folders, options.resume, &beginning)?;
    let Beginning { options: earlier, revision } = stored.unwrap_or(beginning);
    // More data sets or other experiments may be added; what a stored fit means must not change.
    ensure!(
        (earlier.seed, earlier.quick) == (options.seed, options.quick),
        "the run in {} was started with --seed {}{}; repeat that, or start without --resume",
        options.out.display(),
        earlier.seed,
        if earlier.quick { " --quick" } else { "" }
    );
    Ok(revision)
}

fn notes(options: &Options, revision: &str, earlier: &str) -> Vec<String> {
    let threads = options.threads();
    let mut notes = vec![
        format!(
            "Seconds are those of one fit on one thread: prior, model and all restarts, without the evaluation of \
             errors. {threads} fits ran side by side, so that each may be a little slower than alone."
        ),
        "The thesis' figures are of one data set each; ours are medians over data sets, with the range from the \
         least to the largest beside them. Nothing is filtered: collapsed fits count."
            .to_string(),
        "A figure counts as met if our median, in two digits, is not above the thesis'. For θ the thesis' error is \
         that of the printed number and half of its last digit."
            .to_string(),
    ];
    if revision != earlier {
        notes.push(format!(
            "Continued: the run was started with revision {earlier} of the source, some fits are of that."
        ));
    }
    notes
}

/// One fit to be done: numbers of experiment, case and data set.
#[derive(Clone, Copy)]
struct Piece {
    experiment: usize,
    case: usize,
    set: usize,
}

/// Outcomes of the data sets of each experiment and each case. A resumed run reads those stored before; the others run now, each
/// on one thread.
fn outcomes(
    options: &Options,
    experiments: &[(Name, Experiment)],
) -> Result<Vec<Vec<Vec<Outcome>>>> {
    let mut pieces = Vec::new();
    for (experiment, (_, content)) in experiments.iter().enumerate() {
        for set in 0..options.seeds() {
            let cases = 0..content.cases.len();
            pieces.extend(cases.map(|case| Piece { experiment, case, set }));
        }
    }
    let case = |piece: &Piece| &experiments[piece.experiment].1.cases[piece.case];
    let mut terminal = Terminal::default();
    let counter = Mutex::new(Counter::new(&mut terminal, "fits", 0, pieces.len()));
    let done = workers::each(options.threads(), &pieces, |piece| {
        let name = experiments[piece.experiment].0.key();
        let folder = options.out.join(&name).join(case(piece).key());
        let file = folder.join(format!("{:04}.json", piece.set));
        let seed = derived(options.seed, piece.set as u64);
        let task = Task { seed, draw: piece.set == 0 };
        let outcome = program::kept(&file, options.resume, || {
            Ok(match (case(piece).run)(&task).and_then(|run| Ok(run.checked()?)) {
                Ok(run) => Outcome::Done(Box::new(run)),
                Err(error) => Outcome::Failed(format!("{error:#}")),
            })
        })?;
        let _ = counter.lock().unwrap_or_else(|e| e.into_inner()).step(1, &name);
        Ok(outcome)
    })?;
    counter
        .into_inner()
        .unwrap_or_else(|e| e.into_inner())
        .finish(&format!("{} fits", pieces.len()));
    let mut sorted: Vec<Vec<Vec<Outcome>>> =
        experiments.iter().map(|(_, all)| vec![Vec::new(); all.cases.len()]).collect();
    for (piece, outcome) in pieces.into_iter().zip(done) {
        sorted[piece.experiment][piece.case].push(outcome);
    }
    Ok(sorted)
}

/// Rows and drawings of one experiment; cases without any result go to the notes.
fn gather(
    name: Name,
    experiment: Experiment,
    outcomes: Vec<Vec<Outcome>>,
    notes: &mut Vec<String>,
) -> Result<Option<Section>> {
    let (mut rows, mut figures) = (Vec::new(), Vec::new());
    for (case, outcomes) in experiment.cases.into_iter().zip(outcomes) {
        let (mut runs, mut failures) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                Outcome::Done(run) => runs.push(*run),
                Outcome::Failed(reason) => failures.push(reason),
            }
        }
        figures.extend(runs.iter_mut().flat_map(|run| std::mem::take(&mut run.figures)));
        let label = case.label;
        let what = format!("{} {} {}", label.problem, label.method.label(), label.setting);
        let reason = failures.first().cloned().unwrap_or_default();
        match Row::of(label, runs, failures) {
            Some(row) => rows.push(row),
            None => notes.push(format!("{}: no result. {reason}", what.trim_end())),
        }
    }
    figures.extend(name.figure(&rows));
    if rows.is_empty() {
        return Ok(None);
    }
    Ok(Some(section(name.key(), experiment.title, experiment.about, &rows, figures)?))
}

const DEFINITIONS: [(&str, &str); 3] = [
    (
        "HCGP, PCGP, UCGP",
        "Gaussian process with the boundary conditions built in, with N_b pseudo-observations of them, without them",
    ),
    ("HCNN", "neural network with the boundary conditions built in"),
    (
        "noise floor",
        "least squares for θ alone with the exact solutions of the equation, on the same values: what no method that \
         knows but equation and conditions can be expected to beat on average",
    ),
];

/// Repeat the thesis' experiments with Gaussian processes and networks that satisfy boundary conditions exactly
/// (§4.8), and its first physics-informed network (§1.7.3), beside the figures it prints.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-gp", version, max_term_width = 110)]
pub struct Options {
    /// Experiments to run, separated by commas [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub only: Vec<Name>,
    /// Same code with one data set, few starts and steps, within half a minute: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Data sets behind every median [default: 10, or 1 with --quick]
    #[arg(long, value_parser = parse_count)]
    pub seeds: Option<usize>,
    /// Number of fits at the same time, each on one thread [default: number of processors]
    #[arg(long, value_parser = parse_count)]
    #[serde(skip)]
    pub threads: Option<usize>,
    /// Folder for the report and the results of single fits
    #[arg(long, default_value = "out/reproduce-gp")]
    pub out: PathBuf,
    /// Keep the fits in the output folder, and run the missing ones
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

impl Options {
    /// Data sets behind every median.
    pub(crate) fn seeds(&self) -> usize {
        self.seeds.unwrap_or(if self.quick { 1 } else { 10 })
    }

    /// Fits side by side.
    pub(crate) fn threads(&self) -> usize {
        self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
    }
}

fn parse_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err(format!("`{text}` is not a count: write a whole number from 1 on")),
    }
}
