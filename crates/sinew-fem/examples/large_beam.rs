//! Time, memory and iterations of both linear solvers on ever finer beams.
//!
//! `cargo run -p sinew-fem --example large_beam -- direct 28 9 12` (or `iterative`; boxes along x, y, z; Poisson's ratio last).

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Sampling, Scene, Support, Units};
use sinew_fem::{LinearSolver, Options, Solver};
use sinew_mesh::box_tetrahedra;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let choice = match arguments.first().map(String::as_str) {
        Some("direct") => LinearSolver::Direct,
        Some("iterative") => LinearSolver::Iterative,
        _ => LinearSolver::Automatic,
    };
    let number =
        |at: usize, default: f64| arguments.get(at).map_or(Ok(default), |text| text.parse());
    let cells = [number(1, 28.0)? as usize, number(2, 9.0)? as usize, number(3, 12.0)? as usize];
    let poisson = number(4, 0.25)?;
    let stiffness = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [1.0, 1e6],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "beam".into(),
        units: Units::mm_kpa(),
        mesh: box_tetrahedra([100.0, 10.0, 10.0], cells),
        law: NeoHookean,
        directions: vec![],
        parameters: vec![stiffness("mu"), stiffness("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
    };
    let potential = scene.lower()?;
    let start = Instant::now();
    let mut solver = Solver::with_linear_solver(&potential, choice)?;
    let prepared = start.elapsed().as_secs_f64();
    let lambda = 75.0 * 2.0 * poisson / (1.0 - 2.0 * poisson);
    let solution = solver.solve(&[75.0, lambda], &Options::default())?;
    let tip = scene.mesh.node_sets["x_max"][0];
    println!(
        "{} unknowns, {choice:?}: prepared in {prepared:.2} s, solved in {:.2} s ({} iterations), residual {:.1e}, \
         tip {:.6} mm, stable {}, entries {:?}, linear iterations {:?}, peak memory {} MB",
        solver.unknowns(),
        solution.seconds,
        solution.iterations(),
        solution.residual / solution.force_scale,
        solution.displacement[3 * tip + 2],
        solution.is_stable(),
        solver.stored_entries(),
        solver.linear_iterations(),
        peak_memory(),
    );
    Ok(())
}

/// Largest resident memory \[MB\] so far; 0 where the system does not tell.
fn peak_memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok());
    kilobytes.unwrap_or(0) / 1000
}
