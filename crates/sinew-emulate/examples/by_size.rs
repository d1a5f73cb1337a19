//! Cost of preparation and of an answer by the size of a body, beside a sweep of the solver, with the true errors of the answers.
//!
//! `cargo run --example by_size -- BODY SETS ACCURACY SOLVED CELLS...`, such as `ventricle 20 1e-3 20 2,32,16 4,64,34`: a body is
//! `ventricle` (layers, around, along) or `block` (along x, y, z); SOLVED of the sets, two at least, are solved too, and a sweep of all is
//! extrapolated. Seconds are of the CPU: set RAYON_NUM_THREADS=1.

use sinew_emulate::{Answers, Design, Emulator};
use sinew_energy::laws::{HolzapfelOgden, NeoHookean};
use sinew_energy::{Body, Load, Magnitude, Parameter, Scene, Support, metrics::mean_and_largest};
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_fem::{CHAIN, Options, sweep};
use sinew_mesh::{VentricleShape, box_tetrahedra};
use std::error::Error;
use std::sync::{Mutex, PoisonError};

const SEED: u64 = 7;

fn ventricle(cells: [usize; 3]) -> Result<Body, Box<dyn Error>> {
    let mesh = VentricleShape::new(&[])?.tetrahedra(cells)?;
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY)?;
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    let scene = Scene::new(mesh, HolzapfelOgden.nearly_incompressible(25.0)) // K [kPa]
        .directions(frames.iter().map(|&[fibre, _, _]| [fibre]).collect())
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 0.53..=1.33)) // 4 to 10 mmHg
        .load(pressure)
        .support(Support::clamped("base"));
    Ok(scene.lower()?)
}

fn block(cells: [usize; 3]) -> Result<Body, Box<dyn Error>> {
    let scene = Scene::new(box_tetrahedra([60.0, 30.0, 30.0], cells), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=5.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=20.0))
        .load(Load::BodyForce([3e-3, 0.0, -9.8e-3])) // kPa/mm
        .support(Support::clamped("x_min"));
    Ok(scene.lower()?)
}

/// CPU time of this process so far \[s\], where the system tells it: other programs do not change it.
fn cpu_s() -> f64 {
    const TICKS: f64 = 100.0; // per second
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: Vec<f64> = fields.skip(11).take(2).filter_map(|field| field.parse().ok()).collect();
    ticks.iter().sum::<f64>() / TICKS
}

/// Largest resident memory of this process so far \[GB\], where the system tells it.
fn peak_gb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kb = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kb.map_or(f64::NAN, |kb| kb / 1e6)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kind, sets, accuracy, solved, sizes @ ..] = &arguments[..] else {
        return Err(
            "give BODY SETS ACCURACY SOLVED CELLS..., such as ventricle 20 1e-3 20 2,32,16".into(),
        );
    };
    let (sets, accuracy): (usize, f64) = (sets.parse::<usize>()?.max(2), accuracy.parse()?);
    let solved = solved.parse::<usize>()?.clamp(2, sets);
    println!(
        "nodes, unknowns: prepare; an answer, a solve near another; preparation and all answers beside a sweep; true errors; memory"
    );
    for cells in sizes {
        let parts: Vec<usize> = cells.split(',').map(str::parse).collect::<Result<_, _>>()?;
        let cells: [usize; 3] = parts.try_into().map_err(|_| "cells are three numbers")?;
        let body = if kind == "block" { block(cells)? } else { ventricle(cells)? };
        measure(&body, (sets, accuracy, solved))?;
    }
    Ok(())
}

fn measure(
    body: &Body,
    (sets, accuracy, solved): (usize, f64, usize),
) -> Result<(), Box<dyn Error>> {
    let thetas = Design::LatinHypercube.sample(&body.parameters, sets, SEED)?;
    let start = cpu_s();
    let clock = Mutex::new(Vec::new());
    let solved_one = || {
        let mut clock = clock.lock().unwrap_or_else(PoisonError::into_inner);
        clock.push(cpu_s() - start);
        eprintln!("{} nodes: {} of {solved} sets are solved", body.nodes, clock.len());
    };
    let found = sweep(body, &thetas[..solved], &Options::default(), solved_one)?;
    let clock = clock.into_inner().unwrap_or_else(PoisonError::into_inner);
    // Each chain of neighbours begins from rest.
    let (near, chains) = (solved.min(CHAIN), sets.div_ceil(CHAIN));
    let near_s = (clock[near - 1] - clock[0]) / (near - 1) as f64;
    let sweep_s = clock[0] * chains as f64 + near_s * (sets - chains) as f64;
    let start = cpu_s();
    let expansion = Emulator::taylor(body, 1)?;
    let prepare_s = cpu_s() - start;
    eprintln!("{} nodes: the expansion is prepared", body.nodes);
    let start = cpu_s();
    let answers = Answers::to(body, &thetas, accuracy, Some(&expansion), &mut ())?;
    let answers_s = cpu_s() - start;
    let total_s = prepare_s + answers_s;
    let (mut errors, mut steps, mut missed) = (Vec::new(), 0, 0);
    for answer in answers.answers.iter() {
        match answer {
            Ok(answer) if answer.is_within(accuracy) => steps += answer.steps,
            _ => missed += 1,
        }
    }
    for (truth, answer) in found.results.iter().zip(&answers.answers) {
        let (Ok(truth), Ok(answer)) = (truth, answer) else { continue };
        let apart = truth.displacement.iter().zip(&answer.displacement).map(|(a, b)| a - b);
        let apart: Vec<f64> = apart.collect();
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
