//! Watches Newton's method on a beam that bends under its own weight: a line per iteration, a VTU series for
//! ParaView, and a report at the end.
//!
//! `cargo run -p sinew-fem --example watch_iterations [-- folder]`

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Sampling, Scene, Support};
use sinew_fem::{Options, Solver, print_progress, report};
use sinew_mesh::{AnyMesh, Field, MeshError, box_tetrahedra, write_pvd};
use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let modulus = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [50.0, 100.0],
        sampling: Sampling::Log,
    };
    let potential = Scene {
        name: "beam".into(),
        parameters: vec![modulus("mu"), modulus("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean)
    }
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
            print_progress(progress);
            if failure.is_ok() {
                failure = write(progress.number, progress.displacement);
            }
        });
    failure?;
    // A failed solve leaves its files as well: they show where it went wrong.
    let pvd = folder.join("watched_beam.pvd");
    let files: Vec<_> = series.iter().map(|(time, name)| (*time, Path::new(name))).collect();
    write_pvd(&pvd, &files)?;
    println!("\n{}", report(&potential, &solved?)?);
    println!("open {} in ParaView and warp by displacement", pvd.display());
    Ok(())
}
