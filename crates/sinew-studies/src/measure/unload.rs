//! Unloads the thesis' left ventricle by Newton's method and by the usual fixed points, and prints error against processor time.
//! The mesh is ../shared/meshes/left_ventricle.vtk beside the repository where there is one, else the small one of fixtures/organ.

use super::organ::ventricle::{BULK_MODULUS, MMHG, scene, thetas};
use super::organ::ventricles::ventricles;
use crate::program::cpu_seconds;
use anyhow::Result;
use sinew_energy::{Body, Fibres};
use sinew_fem::{Options, Solver, Unload, UnloadOptions};
use sinew_num::{difference, dot};

/// The fixed points end when no node is farther off than this \[mm\], or after so many forward solves.
const CLOSE: f64 = 1e-4;
const MOST_SOLVES: usize = 60;

/// Prints a line for each θ and pressure; fixed points too, if asked for.
pub(super) fn run(rivals: bool) -> Result<()> {
    let Some((name, mesh)) = ventricles().pop() else { return Ok(()) };
    let body = scene(mesh, BULK_MODULUS).lower()?;
    println!("the {name} ventricle, {} nodes", body.nodes);
    for pressure in [4.0, 8.0, 20.0] {
        for theta in thetas(4, pressure * MMHG) {
            println!("{pressure} mmHg, θ = {theta:.3?}");
            let start = cpu_seconds();
            let mut unload = Unload::new(&body)?;
            let unloaded = match unload.solve(&theta, &UnloadOptions::default()) {
                Ok(unloaded) => unloaded,
                Err(error) => {
                    println!("  {error}");
                    continue;
                }
            };
            let cold = cpu_seconds() - start;
            let Some(loading) = unloaded.loading else { continue };
            println!(
                "  Newton: {} systems and {} of the check ({:.2} s), {cold:.2} s in all, off by {:.1e} mm",
                unloaded.iterations, loading.iterations, loading.seconds, loading.distance
            );
            // Each entry but the pressure five per cent up or down.
            let signs = [1.05, 0.95, 0.95, 1.05, 1.0];
            let neighbour: Vec<f64> = theta.iter().zip(signs).map(|(t, s)| t * s).collect();
            let options = UnloadOptions { load: None, ..UnloadOptions::default() };
            let start = cpu_seconds();
            let warm = unload.solve_near(&unloaded.motion, &neighbour, &options)?;
            let seconds = cpu_seconds() - start;
            println!("  a neighbour from there: {} systems, {seconds:.2} s", warm.iterations);
            for (name, rausch) in
                [("Sellier", false), ("Rausch", true)].into_iter().filter(|_| rivals)
            {
                let (systems, solves, seconds, off) = fixed_point(&body, &theta, rausch)?;
                println!(
                    "  {name}: {solves} solves, {systems} systems, {seconds:.3} s, off by {off:.1e} mm"
                );
            }
        }
    }
    Ok(())
}

/// X ← X − α (x(X) − x) with α = 1 (M. Sellier, Engng Comput. 28, 2011), or by Aitken's rule (M. K. Rausch et al., 2017).
fn fixed_point(image: &Body, theta: &[f64], aitken: bool) -> Result<(usize, usize, f64, f64)> {
    let start = cpu_seconds();
    let (mut motion, mut before) = (vec![0.0; 3 * image.nodes], Vec::<f64>::new());
    let (mut systems, mut factor, mut off) = (0, 1.0, f64::INFINITY);
    for solve in 1..=MOST_SOLVES {
        let Some(rest) = image.moved(&motion, Fibres::Carried) else {
            return Ok((systems, solve, cpu_seconds() - start, f64::NAN));
        };
        let solved = Solver::new(&rest)?.solve(theta, &Options::default());
        let Ok(loaded) = solved else {
            return Ok((systems, solve, cpu_seconds() - start, f64::NAN));
        };
        systems += loaded.iterations();
        let missed: Vec<f64> =
            loaded.displacement.iter().zip(&motion).map(|(u, w)| u + w).collect();
        off = missed
            .as_chunks::<3>()
            .0
            .iter()
            .map(|r| r[0].hypot(r[1]).hypot(r[2]))
            .fold(0.0, f64::max);
        if off <= CLOSE {
            return Ok((systems, solve, cpu_seconds() - start, off));
        }
        if aitken && !before.is_empty() {
            let change = difference(&missed, &before);
            factor *= -dot(&before, &change) / dot(&change, &change);
        }
        motion.iter_mut().zip(&missed).for_each(|(w, r)| *w -= factor * r);
        before = missed;
    }
    Ok((systems, MOST_SOLVES, cpu_seconds() - start, off))
}
