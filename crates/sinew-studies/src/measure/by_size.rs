//! Cost of preparation and of an answer by the size of a body, beside a sweep of the solver, with the true errors of the answers.

use super::mean_ventricle::{BULK_MODULUS, THETA, ventricle};
use crate::program::{cpu_seconds, peak_kb};
use anyhow::Result;
use clap::ValueEnum;
use sinew_emulate::{Answers, Design, Emulator};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Scene, Support, metrics::mean_and_largest};
use sinew_fem::{CHAIN, Method, Options, Solver, sweep};
use sinew_mesh::box_tetrahedra;
use sinew_num::difference;
use std::sync::{Mutex, PoisonError};

const SEED: u64 = 7;

fn block(cells: [usize; 3]) -> Result<Body> {
    let scene = Scene::new(box_tetrahedra([60.0, 30.0, 30.0], cells), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=5.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=20.0))
        .load(Load::BodyForce([3e-3, 0.0, -9.8e-3])) // kPa/mm
        .support(Support::clamped("x_min"));
    Ok(scene.lower()?)
}

/// Largest resident memory of this process so far \[GB\], where the system tells it.
pub(super) fn peak_gb() -> f64 {
    peak_kb().map_or(f64::NAN, |kb| kb / 1e6)
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    /// Cells through the wall, around and along
    Ventricle,
    /// Cells along x, y and z
    Block,
}

/// Seconds are of the CPU: set RAYON_NUM_THREADS=1. Such as `ventricle 20 1e-3 20 2,32,16 4,64,34`.
#[derive(clap::Args)]
pub struct Arguments {
    body: Kind,
    /// Parameter sets
    sets: usize,
    /// Relative error of answers
    accuracy: f64,
    /// Sets that are solved too, two at least; a sweep of all is extrapolated
    solved: usize,
    /// Cells of each body, such as 2,32,16
    #[arg(required = true, value_parser = three)]
    cells: Vec<[usize; 3]>,
}

pub(super) fn three(text: &str) -> Result<[usize; 3]> {
    let parts: Vec<usize> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    parts.try_into().map_err(|_| anyhow::anyhow!("cells are three numbers"))
}

/// Prints a line for each size.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { body, sets, accuracy, solved, cells } = arguments;
    let sets = (*sets).max(2);
    println!(
        "nodes, unknowns: prepare; an answer, a solve near another; preparation and all answers beside a sweep; true errors; memory"
    );
    for &cells in cells {
        let body = match body {
            Kind::Ventricle => ventricle(cells, BULK_MODULUS, false)?,
            Kind::Block => block(cells)?,
        };
        measure(&body, (sets, *accuracy, (*solved).clamp(2, sets)))?;
    }
    Ok(())
}

fn measure(body: &Body, (sets, accuracy, solved): (usize, f64, usize)) -> Result<()> {
    let thetas = Design::LatinHypercube.sample(&body.parameters, sets, SEED)?;
    let start = cpu_seconds();
    let clock = Mutex::new(Vec::new());
    let solved_one = || {
        let mut clock = clock.lock().unwrap_or_else(PoisonError::into_inner);
        clock.push(cpu_seconds() - start);
        eprintln!("{} nodes: {} of {solved} sets are solved", body.nodes, clock.len());
    };
    let found = sweep(body, &thetas[..solved], &Options::default(), solved_one)?;
    let clock = clock.into_inner().unwrap_or_else(PoisonError::into_inner);
    // Each chain of neighbours begins from rest.
    let (near, chains) = (solved.min(CHAIN), sets.div_ceil(CHAIN));
    let near_s = (clock[near - 1] - clock[0]) / (near - 1) as f64;
    let sweep_s = clock[0] * chains as f64 + near_s * (sets - chains) as f64;
    let start = cpu_seconds();
    let expansion = Emulator::taylor(body, 1)?;
    let prepare_s = cpu_seconds() - start;
    eprintln!("{} nodes: the expansion is prepared", body.nodes);
    let start = cpu_seconds();
    let answers = Answers::to(body, &thetas, accuracy, Some(&expansion), &mut ())?;
    let answers_s = cpu_seconds() - start;
    let total_s = prepare_s + answers_s;
    let (mut errors, mut steps, mut missed) = (Vec::new(), 0, 0);
    for answer in answers.answers.iter() {
        match answer {
            Ok(answer) if answer.is_within(accuracy) => steps += answer.steps,
            _ => missed += 1,
        }
    }
    for (truth, answer) in found.iter().zip(&answers.answers) {
        let (Ok(truth), Ok(answer)) = (truth, answer) else { continue };
        let apart = difference(&truth.displacement, &answer.displacement);
        errors.push(mean_and_largest(&apart)[0] / mean_and_largest(&truth.displacement)[0]);
    }
    errors.sort_by(f64::total_cmp);
    let beyond = errors.iter().filter(|error| **error > accuracy).count();
    println!(
        "{} nodes, {} unknowns: {prepare_s:.2} s; {:.2} s, {near_s:.2} s; {total_s:.1} s for {sweep_s:.1} s, {:.3}; median {:.1e}, largest {:.1e}, \
         {beyond} of {} beyond {accuracy:e}, {missed} not answered; {:.2} Newton steps each, by {}; {:.2} GB, {} threads",
        body.nodes,
        body.free_degrees_of_freedom().len(),
        answers_s / sets as f64,
        total_s / sweep_s,
        errors[errors.len() / 2],
        errors[errors.len() - 1],
        errors.len(),
        steps as f64 / sets as f64,
        answers.plan.method().name(),
        peak_gb(),
        rayon::current_num_threads()
    );
    Ok(())
}

/// Seconds are of the CPU: set RAYON_NUM_THREADS=1.
#[derive(clap::Args)]
pub struct SizeArguments {
    /// Bulk modulus in kPa
    #[arg(long, default_value_t = 25.0)]
    bulk_modulus: f64,
    /// Averaged volume ratios
    #[arg(long)]
    averaged: bool,
    /// A factor of each stiffness, whatever the size
    #[arg(long)]
    factor: bool,
    /// Cells of each body, such as 4,48,40: 9005 nodes; 6,72,60: 28 231; 10,112,88: 100 419; 14,160,130: 289 215
    #[arg(required = true, value_parser = three)]
    cells: Vec<[usize; 3]>,
}

/// Prints a line for each size.
pub(super) fn run_size(arguments: &SizeArguments) -> Result<()> {
    let SizeArguments { bulk_modulus, averaged, factor, cells } = arguments;
    let method = if *factor { Method::Factor } else { Method::Automatic };
    for &cells in cells {
        let start = cpu_seconds();
        let body = ventricle(cells, *bulk_modulus, *averaged)?;
        let mut solver = Solver::new(&body)?;
        let prepared = cpu_seconds();
        let found = solver.solve(&THETA, &Options { method, ..Options::default() })?;
        println!(
            "{} nodes: prepared in {:.1} s, solved in {:.1} s; {} iterations, {} of conjugate gradients; energy {:.14e}; \
             {} negative eigenvalues{}; {:.2} GB",
            body.nodes,
            prepared - start,
            cpu_seconds() - prepared,
            found.iterations(),
            found.linear_iterations,
            found.energy,
            found.negative_pivots,
            if found.counted { "" } else { ", not counted" },
            peak_gb(),
        );
    }
    Ok(())
}
