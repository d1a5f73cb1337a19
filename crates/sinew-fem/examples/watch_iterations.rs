//! Watches Newton's method on a beam that bends under its own weight: a line per iteration, a VTU series for
//! ParaView, and a report at the end.
//!
//! `cargo run -p sinew-fem --example watch_iterations [-- folder]`

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Sampling, Scene, Support};
use sinew_fem::{IterationSeries, Options, Solver, print_progress, report};
use sinew_mesh::box_tetrahedra;
use std::error::Error;
use std::path::PathBuf;

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
    let mut series = IterationSeries::new(&potential, folder.join("watched_beam"));
    let solved =
        Solver::new(&potential)?.solve_watched(&theta, &Options::default(), &mut |progress| {
            print_progress(progress);
            series.add(progress);
        });
    // A failed solve leaves its files as well: they show where it went wrong.
    let pvd = series.finish()?;
    println!("\n{}", report(&potential, &solved?)?);
    println!("open {} in ParaView and warp by displacement", pvd.display());
    Ok(())
}
