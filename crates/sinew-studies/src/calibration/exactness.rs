//! Posteriors against brute force, with a bad emulator and adaptive Metropolis beside.
//!
//! Adaptive Metropolis on the solver: H. Haario, E. Saksman and J. Tamminen (Bernoulli, 2001).

use super::options::{Options, listing, row};
use super::reference::{Reference, weight};
use super::{coverage, reference};
use crate::calibration::coverage::Synthetic;
use crate::program;
use anyhow::{Result, anyhow};
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::Prepared;
use sinew_calibrate::{
    CalibrateError, CalibrateOptions, Forward, Mode, Patient, Problem, Solves, calibrate,
    check_identifiability,
};
use sinew_report::{Block, Cell, Section};
use sinew_sample::{ess_bulk, ess_tail, split_seed, standard_normals};
use std::time::Instant;

/// Cells of the patient with two unknown parameters, points of the grid along each, and draws that are compared.
const GRID: ([usize; 3], usize, usize) = ([2, 16, 8], 50, 2400);
const QUICK_GRID: ([usize; 3], usize, usize) = ([2, 8, 5], 16, 800);
/// Patients, solves of importance sampling for each, and draws that are compared.
const IMPORTANCE: (u64, usize, usize) = (3, 20_000, 4800);
const QUICK_IMPORTANCE: (u64, usize, usize) = (1, 300, 240);
/// Solves that adaptive Metropolis has.
const CHAIN: usize = 2000;
const QUICK_CHAIN: usize = 300;
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
        let (Synthetic { file, .. }, _) = coverage::random(options.seed, number, None)?;
        let prepared = file.prepare()?;
        let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
        let problem = &prepared.problem;
        let at = options.out.join(format!("importance-{number}.json"));
        let reference = program::kept(&at, options.resume, || {
            let mut search = Solves::new(&model, Box::new(|_, _, _| ()));
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
    let mut solves = Solves::new(model, Box::new(|_, _, _| ()));
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

/// Effective draws a solve, ours and those of adaptive Metropolis on the solver.
pub(super) fn rival(options: &Options) -> Result<Section> {
    const HEAD: [&str; 5] = ["bulk ESS", "tail ESS", "solves", "bulk ESS a solve", "time [s]"];
    let ((cells, ..), steps) =
        if options.quick { (QUICK_GRID, QUICK_CHAIN) } else { (GRID, CHAIN) };
    let patient = coverage::of_two(options.seed, cells)?;
    let prepared = patient.file.prepare()?;
    let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
    let settings = CalibrateOptions { seed: options.seed, ..CalibrateOptions::default() };
    let mut solves = Solves::new(&model, Box::new(|_, _, _| ()));
    let posterior = calibrate(&prepared.problem, &mut solves, &settings)?;
    let [_, bulk, tail] = posterior.coordinates.mixing();
    let c = &posterior.correction;
    let clock = Instant::now();
    let (chain, made) = chain(&prepared.problem, &model, &posterior.mode, steps, options.seed);
    let of = |ess: fn(&[Vec<f64>]) -> f64| {
        let parameter = |at: usize| vec![chain.iter().map(|y| y[at]).collect::<Vec<f64>>()];
        (0..2).map(|at| ess(&parameter(at))).fold(f64::INFINITY, f64::min)
    };
    let of_method = |name: &str, [bulk, tail]: [f64; 2], solves: usize, seconds: f64| {
        let solves = solves as f64;
        row(name, &HEAD, &[bulk, tail, solves, bulk / solves, seconds])
    };
    let rows = vec![
        of_method("emulator with correction", [bulk, tail], c.solves, c.seconds),
        of_method(
            "adaptive Metropolis",
            [of(ess_bulk), of(ess_tail)],
            made,
            clock.elapsed().as_secs_f64(),
        ),
    ];
    let title = "Effective draws a solve; adaptive Metropolis (Haario et al. 2001) starts at the mode with the Laplace covariance";
    let blocks = vec![listing(title, "method", &HEAD, rows)];
    Ok(Section { name: "rival".into(), title: "Adaptive Metropolis beside".into(), blocks })
}

/// Steps between two updates of the proposals' covariance.
const EVERY: usize = 50;
/// Steps that are not kept.
const BURN_IN: usize = 100;
/// Added to variances, so that they stay positive.
const NUGGET: f64 = 1e-6;
const STREAM: u64 = 0x414d;

/// A chain of coordinates that starts at a mode with proposals of its covariance, and the solves that it made.
pub(super) fn chain(
    problem: &Problem,
    model: &dyn Forward,
    mode: &Mode,
    steps: usize,
    seed: u64,
) -> (Vec<Vec<f64>>, usize) {
    let count = problem.unknowns.len();
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(seed, STREAM));
    let density = |y: &[f64]| weight(problem, model, y).unwrap_or(f64::NEG_INFINITY);
    // The best scale of a normal target in so many dimensions (Gelman, Roberts and Gilks, 1996).
    let scale = 2.38 * 2.38 / count as f64;
    let mut covariance = reference::covariance(mode);
    let mut now = mode.y[..count].to_vec();
    let mut height = density(&now);
    let mut all = vec![now.clone()];
    for step in 0..steps {
        if step >= BURN_IN && step % EVERY == 0 {
            covariance = of(&all);
        }
        let Some(factor) = Cholesky::new(scale * &covariance) else { break };
        let z = DVector::from_vec(standard_normals(count, &mut random));
        let moved = factor.l() * z;
        let next: Vec<f64> = now.iter().zip(moved.iter()).map(|(y, d)| y + d).collect();
        let other = density(&next);
        if random.random::<f64>().ln() < other - height {
            (now, height) = (next, other);
        }
        all.push(now.clone());
    }
    (all[BURN_IN.min(all.len() - 1)..].to_vec(), steps + 1)
}

fn of(all: &[Vec<f64>]) -> DMatrix<f64> {
    let (count, draws) = (all[0].len(), all.len() as f64);
    let mean = |at: usize| all.iter().map(|y| y[at]).sum::<f64>() / draws;
    let means: Vec<f64> = (0..count).map(mean).collect();
    DMatrix::from_fn(count, count, |i, j| {
        let sum: f64 = all.iter().map(|y| (y[i] - means[i]) * (y[j] - means[j])).sum();
        sum / (draws - 1.0) + if i == j { NUGGET } else { 0.0 }
    })
}
