//! Displacement that linear tetrahedra lose, by the estimate and by a solve in quadratic ones.

use super::mean_ventricle::with_fibres;
use crate::hearts;
use anyhow::{Context, Result, bail};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{Options, Solver, compare_formulations, locking};
use sinew_mesh::{AnyMesh, TetMesh, TruncatedEllipsoid, box_tetrahedra};
use std::path::Path;
use std::time::Instant;
use ventricle::{BULK_MODULUS, MMHG};
use ventricles::{published, ventricles};

// Ventricles and parameter sets of the solver's tests.
#[path = "../../../sinew-fem/tests/fem/support/ventricle.rs"]
mod ventricle;
#[path = "../../../../fixtures/organ/ventricles.rs"]
mod ventricles;

/// Prints a row for each body, plain and averaged.
pub(super) fn run() -> Result<()> {
    println!(
        "{:<34} {:>9} {:>9} {:>7} {:>7} {:>7}",
        "", "estimate", "loss", "judge", "solve", "quadr."
    );
    blocks()?;
    plates()?;
    for (name, mesh) in ventricles() {
        let theta = [0.18, 2.6, 3.3, 2.7];
        for mmhg in [1.0, 8.0] {
            let scene = ventricle::scene(mesh.clone(), BULK_MODULUS);
            let theta = [&theta[..], &[mmhg * MMHG]].concat();
            rows(&format!("{name} ventricle, {mmhg} mmHg"), scene, &theta)?;
        }
        let stiff = ventricle::scene(mesh, 1000.0);
        rows(&format!("{name} ventricle, K = 1000"), stiff, &[&theta[..], &[8.0 * MMHG]].concat())?;
    }
    for cells in [[1, 16, 8], [2, 8, 5], [2, 16, 8]] {
        let theta = [0.16, 2.0, 2.8, 2.1, 8.0 * MMHG];
        rows(&format!("ellipsoid of {cells:?}"), ellipsoid(cells)?, &theta)?;
    }
    livers()?;
    hearts()
}

fn neo(mesh: TetMesh, load: Load, held: &[&str]) -> Scene {
    let modulus = |name| Parameter::log(name, "kPa", 1.0..=1e6);
    let scene = Scene::new(mesh, NeoHookean).parameter(modulus("mu")).parameter(modulus("lambda"));
    held.iter().fold(scene.load(load), |scene, &set| scene.support(Support::clamped(set)))
}

fn blocks() -> Result<()> {
    let weight = |g: f64| Load::BodyForce([0.0, 0.0, -g]);
    for (name, size, cells, force, mu, ratios) in [
        ("beam", [100.0, 10.0, 10.0], [12, 4, 5], 9.8e-3, 75.0, &[1.0, 100.0, 1e4][..]),
        ("fine beam", [60.0, 10.0, 10.0], [30, 6, 6], 9.8e-3, 75.0, &[1.0]),
        ("cube", [10.0; 3], [4; 3], 0.02, 1.0, &[1.0, 25.0, 1000.0]),
    ] {
        for ratio in ratios {
            let scene = neo(box_tetrahedra(size, cells), weight(force), &["x_min"]);
            rows(&format!("{name}, lambda/mu = {ratio}"), scene, &[mu, ratio * mu])?;
        }
    }
    Ok(())
}

fn plates() -> Result<()> {
    for (name, thickness, layers, lambda, pressure) in
        [("thin plate", 3.0, 2, 100.0, 0.2), ("thick plate", 15.0, 4, 1000.0, 10.0)]
    {
        let mesh = box_tetrahedra([60.0, 60.0, thickness], [12, 12, layers]);
        let load = Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Fixed(pressure) };
        let scene = neo(mesh, load, &["x_min", "x_max", "y_min", "y_max"]);
        rows(name, scene, &[50.0, lambda])?;
    }
    Ok(())
}

fn livers() -> Result<()> {
    let Some((mut mesh, _)) = published("liver.vtk") else { return Ok(()) };
    let held = mesh.nodes_where_nonzero("clamped").context("no clamped nodes")?;
    mesh.node_sets.insert("held".into(), held);
    for lambda in [6.0, 150.0] {
        let scene = neo(mesh.clone(), Load::BodyForce([0.0, 0.0, -9.8e-3]), &["held"]);
        rows(&format!("published liver, lambda = {lambda}"), scene, &[6.0, lambda])?;
    }
    Ok(())
}

fn ellipsoid(cells: [usize; 3]) -> Result<Scene> {
    let shape = TruncatedEllipsoid { short: [22.0, 36.0], long: [58.0, 74.0], base: 0.0 };
    let mesh = with_fibres(shape.wall(cells).tetrahedra(), ["endo", "epi", "base"])?;
    Ok(ventricle::scene(mesh, BULK_MODULUS))
}

fn hearts() -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes/biv-me");
    for name in hearts::frames(&folder).step_by(2) {
        let wall = hearts::wall(&folder, name, 700)?.tetrahedra();
        let mesh = with_fibres(wall, ["endocardium", "epicardium", "base"])?;
        let scene = ventricle::scene(mesh, BULK_MODULUS);
        rows(&format!("real heart, frame {name}"), scene, &[0.2, 3.0, 3.0, 3.0, 12.0 * MMHG])?;
    }
    Ok(())
}

/// Rows of a scene in plain and averaged tetrahedra.
fn rows(name: &str, scene: Scene, theta: &[f64]) -> Result<()> {
    let AnyMesh::Tetrahedra(mesh) = &scene.mesh else {
        bail!("{name} is not of linear tetrahedra")
    };
    let better = Scene { mesh: mesh.quadratic().into(), ..scene.clone() }.lower()?;
    let (best, most) = solved(&better, theta)?;
    for (kind, body) in [("", scene.clone().lower()?), (" averaged", scene.averaged().lower()?)] {
        let (own, seconds) = solved(&body, theta)?;
        let start = Instant::now();
        let expected = locking(&body, theta, &own)?.map_or(0.0, |found| found.expected_share);
        let judged = start.elapsed().as_secs_f64();
        let loss = compare_formulations(&body, &own, &better, &best)?.displacement_loss();
        let [expected, loss] = [expected, loss].map(|share| 100.0 * share);
        let name = format!("{name}{kind}");
        let said = if expected > 0.0 { format!("{expected:.1} %") } else { "below 6 %".into() };
        println!("{name:<34} {said:>9} {loss:>7.1} % {judged:>7.2} {seconds:>7.2} {most:>7.2}");
    }
    Ok(())
}

/// Displacement, and seconds of the solve.
fn solved(body: &Body, theta: &[f64]) -> Result<(Vec<f64>, f64)> {
    let solution = Solver::new(body)?.solve(theta, &Options::default())?;
    Ok((solution.displacement, solution.seconds))
}
