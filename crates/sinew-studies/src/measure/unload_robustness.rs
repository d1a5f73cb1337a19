//! Unloads random ventricles and, where they are, frames of a real heart, and counts clean answers, typed refusals and wrong answers.
//!
//! Each shape has a random θ of the box and 4, 8 or 20 mmHg, each frame of the heart 3 θ and 3 pressures; frames of
//! systole have a tension. A refusal comes with the largest part of the load that has an answer, on this mesh and on a finer one.

use super::mean_ventricle::with_fibres;
use super::organ::ventricle::{self, BOX, BULK_MODULUS, MMHG, scene};
use super::real_heart::SIDES;
use crate::hearts::{FRAMES, Surfaces};
use anyhow::Result;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sinew_energy::laws::{ActiveTension, HolzapfelOgden};
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene};
use sinew_fem::{LoadSteps, Options, Solver, Unload, UnloadError, UnloadOptions, Unloaded};
use sinew_mesh::{TetMesh, VentricleShape};
use sinew_sample::standard_normals;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

const SEED: u64 = 29;
const PRESSURES: [f64; 3] = [4.0, 8.0, 20.0];
/// Nodes of an answer return to the image to this \[mm\], or it is wrong.
const CLOSED: f64 = 1e-8;
/// Frames between end diastole and filling, at 20, 40 and 100 mmHg with a tension of so much [kPa a mmHg].
const SYSTOLE: [&str; 3] = ["004", "008", "012"];
const TENSION: f64 = 0.5;
/// Nodes of the walls of a real heart, and of finer ones.
const NODES: [usize; 2] = [900, 2500];

/// Shapes of two layers and of one, and the surfaces of biv-me in a folder.
pub(super) fn run(shapes: u64, folder: Option<&Path>) -> Result<()> {
    for cells in [[2, 16, 8], [1, 16, 8]] {
        let start = Instant::now();
        let found: Vec<_> = (0..shapes).into_par_iter().map(|index| random(index, cells)).collect();
        let name = format!("{shapes} random ventricles of {} layers", cells[0]);
        tell(&name, &found, start);
    }
    let Some(folder) = folder else { return Ok(()) };
    let start = Instant::now();
    let frames = FRAMES.into_par_iter().map(|frame| (frame, real(folder, frame)));
    let (systole, diastole): (Vec<_>, Vec<_>) =
        frames.collect::<Vec<_>>().into_iter().partition(|(frame, _)| SYSTOLE.contains(frame));
    for (name, frames) in [("diastole", diastole), ("systole, with tension", systole)] {
        let found: Vec<Outcome> = frames.into_iter().flat_map(|(_, found)| found).collect();
        tell(&format!("frames of a real heart in {name}"), &found, start);
    }
    Ok(())
}

