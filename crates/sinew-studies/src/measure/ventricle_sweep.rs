//! Solves the thesis' left ventricle cold, on one core, for its softest corner and Sobol points of its parameter box. The mesh is
//! ../shared/meshes/left_ventricle.vtk beside the repository where there is one, else the small one of fixtures/organ.

use super::organ::ventricle::{BULK_MODULUS, MMHG, scene, thetas};
use super::organ::ventricles::ventricles;
use crate::program::quantiles;
use anyhow::{Result, ensure};
use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{Options, SolveError, Solver};

/// Sobol points after the softest corner, and cavity pressure \[mmHg\].
const POINTS: usize = 300;
const PRESSURE: f64 = 10.0;

/// Prints a line for each point.
pub(super) fn run() -> Result<()> {
    let Some((name, mesh)) = ventricles().pop() else { return Ok(()) };
    println!("the {name} ventricle");
    let potential = scene(mesh, BULK_MODULUS).lower()?;
    let volume = |u: &[f64]| potential.cavity_volumes(u)[0] / 1e3;
    println!(
        "{} tetrahedra, cavity {:.2} ml",
        potential.cell_count(),
        volume(&vec![0.0; 3 * potential.nodes])
    );
    let mut solver = Solver::new(&potential)?;
    println!("{} unknowns, [stiffness, factor] {:?}", solver.unknowns(), solver.stored_entries());
    let thetas = thetas(POINTS, PRESSURE * MMHG);
    let (mut seconds, mut failed) = (Vec::new(), 0);
    for (index, theta) in thetas.iter().enumerate() {
        match solver.solve(theta, &Options::default()) {
            Ok(s) => {
                let [_, largest] = mean_and_largest(&s.displacement);
                println!(
                    "{index:3}  {:3} iterations, {:2} load steps, {:6.2} s, residual {:.0e}, min J {:.3}, max |u| {largest:.2} mm, cavity {:.2} ml{}",
                    s.iterations(),
                    s.load_steps,
                    s.seconds,
                    s.residual / s.force_scale,
                    s.least_volume_ratio,
                    volume(&s.displacement),
                    if s.is_stable() { "" } else { ", UNSTABLE" }
                );
                seconds.push(s.seconds);
            }
            Err(SolveError::NotConverged(failure)) => {
                failed += 1;
                println!("{index:3}  FAILED at {theta:?}: {failure}");
            }
            Err(other) => return Err(other.into()),
        }
    }
    ensure!(!seconds.is_empty(), "no set was solved");
    let [median, most, all] = quantiles(seconds, [0.5, 0.9, 1.0]);
    println!(
        "{failed} of {} failed; seconds: median {median:.3?}, 90 % {most:.3?}, most {all:.3?}",
        thetas.len()
    );
    Ok(())
}
