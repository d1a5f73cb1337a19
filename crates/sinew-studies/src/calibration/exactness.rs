//! Posteriors against brute force, with a bad emulator beside.

use super::options::{Options, listing, row};
use super::reference::Reference;
use crate::calibration::coverage::{self, Synthetic};
use crate::program;
use anyhow::{Result, anyhow};
use sinew::Prepared;
use sinew_calibrate::{
    CalibrateError, CalibrateOptions, Patient, Solves, calibrate, check_identifiability,
};
use sinew_report::{Block, Cell, Section};

/// Cells of the patient with two unknown parameters, points of the grid along each, and draws that are compared.
const GRID: ([usize; 3], usize, usize) = ([2, 16, 8], 50, 2400);
const QUICK_GRID: ([usize; 3], usize, usize) = ([2, 8, 5], 16, 800);
/// Patients, solves of importance sampling for each, and draws that are compared.
const IMPORTANCE: (u64, usize, usize) = (3, 20_000, 4800);
const QUICK_IMPORTANCE: (u64, usize, usize) = (1, 300, 240);
const HEAD: [&str; 8] = [
    "total variation",
    "error of means [sd]",
    "error of sds",
    "k̂",
    "share",
    "accepted",
    "solves",
    "time [s]",
];

/// Two parameters against a grid of solves.
pub(super) fn grid(options: &Options) -> Result<Section> {
    let (cells, points, draws) = if options.quick { QUICK_GRID } else { GRID };
    let patient = coverage::of_two(options.seed, cells)?;
    let prepared = patient.file.prepare()?;
    let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
    let file = options.out.join("grid.json");
    let reference = program::kept(&file, options.resume, || {
        Ok(Reference::grid(&prepared.problem, &model, points))
    })?;
    let text = said(&format!("{points} × {points} solves on a grid"), &prepared, &reference);
    let good = settings(options, draws);
    // Few points, straight lines: the first round alone shows it, five correct or refuse it.
    let bad = CalibrateOptions { starts: 1, design: 12, degree: 1, ..good };
    let cases = [
        ("emulator as it is", good),
        ("12 points, degree 1, one round", CalibrateOptions { rounds: 1, ..bad }),
        ("12 points, degree 1", bad),
    ];
    let compare = |(name, settings)| compared(name, &prepared, &model, &settings, &reference);
    let rows = cases.into_iter().map(compare).collect::<Result<_>>()?;
    Ok(section("grid", "Two parameters against a grid", vec![text], rows))
}

/// Four parameters against importance sampling.
pub(super) fn importance(options: &Options) -> Result<Section> {
    let (patients, solves, draws) = if options.quick { QUICK_IMPORTANCE } else { IMPORTANCE };
    let (mut texts, mut rows) = (Vec::new(), Vec::new());
    for number in 0..patients {
        let (Synthetic { file, .. }, _) = coverage::random(options.seed, number)?;
        let prepared = file.prepare()?;
        let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
        let problem = &prepared.problem;
        let at = options.out.join(format!("importance-{number}.json"));
        let reference = program::kept(&at, options.resume, || {
            let mut search = Solves::new(&model);
            let (mode, _) = check_identifiability(problem, &mut search)?;
            Reference::importance(problem, &model, &mode, solves, options.seed)
        })?;
        let name = format!("patient {number}");
        let what = format!("{name}: {solves} solves of importance sampling");
        texts.push(said(&what, &prepared, &reference));
        rows.push(compared(&name, &prepared, &model, &settings(options, draws), &reference)?);
    }
    Ok(section("importance", "Four parameters against importance sampling", texts, rows))
}

fn settings(options: &Options, draws: usize) -> CalibrateOptions {
    CalibrateOptions { seed: options.seed, draws, steps: 2 * draws, ..CalibrateOptions::default() }
}

fn said(what: &str, prepared: &Prepared, reference: &Reference) -> String {
    let Reference { failed, share, seconds, .. } = reference;
    let nodes = prepared.body.nodes;
    let text = format!(
        "{what} on {nodes} nodes, {failed} without an answer, effective share {share:.3}, {seconds:.0} s."
    );
    println!("{text}");
    text
}

fn section(name: &str, title: &str, texts: Vec<String>, rows: Vec<Vec<Cell>>) -> Section {
    let listing = listing("Largest distances over the parameters", "posterior", &HEAD, rows);
    Section { name: name.into(), title: title.into(), blocks: vec![Block::List(texts), listing] }
}

fn compared(
    name: &str,
    prepared: &Prepared,
    model: &Patient,
    settings: &CalibrateOptions,
    reference: &Reference,
) -> Result<Vec<Cell>> {
    let mut solves = Solves::new(model);
    let (name, distance, c) = match calibrate(&prepared.problem, &mut solves, settings) {
        Ok(found) => (name.to_string(), reference.distance(&found), found.correction),
        Err(CalibrateError::Unconfirmed(c)) => (format!("{name}: refused"), [f64::NAN; 3], *c),
        Err(other) => return Err(other.into()),
    };
    let [variation, means, deviations] = distance;
    let accepted = if variation.is_nan() { f64::NAN } else { c.acceptance };
    let solves = c.solves as f64;
    let numbers = [variation, means, deviations, c.k_hat, c.share, accepted, solves, c.seconds];
    Ok(row(&name, &HEAD, &numbers))
}
