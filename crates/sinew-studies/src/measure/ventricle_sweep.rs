//! Solves the thesis' left ventricle cold, on one core, for its softest corner and Sobol points of its
//! parameter box, and writes a table.

use super::organ::ventricle::{BULK_MODULUS, MMHG, scene, thetas};
use super::organ::ventricles::ventricles;
use anyhow::Result;
use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{Options, SolveError, Solver};
use std::io::Write;
use std::path::PathBuf;

/// The mesh is ../shared/meshes/left_ventricle.vtk beside the repository where there is one, else the small one of fixtures/organ.
#[derive(clap::Args)]
pub struct Arguments {
    /// Sobol points after the softest corner
    #[arg(long, default_value_t = 300)]
    points: usize,
    /// Cavity pressure in mmHg
    #[arg(long, default_value_t = 10.0)]
    pressure: f64,
    /// Bulk modulus of the law in kPa
    #[arg(long, default_value_t = BULK_MODULUS)]
    bulk: f64,
    /// Destination of the table
    #[arg(long, default_value = "ventricle_sweep.csv")]
    csv: PathBuf,
}

/// Prints a line for each point, and writes the table.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let Some((name, mesh)) = ventricles().pop() else { return Ok(()) };
    println!("the {name} ventricle");
    let scene = scene(mesh, arguments.bulk);
    let potential = scene.lower()?;
    let volume = |u: &[f64]| potential.cavity_volumes(u)[0] / 1e3;
    println!(
        "{} tetrahedra, cavity {:.2} ml",
        potential.cell_count(),
        volume(&vec![0.0; 3 * potential.nodes])
    );

    let mut solver = Solver::new(&potential)?;
    println!("{} unknowns, [stiffness, factor] {:?}", solver.unknowns(), solver.stored_entries());
    let mut csv = std::fs::File::create(&arguments.csv)?;
    writeln!(
        csv,
        "a,b,a_f,b_f,p,converged,iterations,evaluations,load_steps,seconds,relative_residual,least_j,stable,largest_u_mm,cavity_ml"
    )?;
    let thetas = thetas(arguments.points, arguments.pressure * MMHG);
    let (mut seconds, mut failed) = (Vec::new(), 0);
    for (index, theta) in thetas.iter().enumerate() {
        let [a, b, a_f, b_f, p] = theta;
        write!(csv, "{a:.6},{b:.6},{a_f:.6},{b_f:.6},{p:.6},")?;
        match solver.solve(theta, &Options::default()) {
            Ok(s) => {
                let relative = s.residual / s.force_scale;
                let [_, largest] = mean_and_largest(&s.displacement);
                writeln!(
                    csv,
                    "1,{},{},{},{:.4},{relative:.3e},{:.5},{},{largest:.4},{:.4}",
                    s.iterations(),
                    s.history.iterations.len(),
                    s.load_steps,
                    s.seconds,
                    s.least_volume_ratio,
                    s.is_stable(),
                    volume(&s.displacement)
                )?;
                println!(
                    "{index:3}  {:3} iterations, {:2} load steps, {:6.2} s, residual {relative:.0e}, min J {:.3}, max |u| {largest:.2} mm, cavity {:.2} ml{}",
                    s.iterations(),
                    s.load_steps,
                    s.seconds,
                    s.least_volume_ratio,
                    volume(&s.displacement),
                    if s.is_stable() { "" } else { ", UNSTABLE" }
                );
                seconds.push(s.seconds);
            }
            Err(SolveError::NotConverged(failure)) => {
                failed += 1;
                writeln!(csv, "0,,{},,,,,,,", failure.history.iterations.len())?;
                println!("{index:3}  FAILED at {theta:?}: {failure}");
            }
            Err(other) => return Err(other.into()),
        }
    }
    seconds.sort_by(f64::total_cmp);
    let at = |part: f64| seconds.get((part * (seconds.len() as f64 - 1.0)) as usize).copied();
    println!(
        "{failed} of {} failed; seconds: median {:.3?}, 90 % {:.3?}, most {:.3?}; table in {}",
        thetas.len(),
        at(0.5),
        at(0.9),
        at(1.0),
        arguments.csv.display()
    );
    Ok(())
}
