//! Two parameters against a grid of solves, a bad emulator, and adaptive Metropolis beside.

use crate::metropolis;
use crate::options::Options;
use crate::patients;
use anyhow::{Result, anyhow};
use rayon::prelude::*;
use sinew::Prepared;
use sinew_calibrate::{
    CalibrateError, CalibrateOptions, Forward, Patient, Posterior, Solves, calibrate,
};
use sinew_report::{Block, Cell, Section};
use sinew_sample::{ess_bulk, ess_tail};
use std::time::Instant;

/// Cells, points of the grid along each parameter, and draws that are compared.
const FULL: ([usize; 3], usize, usize) = ([2, 12, 6], 50, 2400);
const QUICK: ([usize; 3], usize, usize) = ([2, 8, 5], 16, 800);
/// Bins of equal probability for the total variation: so many draws leave about .02.
const BINS: usize = 12;
/// Solves that adaptive Metropolis has.
const CHAIN: usize = 2000;
const QUICK_CHAIN: usize = 300;

/// Marginal probabilities of a and a_f on a grid over the logarithms.
struct Grid {
    marginals: [Vec<f64>; 2],
    seconds: f64,
    failed: usize,
}

pub(crate) fn sections(options: &Options) -> Result<Vec<Section>> {
    let (cells, points, draws) = if options.quick { QUICK } else { FULL };
    let patient = patients::of_two(options.seed, cells)?;
    let prepared = patient.file.prepare()?;
    let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
    println!("exactness: {} nodes, grid of {points} × {points} solves", prepared.body.nodes);
    let grid = brute_force(&prepared, &model, points);
    println!("grid: {:.0} s, {} solves without an answer", grid.seconds, grid.failed);
    let good = CalibrateOptions {
        seed: options.seed,
        draws,
        steps: 2 * draws,
        ..CalibrateOptions::default()
    };
    // Few points, straight lines: the first round alone shows it, five correct or refuse it.
    let bad = CalibrateOptions { starts: 1, design: 12, degree: 1, ..good };
    let mut rows = Vec::new();
    for (name, settings) in [
        ("emulator as it is", good),
        ("12 points, degree 1, one round", CalibrateOptions { rounds: 1, ..bad }),
        ("12 points, degree 1", bad),
    ] {
        rows.push(compared(name, &prepared, &model, &settings, &grid)?);
    }
    let head = [
        "posterior",
        "total variation of a",
        "of a_f",
        "error of means [sd]",
        "error of sds",
        "k̂",
        "share",
        "accepted",
        "solves",
        "time [s]",
    ];
    let text = format!(
        "a and a_f of a ventricle of {} nodes are unknown. A grid of {points} × {points} solves gives the marginals by brute force, in {:.0} s.",
        prepared.body.nodes, grid.seconds
    );
    let exact = Section {
        name: "exactness".into(),
        title: "Against brute force".into(),
        blocks: vec![
            Block::Text(text),
            Block::Listing {
                title: "Distances from the grid".into(),
                head: head.map(String::from).to_vec(),
                rows,
            },
        ],
    };
    Ok(vec![exact, rival(options, &prepared, &model)?])
}

fn brute_force(prepared: &Prepared, model: &Patient, points: usize) -> Grid {
    let clock = Instant::now();
    let problem = &prepared.problem;
    let logs: Vec<[f64; 2]> =
        problem.unknowns.iter().map(|u| u.prior.range().map(f64::ln)).collect();
    let at = |parameter: usize, cell: usize| {
        let [low, high] = logs[parameter];
        (low + (high - low) * (cell as f64 + 0.5) / points as f64).exp()
    };
    let solve = |number: usize| {
        let theta = [at(0, number / points), at(1, number % points)];
        let seen = model.observe(&theta, false).ok()?.values;
        let misfit =
            |d: &sinew_calibrate::Datum| ((d.value - seen[d.observable]) / d.deviation).powi(2);
        Some(-0.5 * problem.data.iter().map(misfit).sum::<f64>())
    };
    let found: Vec<Option<f64>> = (0..points * points).into_par_iter().map(solve).collect();
    let most = found.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut marginals = [vec![0.0; points], vec![0.0; points]];
    for (number, height) in found.iter().enumerate() {
        let weight = height.map_or(0.0, |height| (height - most).exp());
        marginals[0][number / points] += weight;
        marginals[1][number % points] += weight;
    }
    for marginal in &mut marginals {
        let sum: f64 = marginal.iter().sum();
        marginal.iter_mut().for_each(|p| *p /= sum);
    }
    let failed = found.iter().filter(|height| height.is_none()).count();
    Grid { marginals, seconds: clock.elapsed().as_secs_f64(), failed }
}