/// An outcome: a word for counts, and a line to print.
type Outcome = (&'static str, String);

fn tell(name: &str, found: &[Outcome], start: Instant) {
    let mut counts = BTreeMap::new();
    for (word, line) in found {
        *counts.entry(*word).or_insert(0) += 1;
        if *word != "clean" {
            println!("  {word}: {line}");
        }
    }
    let counts: Vec<_> = counts.iter().map(|(word, count)| format!("{count} {word}")).collect();
    println!("{name}: {} ({:.0} s)", counts.join(", "), start.elapsed().as_secs_f64());
}

/// Shape, θ and pressure by a seed each; shapes outside of the population's ranges are drawn again.
fn random(index: u64, cells: [usize; 3]) -> Outcome {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(index);
    let shape = std::iter::repeat_with(|| standard_normals(12, &mut random));
    let mesh = shape.take(100).find_map(|numbers| {
        let shape = VentricleShape::new(&numbers).ok()?;
        Some((shape.tetrahedra(cells).ok()?, shape.tetrahedra(cells.map(|c| 3 * c / 2)).ok()?))
    });
    let Some((mesh, finer)) = mesh else { return ("no mesh", format!("shape {index}")) };
    let ideal = |mesh| body(mesh, ["endo", "epi", "base"], false);
    let [a, b, a_f, b_f] = std::array::from_fn(|i| {
        let [least, most] = BOX[i].1;
        least * f64::powf(most / least, random.random())
    });
    let pressure = PRESSURES[index as usize % 3];
    let theta = [a, b, a_f, b_f, pressure * MMHG];
    match ideal(mesh) {
        Ok(body) => {
            let (word, mut line) = outcome(&body, &theta);
            if word == "typed" {
                line += &parts(&body, ideal(finer).ok().as_ref(), &theta);
            }
            (word, line)
        }
        Err(error) => ("no body", error.to_string()),
    }
}

/// Part of the load that has an answer, on this mesh and on a finer one, in words.
fn parts(body: &Body, finer: Option<&Body>, theta: &[f64]) -> String {
    let [own, finer] = [Some(body), finer].map(|b| b.map_or(f64::NAN, |b| borne(b, theta)));
    format!("; {own:.2} of the load has an answer, {finer:.2} on a finer mesh")
}

/// The largest part of pressure and tension, which follow the law's parameters in θ, that has an answer.
fn borne(body: &Body, theta: &[f64]) -> f64 {
    let Ok(mut unload) = Unload::new(body) else { return f64::NAN };
    let mut part = |part: f64| {
        let mut theta = theta.to_vec();
        theta[BOX.len()..].iter_mut().for_each(|load| *load *= part);
        unload.solve(&theta, &UnloadOptions::default()).is_ok()
    };
    let (mut low, mut high) = if part(1.0) { return 1.0 } else { (0.0, 1.0) };
    for _ in 0..5 {
        let middle = 0.5 * (low + high);
        if part(middle) { low = middle } else { high = middle }
    }
    low
}

/// The frames at three θ and three pressures.
fn real(folder: &Path, frame: &str) -> Vec<Outcome> {
    let body = |nodes: usize| -> Result<Body> {
        let mesh = Surfaces::read(folder, frame)?.wall(nodes)?.tetrahedra();
        self::body(mesh, SIDES, SYSTOLE.contains(&frame))
    };
    let coarse = match body(NODES[0]) {
        Ok(body) => body,
        Err(error) => return vec![("no body", format!("frame {frame}: {error}"))],
    };
    let mut finer = None;
    // Inside of the box: its softest corner, which comes first, is a hard case of its own.
    let thetas = ventricle::thetas(3, 0.0);
    let cases = thetas[1..].iter().flat_map(|theta| PRESSURES.map(|pressure| (theta, pressure)));
    cases
        .map(|([a, b, a_f, b_f, _], pressure)| {
            let mut theta = vec![*a, *b, *a_f, *b_f];
            if SYSTOLE.contains(&frame) {
                theta.extend([5.0 * TENSION * pressure, 5.0 * pressure * MMHG]);
            } else {
                theta.push(pressure * MMHG);
            }
            let (word, mut line) = outcome(&coarse, &theta);
            if word == "typed" {
                let finer = finer.get_or_insert_with(|| body(NODES[1]));
                line += &parts(&coarse, finer.as_ref().ok(), &theta);
            }
            (word, format!("frame {frame}: {line}"))
        })
        .collect()
}

/// θ = (a, b, a_f, b_f, pressure), or with the tension before the pressure.
fn body(mesh: TetMesh, sides: [&str; 3], active: bool) -> Result<Body> {
    let mesh = with_fibres(mesh, sides)?;
    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>();
    let passive = scene(mesh, BULK_MODULUS);
    if !active {
        return Ok(passive.lower()?);
    }
    let muscle = HolzapfelOgden.nearly_incompressible(BULK_MODULUS).with_active(ActiveTension);
    let fibres = fibres.into_iter().flatten().map(|fibre| [fibre]).collect();
    let material = muscle.along(fibres);
    let mut parameters = passive.parameters.clone();
    parameters.insert(BOX.len(), Parameter::linear("T_a", "kPa", 0.0..=100.0));
    let magnitude = Magnitude::Theta(BOX.len() + 1);
    let loads = vec![Load::Pressure { facets: "region:1".into(), magnitude }];
    Ok(Scene { material, parameters, loads, ..passive }.lower()?)
}

/// Unloads, and loads an answer again by a solver of its own.
fn outcome(body: &Body, theta: &[f64]) -> Outcome {
    let line = |what: &str| format!("{} nodes, θ = {theta:.3?}: {what}", body.nodes);
    let mut unload = match Unload::new(body) {
        Ok(unload) => unload,
        Err(error) => return ("no body", line(&error.to_string())),
    };
    let unloaded = match unload.solve(theta, &UnloadOptions::default()) {
        Ok(unloaded) => unloaded,
        Err(UnloadError::Body(error)) => return ("UNTYPED", line(&error.to_string())),
        Err(error) => return ("typed", line(&error.to_string())),
    };
    // At once, or under a load that rises slowly, which is what a body goes through.
    let rising = Options { load_steps: LoadSteps::Always, ..Options::default() };
    let at_once = off(&unloaded, theta, &Options::default());
    let off = if at_once <= CLOSED { at_once } else { off(&unloaded, theta, &rising) };
    // Written so that a NaN is wrong as well.
    let closed = off <= CLOSED && unloaded.volume_ratios[0].value > 0.0;
    match (closed, unloaded.iterations) {
        (false, _) => ("WRONG", line(&format!("off by {off:.1e} mm"))),
        (true, ..=12) => ("clean", String::new()),
        (true, more) => ("clean in more than 12 iterations", line(&format!("{more} iterations"))),
    }
}

/// Farthest that a solver of its own comes to from the image \[mm\].
fn off(unloaded: &Unloaded, theta: &[f64], options: &Options) -> f64 {
    let loaded = Solver::new(&unloaded.rest).and_then(|mut s| s.solve(theta, options));
    loaded.map_or(f64::NAN, |loaded| {
        let moved = loaded.displacement.iter().zip(&unloaded.motion).map(|(u, w)| u + w);
        moved.fold(0.0, |most: f64, d| most.max(d.abs()))
    })
}
