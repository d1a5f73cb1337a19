//! Solves two beams of the thesis under a pressure that follows their loose lower side, at points all over their parameter
//! ranges, and counts.

use crate::program::quantiles;
use anyhow::Result;
use sinew_energy::laws::{Guccione, HolzapfelOgden};
use sinew_energy::{Body, Law, Load, Magnitude, Material, Parameter, Scene, SceneError, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::{TetMesh, box_tetrahedra};
use std::sync::Arc;

const BULK_MODULUS: f64 = 25.0; // kPa
const PRESSURE: f64 = 0.15; // kPa

/// Steps of the low-discrepancy sequence of M. Roberts in four dimensions: powers of the root of x⁵ = x + 1.
const STEPS: [f64; 4] =
    [0.8566748838545029, 0.733891856627126, 0.6287067210378087, 0.5385972572236101];

/// A beam under pressure, of four parameters that share a range.
fn beam(
    mesh: TetMesh,
    material: Arc<dyn Material>,
    parameters: [(&str, &str); 4],
    [low, high]: [f64; 2],
) -> Result<Body, SceneError> {
    let scene = Scene::new(mesh, material)
        .load(Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(PRESSURE) })
        .support(Support::clamped("x_min"))
        .loose_rims();
    let parameter = |(name, unit)| Parameter::linear(name, unit, low..=high);
    parameters.into_iter().map(parameter).fold(scene, Scene::parameter).lower()
}

/// Solves both at so many points each.
pub(super) fn run(points: usize) -> Result<()> {
    let mesh = || box_tetrahedra([100.0, 10.0, 10.0], [10, 3, 3]);
    let cells = mesh().cells.len();
    let frames = vec![Guccione::frame([1.0, 0.0, 0.0]); cells];
    let guccione = Guccione.nearly_incompressible(BULK_MODULUS).along(frames);
    let names = [("C", "kPa"), ("b_f", "1"), ("b_t", "1"), ("b_fs", "1")];
    let range = [1.75, 3.5];
    count("Guccione", &beam(mesh(), guccione, names, range)?, range, points)?;
    let fibres = vec![[[1.0, 0.0, 0.0]]; cells];
    let holzapfel = HolzapfelOgden.nearly_incompressible(BULK_MODULUS).along(fibres);
    let names = [("a", "kPa"), ("b", "1"), ("a_f", "kPa"), ("b_f", "1")];
    let range = [0.75, 2.5];
    count("Holzapfel-Ogden", &beam(mesh(), holzapfel, names, range)?, range, points)
}

fn count(name: &str, body: &Body, [low, high]: [f64; 2], points: usize) -> Result<()> {
    let mut solver = Solver::new(body)?;
    let (mut iterations, mut steps, mut refused, mut worst) = (vec![], vec![], 0, 0.0_f64);
    let mut seconds = 0.0;
    for point in 1..=points {
        let theta = STEPS.map(|step| low + (high - low) * (0.5 + step * point as f64).fract());
        match solver.solve(&theta, &Options::default()) {
            Ok(solution) => {
                iterations.push(solution.iterations());
                steps.push(solution.load_steps);
                worst = worst.max(solution.residual / solution.force_scale);
                seconds += solution.seconds;
            }
            Err(error) => {
                refused += 1;
                println!("{theta:.4?}: {error}");
            }
        }
    }
    const SHARES: [f64; 3] = [0.5, 0.9, 1.0];
    println!(
        "{name}: {} solved in {seconds:.1} s, {refused} refused, residual at most {worst:.1e} of the forces; \
         iterations {:?}, load steps {:?} (median, 90 %, most)",
        steps.len(),
        quantiles(iterations, SHARES),
        quantiles(steps, SHARES)
    );
    Ok(())
}
