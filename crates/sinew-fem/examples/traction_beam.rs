//! Solves a Guccione beam under a pressure on a surface with a loose rim at points all over its parameter box, and counts.

use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::Guccione};
use sinew_fem::{BalanceSolver, Options};
use sinew_mesh::box_tetrahedra;

const BULK_MODULUS: f64 = 25.0; // kPa
const PRESSURE: f64 = 0.15; // kPa
const POINTS: usize = 100;

/// Steps of the low-discrepancy sequence of M. Roberts in four dimensions: powers of the root of x⁵ = x + 1.
const STEPS: [f64; 4] =
    [0.8566748838545029, 0.733891856627126, 0.6287067210378087, 0.5385972572236101];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [10, 3, 3]);
    let frames = vec![Guccione::frame([1.0, 0.0, 0.0]); mesh.cells.len()];
    let [low, high] = [1.75, 3.5];
    let body = Scene::new(mesh, Guccione.nearly_incompressible(BULK_MODULUS))
        .directions(frames)
        .parameter(Parameter::linear("C", "kPa", low..=high))
        .parameter(Parameter::linear("b_f", "1", low..=high))
        .parameter(Parameter::linear("b_t", "1", low..=high))
        .parameter(Parameter::linear("b_fs", "1", low..=high))
        .load(Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(PRESSURE) })
        .support(Support::clamped("x_min"))
        .lower_follower()?;
    let mut solver = BalanceSolver::new(&body)?;
    let (mut iterations, mut steps, mut refused, mut worst) = (vec![], vec![], 0, 0.0_f64);
    for point in 1..=POINTS {
        let theta = STEPS.map(|step| low + (high - low) * (0.5 + step * point as f64).fract());
        match solver.solve(&theta, &Options::default()) {
            Ok(solution) => {
                iterations.push(solution.history.iterations.len());
                steps.push(solution.load_steps);
                worst = worst.max(solution.residual / solution.force_scale);
            }
            Err(error) => {
                refused += 1;
                println!("{theta:.4?}: {error}");
            }
        }
    }
    iterations.sort_unstable();
    steps.sort_unstable();
    let quantiles = |sorted: &[usize]| {
        [0.5, 0.9, 1.0].map(|part| sorted[((sorted.len() - 1) as f64 * part) as usize])
    };
    println!(
        "{} solved, {refused} refused, residual at most {worst:.1e} of the forces",
        iterations.len()
    );
    println!(
        "iterations {:?}, load steps {:?} (median, 90 %, most)",
        quantiles(&iterations),
        quantiles(&steps)
    );
    Ok(())
}
