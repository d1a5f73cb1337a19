//! Time and error of each stage on the thesis' OnceClampedBeam (1080 unknowns).

use criterion::{Criterion, criterion_group, criterion_main};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Sampling, Scene, Support};
use sinew_fem::{Options, Solver, sweep};
use sinew_mesh::box_tetrahedra;
use std::hint::black_box;

/// Energy [kPa mm³] at μ = λ = 75 kPa of an independent FEniCS run (fixtures/beam).
const REFERENCE: f64 = -766.9706813353461;
const THETA: [f64; 2] = [75.0, 75.0];

fn beam() -> Body {
    let stiffness = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [50.0, 100.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "OnceClampedBeam".into(),
        parameters: vec![stiffness("mu"), stiffness("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean)
    };
    scene.lower().expect("the beam is well formed")
}

/// 200 points of a log-uniform Latin hypercube over [50, 100]²; 77 has no factor in common with 200.
fn samples() -> Vec<Vec<f64>> {
    let stiffness = |place: usize| 50.0 * 2.0_f64.powf((place as f64 + 0.5) / 200.0);
    (0..200).map(|i| vec![stiffness(i), stiffness((i * 77 + 31) % 200)]).collect()
}

fn stages(criterion: &mut Criterion) {
    let potential = beam();
    let options = Options::default();
    let mut solver = Solver::new(&potential).expect("the beam is held");
    let cold = solver.solve(&THETA, &options).expect("the beam has an equilibrium");
    println!(
        "cold solve: {} iterations, residual {:.1e} of the forces, energy off by {:.1e}; [stiffness, factor] entries {:?}",
        cold.iterations(),
        cold.residual / cold.force_scale,
        (cold.energy / REFERENCE - 1.0).abs(),
        solver.stored_entries(),
    );
    let mut group = criterion.benchmark_group("once_clamped_beam");
    group.bench_function("prepare", |b| b.iter(|| Solver::new(black_box(&potential)).map(|_| ())));
    group.bench_function("assemble", |b| b.iter(|| solver.stiffness(black_box(&cold)).map(|_| ())));
    group.bench_function("assemble_factorise_sensitivity", |b| {
        b.iter(|| solver.sensitivity(black_box(&cold)))
    });
    group.bench_function("cold_solve", |b| b.iter(|| solver.solve(black_box(&THETA), &options)));
    group.bench_function("warm_solve", |b| {
        b.iter(|| solver.solve_from(&cold.displacement, black_box(&[76.0, 74.0]), &options))
    });
    group.finish();
}

fn sweeps(criterion: &mut Criterion) {
    let (potential, thetas, options) = (beam(), samples(), Options::default());
    let swept = sweep(&potential, &thetas, &options, || ()).expect("the beam is held");
    let solutions: Vec<_> =
        swept.into_iter().map(|s| s.expect("every sample has an equilibrium")).collect();
    let worst = solutions.iter().map(|s| s.residual / s.force_scale).fold(0.0, f64::max);
    let iterations: usize = solutions.iter().map(|s| s.iterations()).sum();
    println!(
        "sweep of 200: worst residual {worst:.1e} of the forces, {:.2} iterations per sample, {} threads",
        iterations as f64 / 200.0,
        rayon::current_num_threads()
    );
    let mut group = criterion.benchmark_group("sweep");
    group.sample_size(10);
    group.bench_function("200_samples", |b| b.iter(|| sweep(&potential, &thetas, &options, || ())));
    group.finish();
}

criterion_group!(benches, stages, sweeps);
criterion_main!(benches);
