//! Solves a beam that bends under its own weight and writes the deformed mesh for ParaView.
//!
//! `cargo run --example solve_beam -- beam.vtu`

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Sampling, Scene, Support, Units};
use sinew_fem::{Options, Solver};
use sinew_mesh::{Field, box_tetrahedra, write_vtu};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name the file to write, such as beam.vtu")?;
    let stiffness = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [50.0, 100.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "beam".into(),
        units: Units::mm_kpa(),
        mesh: box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]),
        law: NeoHookean,
        directions: vec![],
        parameters: vec![stiffness("mu"), stiffness("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])], // 1 g/cm³ · 9.8 m/s² [kPa/mm]
        supports: vec![Support::clamped("x_min")],
    };
    let potential = scene.lower()?;
    let solution = Solver::new(&potential)?.solve(&[75.0, 75.0], &Options::default())?;

    println!("{}", solution.history);
    let largest =
        solution.displacement.chunks(3).map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt());
    println!(
        "energy {:.6} kPa mm³, largest displacement {:.4} mm, stable: {}, {:.1} ms",
        solution.energy,
        largest.fold(0.0, f64::max),
        solution.is_stable(),
        1e3 * solution.seconds
    );

    let mut mesh = scene.mesh;
    let rows: Vec<[f64; 3]> = solution.displacement.chunks(3).map(|u| [u[0], u[1], u[2]]).collect();
    mesh.point_fields.insert("displacement".into(), Field::vectors(&rows));
    write_vtu(&path, &mesh)?;
    println!("written: {path}");
    Ok(())
}
