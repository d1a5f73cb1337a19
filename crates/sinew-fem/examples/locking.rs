//! Deflection that nearly incompressible elements lose: a beam under its own weight for three bulk moduli. `--thresholds` prints the
//! measurements behind `sinew_fem::LARGEST_BULK_TO_SHEAR`.
//!
//! `cargo run -p sinew-fem --example locking [-- --fine | --thresholds]`

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Sampling, Scene, SceneError, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra};
use std::error::Error;

const SIZE: [f64; 3] = [100.0, 10.0, 10.0];

fn beam(mesh: impl Into<AnyMesh>) -> Scene {
    let modulus = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [1.0, 1e6],
        sampling: Sampling::Log,
    };
    Scene {
        name: "beam".into(),
        parameters: vec![modulus("mu"), modulus("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, NeoHookean)
    }
}

/// One line of the table: the deflection of the lower edge's end and what it took.
fn row(element: &str, body: Result<Body, SceneError>, theta: &[f64]) -> Result<(), Box<dyn Error>> {
    let body = body?;
    let mut solver = Solver::new(&body)?;
    let unknowns = solver.unknowns();
    match solver.solve(theta, &Options::default()) {
        Ok(found) => {
            let (iterations, steps) = (found.iterations(), found.load_steps);
            print_row(
                element,
                unknowns,
                tip(&body, &found.displacement),
                iterations,
                steps,
                found.seconds,
            );
        }
        Err(error) => println!(
            "  {element:<22} {unknowns:>7}   {}",
            error.to_string().lines().next().unwrap_or("")
        ),
    }
    Ok(())
}

fn print_row(
    element: &str,
    unknowns: usize,
    tip: f64,
    iterations: usize,
    steps: usize,
    seconds: f64,
) {
    println!("  {element:<22} {unknowns:>7} {tip:>9.3} {iterations:>6} {steps:>6} {seconds:>9.3}");
}

fn tip(body: &Body, displacement: &[f64]) -> f64 {
    let end = body.positions.iter().position(|x| *x == [SIZE[0], 0.0, 0.0]).unwrap_or(0);
    displacement[3 * end + 2]
}

/// Deflection of the lower edge's end of a box under a part of its weight so small that it hardly rotates.
fn small_deflection(
    mesh: impl Into<AnyMesh>,
    lower: Lower,
    theta: &[f64],
) -> Result<f64, Box<dyn Error>> {
    let mut scene = beam(mesh);
    scene.loads = vec![Load::BodyForce([0.0, 0.0, -9.8e-8])];
    let length = scene.mesh.points().iter().map(|x| x[0]).fold(0.0, f64::max);
    let end = scene.mesh.points().iter().position(|x| *x == [length, 0.0, 0.0]).unwrap_or(0);
    let found = Solver::new(&lower(&scene)?)?.solve(theta, &Options::default())?;
    Ok(found.displacement[3 * end + 2])
}

type Lower = fn(&Scene) -> Result<Body, SceneError>;

/// The part of the deflection that linear elements reach: over K/mu against the same with averaged volume
/// ratios, over slenderness and number of cubes across against quadratic tetrahedra.
fn thresholds() -> Result<(), Box<dyn Error>> {
    println!(
        "K/mu, linear over averaged: tetrahedra and hexahedra, 12 x 4 x 5 and 24 x 8 x 10 boxes"
    );
    for ratio in [5.0 / 3.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0] {
        let theta = [75.0, 75.0 * (ratio - 2.0 / 3.0)];
        print!("{ratio:6.2}");
        for boxes in [[12, 4, 5], [24, 8, 10]] {
            print!("  {:.3}", linear_over_averaged(|| box_tetrahedra(SIZE, boxes), &theta)?);
            print!("  {:.3}", linear_over_averaged(|| box_hexahedra(SIZE, boxes), &theta)?);
        }
        println!();
    }
    println!(
        "length/thickness, tetrahedra and hexahedra over quadratic, 1, 2, 3, 4, 6 and 8 across"
    );
    for slenderness in [1_u8, 2, 3, 5, 8, 12] {
        print!("{slenderness:6}");
        let theta = [75.0; 2];
        let size = [10.0 * f64::from(slenderness), 10.0, 10.0];
        let cubes = |across| [across * usize::from(slenderness), across, across];
        let quadratic = box_tetrahedra(size, cubes(2)).quadratic();
        let reference = small_deflection(quadratic, |scene| scene.lower(), &theta)?;
        for across in [1, 2, 3, 4, 6, 8] {
            let tetrahedra = box_tetrahedra(size, cubes(across));
            let tetrahedra = small_deflection(tetrahedra, |scene| scene.lower(), &theta)?;
            let hexahedra = box_hexahedra(size, cubes(across));
            let hexahedra = small_deflection(hexahedra, |scene| scene.lower(), &theta)?;
            print!("  {:.3} {:.3}", tetrahedra / reference, hexahedra / reference);
        }
        println!();
    }
    Ok(())
}

fn linear_over_averaged<M: Into<AnyMesh>>(
    mesh: impl Fn() -> M,
    theta: &[f64],
) -> Result<f64, Box<dyn Error>> {
    let linear = small_deflection(mesh(), |scene| scene.lower(), theta)?;
    Ok(linear / small_deflection(mesh(), |scene| scene.clone().averaged().lower(), theta)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    if std::env::args().any(|argument| argument == "--thresholds") {
        return thresholds();
    }
    let fine = std::env::args().any(|argument| argument == "--fine");
    let boxes = if fine { [24, 8, 10] } else { [12, 4, 5] };
    for bulk in [75.0, 7.5e3, 7.5e5] {
        let theta = [75.0, bulk];
        println!("mu = 75 kPa, lambda = {bulk:e} kPa");
        println!("  element               unknowns   tip mm  iter.  steps   seconds");
        let tets = beam(box_tetrahedra(SIZE, boxes));
        row("linear tets", tets.lower(), &theta)?;
        for cells in [4, 8, 12] {
            let name = format!("… averaged over {cells}");
            row(&name, tets.clone().averaged_over(cells).lower(), &theta)?;
        }
        let hexahedra = beam(box_hexahedra(SIZE, boxes));
        row("hexahedra", hexahedra.lower(), &theta)?;
        row("… averaged", hexahedra.clone().averaged().lower(), &theta)?;
        let quadratic = beam(box_tetrahedra(SIZE, [12, 4, 5]).quadratic());
        row("quadratic tets", quadratic.lower(), &theta)?;
        // Mixed: the law keeps a mild bulk modulus, the field of pressure brings the rest.
        let own = f64::min(bulk, 750.0);
        if bulk <= own {
            continue;
        }
        let body = quadratic.clone().mixed().lower()?.with_compliance(1.0 / (bulk - own))?;
        let mut solver = Solver::new(&body)?;
        let unknowns = solver.unknowns() + solver.pressures();
        let found = solver.solve(&[75.0, own], &Options::default())?;
        let deflection = tip(&body, &found.displacement);
        let (iterations, steps) = (found.history.iterations.len(), found.load_steps);
        print_row("quadratic, mixed", unknowns, deflection, iterations, steps, found.seconds);
    }
    Ok(())
}
