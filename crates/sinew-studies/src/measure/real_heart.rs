//! Meshes the left ventricle of a real heart over one beat from its surfaces, and loads it to 8 mmHg.

use super::mean_ventricle::with_fibres;
use super::organ::ventricle::{BULK_MODULUS, MMHG, scene};
use crate::hearts::{self, FRAMES, Surfaces};
use anyhow::Result;
use sinew_fem::{Options, Solver};
use sinew_mesh::{TruncatedEllipsoid, extract_surface};
use std::path::Path;
use std::time::Instant;

/// Meshes with about so many nodes each, loaded to a pressure \[mmHg\].
const SIZES: [usize; 2] = [1500, 6000];
const PRESSURE: f64 = 8.0;
/// Sides of a wall.
pub(super) const SIDES: [&str; 3] = ["endocardium", "epicardium", "base"];

/// Prints a line for each frame and size.
pub(super) fn run() -> Result<()> {
    let mut hearts = frames()?;
    if hearts.is_empty() {
        hearts.push(ideal()?);
    }
    println!(
        "{:<6} {:>6} {:>6} {:>7} {:>9} {:>6} {:>8} {:>8} {:>6} {:>6} {:>7} {:>8} {:>8}",
        "frame",
        "nodes",
        "cells",
        "mesh s",
        "dihedral",
        "ratio",
        "wall ml",
        "endo mm",
        "iter.",
        "steps",
        "solve s",
        "ml at 0",
        "ml at p"
    );
    let mut failed = 0;
    for (name, surfaces) in &hearts {
        for nodes in SIZES {
            if let Err(reason) = row(name, surfaces, nodes) {
                println!("{name:<6} {nodes:>6} FAILED: {reason}");
                failed += 1;
            }
        }
    }
    println!("{failed} of {} failed", hearts.len() * SIZES.len());
    Ok(())
}

fn row(name: &str, surfaces: &Surfaces, nodes: usize) -> Result<()> {
    let start = Instant::now();
    let wall = surfaces.wall(nodes)?;
    let seconds = start.elapsed().as_secs_f64();
    let (mesh, report) = (with_fibres(wall.tetrahedra(), SIDES)?, wall.report());
    let quality = &report.quality;
    print!(
        "{name:<6} {:>6} {:>6} {seconds:>7.2} {:>9.1} {:>6.2} {:>8.1} {:>8.2} ",
        quality.nodes,
        quality.cells,
        quality.dihedral.min,
        quality.ratio.min,
        quality.total_volume / 1e3,
        report.endocardium_distance[1]
    );
    let scene = scene(mesh, BULK_MODULUS);
    let body = scene.lower()?;
    let mut theta = body.centre();
    theta[4] = PRESSURE * MMHG;
    let solution = Solver::new(&body)?.solve(&theta, &Options::default())?;
    let volume = |u: &[f64]| body.cavity_volumes(u)[0] / 1e3;
    println!(
        "{:>6} {:>6} {:>7.2} {:>8.1} {:>8.1}",
        solution.iterations(),
        solution.load_steps,
        solution.seconds,
        volume(&vec![0.0; 3 * body.nodes]),
        volume(&solution.displacement)
    );
    Ok(())
}

/// The frames of a beat; none where the folder of the surfaces is absent.
pub(super) fn frames() -> Result<Vec<(String, Surfaces)>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes/biv-me");
    let frames = FRAMES.into_iter().filter(|frame| hearts::has(&folder, frame));
    frames.map(|frame| Ok((frame.to_string(), Surfaces::read(&folder, frame)?))).collect()
}

/// An ideal ventricle of about the same size.
fn ideal() -> Result<(String, Surfaces)> {
    println!("the surfaces of a real heart are absent; an ideal ventricle stands in");
    let wall = TruncatedEllipsoid { short: [25.0, 36.0], long: [66.0, 75.0], base: 15.0 };
    let mesh = wall.wall([1, 64, 40]).tetrahedra();
    let surface = |name: &str| extract_surface(&mesh, &mesh.facet_sets[name]);
    let (endocardium, epicardium) = (surface("endo"), surface("epi"));
    Ok(("ideal".into(), Surfaces { endocardium, epicardium, septum: None }))
}
