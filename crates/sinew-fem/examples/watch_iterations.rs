//! Watches Newton's method on a beam that bends under its own weight: a line per iteration, a VTU series for
//! ParaView, and the force of the clamp at the end.
//!
//! `cargo run -p sinew-fem --example watch_iterations [-- folder]`

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::{Options, Solver, reactions};
use sinew_mesh::{AnyMesh, Field, MeshError, box_tetrahedra, write_pvd};
use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    let potential = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"))
        .lower()?;
    let theta = [75.0, 75.0];
    let folder = std::env::args_os().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let (mut series, mut failure) = (Vec::new(), Ok(()));
    let mut write = |number: usize, displacement: &[f64]| -> Result<(), MeshError> {
        let name = format!("watched_beam_{number:04}.vtu");
        let mut mesh = AnyMesh::clone(&potential.mesh);
        let rows = Field::vectors(displacement.as_chunks::<3>().0);
        mesh.point_fields_mut().insert("displacement".into(), rows);
        mesh.write_vtu(folder.join(&name))?;
        series.push((number as f64, name));
        Ok(())
    };
    let solved =
        Solver::new(&potential)?.solve_watched(&theta, &Options::default(), &mut |progress| {
            eprintln!("{}", progress.in_words());
            if failure.is_ok() {
                failure = write(progress.number, progress.displacement);
            }
        });
    failure?;
    // A failed solve leaves its files as well: they show where it went wrong.
    let pvd = folder.join("watched_beam.pvd");
    let files: Vec<_> = series.iter().map(|(time, name)| (*time, Path::new(name))).collect();
    write_pvd(&pvd, &files)?;
    let solution = solved?;
    let forces = reactions(&potential, &solution.displacement, &[], &theta)?;
    println!("the clamp bears {:.4?} kPa mm²", forces[0]);
    println!("open {} in ParaView and warp by displacement", pvd.display());
    Ok(())
}
