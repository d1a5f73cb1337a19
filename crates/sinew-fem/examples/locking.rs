//! How elements lose deflection when the material hardly changes its volume: a beam under its own weight for
//! three bulk moduli.
//!
//! `cargo run -p sinew-fem --example locking [-- --fine]`

use sinew_energy::laws::NeoHookean;
use sinew_energy::{
    Exact, Load, Parameter, Sampling, Scene, SceneError, Support, TotalPotential, Units,
};
use sinew_fem::{BalanceSolver, Options, Solver};
use sinew_mesh::{Mesh, box_hexahedra, box_tetrahedra};
use std::error::Error;

const SIZE: [f64; 3] = [100.0, 10.0, 10.0];

fn beam<const N: usize>(mesh: Mesh<N>) -> Scene<NeoHookean, 0, N> {
    let modulus = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [1.0, 1e6],
        sampling: Sampling::Log,
    };
    Scene {
        name: "beam".into(),
        units: Units::mm_kpa(),
        mesh,
        law: NeoHookean,
        directions: vec![],
        parameters: vec![modulus("mu"), modulus("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
    }
}

/// One line of the table: the deflection of the lower edge's end and what it took.
fn row<const N: usize>(
    element: &str,
    mesh: &Mesh<N>,
    body: Result<TotalPotential<NeoHookean, 0, Exact, N>, SceneError>,
    theta: &[f64],
) -> Result<(), Box<dyn Error>> {
    let body = body?;
    let mut solver = Solver::new(&body)?;
    let unknowns = solver.unknowns();
    match solver.solve(theta, &Options::default()) {
        Ok(found) => {
            let (iterations, steps) = (found.iterations(), found.load_steps);
            print_row(
                element,
                unknowns,
                tip(mesh, &found.displacement),
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

fn tip<const N: usize>(mesh: &Mesh<N>, displacement: &[f64]) -> f64 {
    let end = mesh.points.iter().position(|x| *x == [SIZE[0], 0.0, 0.0]).unwrap_or(0);
    displacement[3 * end + 2]
}

fn main() -> Result<(), Box<dyn Error>> {
    let fine = std::env::args().any(|argument| argument == "--fine");
    let boxes = if fine { [24, 8, 10] } else { [12, 4, 5] };
    for bulk in [75.0, 7.5e3, 7.5e5] {
        let theta = [75.0, bulk];
        println!("mu = 75 kPa, lambda = {bulk:e} kPa");
        println!("  element               unknowns   tip mm  iter.  steps   seconds");
        let tets = beam(box_tetrahedra(SIZE, boxes));
        row("linear tets", &tets.mesh, tets.lower(), &theta)?;
        for cells in [4, 8, 12] {
            let name = format!("… averaged over {cells}");
            row(&name, &tets.mesh, tets.lower_with_patches(cells), &theta)?;
        }
        let hexahedra = beam(box_hexahedra(SIZE, boxes));
        row("hexahedra", &hexahedra.mesh, hexahedra.lower(), &theta)?;
        row("… averaged", &hexahedra.mesh, hexahedra.lower_averaged(), &theta)?;
        let quadratic = beam(box_tetrahedra(SIZE, [12, 4, 5]).quadratic());
        row("quadratic tets", &quadratic.mesh, quadratic.lower(), &theta)?;
        // Mixed: the law keeps a mild bulk modulus, the field of pressure brings the rest.
        let mut body = quadratic.lower_mixed()?;
        let own = f64::min(bulk, 750.0);
        if let Some(field) = &mut body.pressure_field {
            field.compliance = if bulk > own { 1.0 / (bulk - own) } else { continue };
        }
        let mut solver = BalanceSolver::new(&body)?;
        let unknowns = solver.unknowns().iter().sum();
        let found = solver.solve(&[75.0, own], &Options::default())?;
        let deflection = tip(&quadratic.mesh, &found.displacement);
        let (iterations, steps) = (found.history.iterations.len(), found.load_steps);
        print_row("quadratic, mixed", unknowns, deflection, iterations, steps, found.seconds);
    }
    Ok(())
}