fn compared(
    name: &str,
    prepared: &Prepared,
    model: &Patient,
    settings: &CalibrateOptions,
    grid: &Grid,
) -> Result<Vec<Cell>> {
    let mut solves = Solves::new(model, Box::new(|_, _, _| ()));
    match calibrate(&prepared.problem, &mut solves, settings) {
        Ok(posterior) => {
            let found = [0, 1].map(|at| distances(&posterior, at, &grid.marginals[at]));
            let c = &posterior.correction;
            let means = found[0][1].max(found[1][1]);
            let deviations = found[0][2].max(found[1][2]);
            println!(
                "{name}: total variation {:.3} and {:.3}, means {means:.3} sd, sds {deviations:.3}, k̂ {:.2}, share {:.3}, error {:.2} sd, accepted {:.3}, {} solves in {} rounds, {:.0} s",
                found[0][0],
                found[1][0],
                c.k_hat,
                c.share,
                c.largest_error,
                c.acceptance,
                c.solves,
                c.rounds,
                c.seconds
            );
            let numbers = [
                found[0][0],
                found[1][0],
                means,
                deviations,
                c.k_hat,
                c.share,
                c.acceptance,
                c.solves as f64,
                c.seconds,
            ];
            Ok(std::iter::once(Cell::from(name)).chain(numbers.map(Cell::from)).collect())
        }
        Err(CalibrateError::Unconfirmed(c)) => {
            println!(
                "{name}: refused, k̂ {:.2}, share {:.3}, error {:.2} sd, {} solves in {} rounds, {:.0} s",
                c.k_hat, c.share, c.largest_error, c.solves, c.rounds, c.seconds
            );
            let mut row = vec![Cell::from(format!("{name}: refused"))];
            row.extend((0..4).map(|_| Cell::default()));
            row.extend([c.k_hat, c.share].map(Cell::from));
            row.push(Cell::default());
            row.extend([c.solves as f64, c.seconds].map(Cell::from));
            Ok(row)
        }
        Err(other) => Err(other.into()),
    }
}

/// Total variation over bins of equal probability, and the errors of mean and standard deviation \[sd\].
fn distances(posterior: &Posterior, parameter: usize, exact: &[f64]) -> [f64; 3] {
    let points = exact.len();
    let [low, high] = posterior.problem.unknowns[parameter].prior.range().map(f64::ln);
    let places: Vec<f64> = posterior
        .draws
        .parameter(parameter)
        .concat()
        .iter()
        .map(|theta| (theta.ln() - low) / (high - low) * points as f64)
        .collect();
    let mean: f64 = exact.iter().enumerate().map(|(i, p)| (i as f64 + 0.5) * p).sum();
    // Within a cell the density is even, which adds a twelfth.
    let square: f64 = exact
        .iter()
        .enumerate()
        .map(|(i, p)| ((i as f64 + 0.5 - mean).powi(2) + 1.0 / 12.0) * p)
        .sum();
    let deviation = square.sqrt();
    let count = places.len() as f64;
    let own = places.iter().sum::<f64>() / count;
    let own_square = places.iter().map(|x| (x - own).powi(2)).sum::<f64>() / (count - 1.0);
    let cumulative = |place: f64| {
        let whole = (place.floor().max(0.0) as usize).min(points - 1);
        exact[..whole].iter().sum::<f64>() + exact[whole] * (place - whole as f64)
    };
    let mut bins = [0.0; BINS];
    for place in &places {
        bins[((cumulative(*place) * BINS as f64) as usize).min(BINS - 1)] += 1.0 / count;
    }
    let variation = 0.5 * bins.iter().map(|share| (share - 1.0 / BINS as f64).abs()).sum::<f64>();
    [variation, (own - mean).abs() / deviation, (own_square.sqrt() / deviation - 1.0).abs()]
}

/// Effective draws a solve, ours and those of adaptive Metropolis on the solver.
fn rival(options: &Options, prepared: &Prepared, model: &Patient) -> Result<Section> {
    let settings = CalibrateOptions { seed: options.seed, ..CalibrateOptions::default() };
    let mut solves = Solves::new(model, Box::new(|_, _, _| ()));
    let posterior = calibrate(&prepared.problem, &mut solves, &settings)?;
    let [_, bulk, tail] = posterior.mixing();
    let c = &posterior.correction;
    let steps = if options.quick { QUICK_CHAIN } else { CHAIN };
    let clock = Instant::now();
    let (chain, made) =
        metropolis::chain(&prepared.problem, model, &posterior.mode, steps, options.seed);
    let seconds = clock.elapsed().as_secs_f64();
    let of = |ess: fn(&[Vec<f64>]) -> f64| {
        let parameter = |at: usize| vec![chain.iter().map(|y| y[at]).collect::<Vec<f64>>()];
        (0..prepared.problem.unknowns.len())
            .map(|at| ess(&parameter(at)))
            .fold(f64::INFINITY, f64::min)
    };
    let theirs = [of(ess_bulk), of(ess_tail)];
    let ratio = (bulk / c.solves as f64) / (theirs[0] / made as f64);
    println!(
        "effective draws a solve: ours {:.3} ({bulk:.0} of {} solves, {:.0} s), adaptive Metropolis {:.3} ({:.0} of {made} solves, {seconds:.0} s), {ratio:.1} times",
        bulk / c.solves as f64,
        c.solves,
        c.seconds,
        theirs[0] / made as f64,
        theirs[0]
    );
    let row = |name: &str, ess: [f64; 2], solves: usize, seconds: f64| {
        let numbers = [ess[0], ess[1], solves as f64, ess[0] / solves as f64, seconds];
        std::iter::once(Cell::from(name)).chain(numbers.map(Cell::from)).collect()
    };
    let head = ["method", "bulk ESS", "tail ESS", "solves", "bulk ESS a solve", "time [s]"];
    let blocks = vec![Block::Listing {
        title: "Effective draws a solve; adaptive Metropolis (Haario et al. 2001) starts at the mode with the Laplace covariance".into(),
        head: head.map(String::from).to_vec(),
        rows: vec![
            row("emulator with correction", [bulk, tail], c.solves, c.seconds),
            row("adaptive Metropolis", theirs, made, seconds),
        ],
    }];
    Ok(Section { name: "rival".into(), title: "Adaptive Metropolis beside".into(), blocks })
}
