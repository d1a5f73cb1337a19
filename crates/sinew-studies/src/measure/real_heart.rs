//! Meshes the left ventricle of a real heart over one beat from its surfaces, and loads it to 8 mmHg.

use super::organ::ventricle::{BULK_MODULUS, MMHG, scene};
use crate::hearts;
use anyhow::Result;
use sinew_fem::fibres::{Depth, FibreRule, Surfaces, VentricleCoordinates};
use sinew_fem::{Options, Solver};
use sinew_mesh::{ChamberWall, Field, TetMesh, TruncatedEllipsoid, extract_surface};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Meshes with about so many nodes each, loaded to a pressure \[mmHg\].
pub(super) fn run(sizes: &[usize], pressure: f64) -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes/biv-me");
    let hearts = if folder.exists() { measured(&folder)? } else { vec![ideal()?] };
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
        for &nodes in sizes {
            if let Err(reason) = row(name, surfaces, nodes, pressure * MMHG) {
                println!("{name:<6} {nodes:>6} FAILED: {reason}");
                failed += 1;
            }
        }
    }
    println!("{failed} of {} failed", hearts.len() * sizes.len());
    Ok(())
}

fn row(name: &str, surfaces: &hearts::Surfaces, nodes: usize, pressure: f64) -> Result<()> {
    let start = Instant::now();
    let wall = surfaces.wall(nodes)?;
    let seconds = start.elapsed().as_secs_f64();
    let (mesh, report) = (with_fibres(&wall)?, wall.report());
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
    theta[4] = pressure;
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

/// Tetrahedra with fibres by rule, and the set of the scene's pressure.
pub(super) fn with_fibres(wall: &ChamberWall) -> Result<TetMesh> {
    let mut mesh = wall.tetrahedra();
    let names = Surfaces { endocardium: "endocardium", epicardium: "epicardium", base: "base" };
    let frames =
        VentricleCoordinates::new(&mesh, &names)?.cell_frames(&FibreRule::SIXTY, Depth::Thickness);
    let fibres: Vec<[f64; 3]> = frames.iter().map(|frame| frame[0]).collect();
    mesh.cell_fields.insert("fibre".into(), Field::vectors(&fibres));
    let cavity = mesh.facet_sets["endocardium"].clone();
    mesh.facet_sets.insert("region:1".into(), cavity);
    Ok(mesh)
}

/// The frames of a beat in a folder.
pub(super) fn measured(folder: &Path) -> Result<Vec<(String, hearts::Surfaces)>> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<_>>()?;
    files.sort();
    let mut frames = Vec::new();
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !name.contains("_LV_ENDOCARDIAL_") {
            continue;
        }
        let sibling = |what: &str| file.with_file_name(name.replace("LV_ENDOCARDIAL", what));
        let surfaces = hearts::Surfaces::read(sibling)?;
        let frame = name.trim_end_matches(".vtk").rsplit('_').next().unwrap_or_default();
        frames.push((frame.to_string(), surfaces));
    }
    Ok(frames)
}

/// An ideal ventricle of about the same size.
fn ideal() -> Result<(String, hearts::Surfaces)> {
    println!("the surfaces of a real heart are absent; an ideal ventricle stands in");
    let wall = TruncatedEllipsoid { short: [25.0, 36.0], long: [66.0, 75.0], base: 15.0 };
    let mesh = wall.wall([1, 64, 40]).tetrahedra();
    let surface = |name: &str| extract_surface(&mesh, &mesh.facet_sets[name]);
    let (endocardium, epicardium) = (surface("endo"), surface("epi"));
    Ok(("ideal".into(), hearts::Surfaces { endocardium, epicardium, septum: None }))
}
