//! Time and error of each element on the thesis' OnceClampedBeam, and of assembly under each law.

use criterion::{Criterion, criterion_group, criterion_main};
use sinew_energy::laws::{
    Guccione, HolzapfelOgden, HolzapfelOgden2009, HolzapfelOgdenCompressible, NeoHookean,
};
use sinew_energy::{Body, IntoMaterial, Law, Load, Parameter, Sampling, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra};
use std::hint::black_box;

/// Deflection of the middle of the free end \[mm\] at μ = λ = 75 kPa: Richardson's limit of quadratic elements
/// (`cargo xtask verify --only beam`).
const TIP: f64 = -57.36;
const THETA: [f64; 2] = [75.0, 75.0];
const SIZE: [f64; 3] = [100.0, 10.0, 10.0];
const BOXES: [usize; 3] = [12, 4, 5];

fn scene(material: impl IntoMaterial, mesh: impl Into<AnyMesh>) -> Scene {
    let parameter = |&name: &&str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [1.0, 100.0],
        sampling: Sampling::Log,
    };
    let scene = Scene::new(mesh, material);
    Scene {
        name: "beam".into(),
        parameters: scene.material.parameters().iter().map(parameter).collect(),
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
        ..scene
    }
}

/// Deflection of the centre line at the free end, from the corners of the cross-section.
fn tip(mesh: &AnyMesh, displacement: &[f64]) -> f64 {
    let corner =
        |x: &[f64; 3]| x[0] == SIZE[0] && [1, 2].iter().all(|&i| x[i] == 0.0 || x[i] == SIZE[i]);
    let points = mesh.points();
    let corners: Vec<_> = (0..points.len()).filter(|&n| corner(&points[n])).collect();
    corners.iter().map(|n| displacement[3 * n + 2]).sum::<f64>() / corners.len() as f64
}

fn element(criterion: &mut Criterion, name: &str, body: &Body) {
    let mut solver = Solver::new(body).expect("the beam is held");
    let options = Options::default();
    let solution = solver.solve(&THETA, &options).expect("the beam has an equilibrium");
    let deflection = tip(&body.mesh, &solution.displacement);
    println!(
        "{name}: {} unknowns, tip off by {:.2} %, {} iterations",
        solver.unknowns(),
        100.0 * (deflection / TIP - 1.0).abs(),
        solution.iterations(),
    );
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10);
    group.bench_function("assemble", |b| {
        b.iter(|| solver.stiffness(black_box(&solution)).map(|_| ()))
    });
    group.bench_function("cold_solve", |b| b.iter(|| solver.solve(black_box(&THETA), &options)));
    group.finish();
}

fn elements(criterion: &mut Criterion) {
    let tetrahedra = box_tetrahedra(SIZE, BOXES);
    let tets = scene(NeoHookean, tetrahedra.clone());
    let lowered = |result: Result<_, _>| result.expect("the beam is well formed");
    element(criterion, "linear_tetrahedra", &lowered(tets.lower()));
    element(criterion, "linear_tetrahedra_averaged", &lowered(tets.averaged().lower()));
    let quadratic = scene(NeoHookean, tetrahedra.quadratic());
    element(criterion, "quadratic_tetrahedra", &lowered(quadratic.lower()));
    let hexahedra = scene(NeoHookean, box_hexahedra(SIZE, BOXES));
    for (name, body) in [
        ("hexahedra", hexahedra.lower()),
        ("hexahedra_averaged", hexahedra.clone().averaged().lower()),
    ] {
        element(criterion, name, &lowered(body));
    }
}

fn law<L: Law<D>, const D: usize>(
    criterion: &mut Criterion,
    name: &str,
    law: L,
    direction: [[f64; 3]; D],
    theta: &[f64],
) {
    let mesh = box_tetrahedra(SIZE, BOXES);
    let directions = vec![direction; mesh.cells.len()];
    let scene = scene(law.along(directions), mesh);
    let body = scene.lower().expect("the beam is well formed");
    let mut solver = Solver::new(&body).expect("the beam is held");
    let rest = vec![0.0; body.prescribed.len()];
    let pull: Vec<_> = scene.mesh.points().iter().flat_map(|x| [1e-3 * x[0], 0.0, 0.0]).collect();
    criterion.bench_function(&format!("assemble/{name}"), |b| {
        b.iter(|| solver.stiffness_times(black_box(&pull), theta, &rest))
    });
}

fn laws(criterion: &mut Criterion) {
    const FIBRE: [f64; 3] = [1.0, 0.0, 0.0];
    let bulk_modulus = 100.0;
    let [fibre, sheet] = [FIBRE, [0.0, 1.0, 0.0]];
    law(criterion, "neo_hookean", NeoHookean, [], &THETA);
    let ogden = HolzapfelOgden.nearly_incompressible(bulk_modulus);
    law(criterion, "holzapfel_ogden", ogden, [fibre], &[1.0, 5.0, 10.0, 5.0]);
    let compressible = sinew_energy::Solid::new(
        HolzapfelOgdenCompressible,
        sinew_energy::laws::Compressible { kappa: bulk_modulus },
    );
    law(criterion, "holzapfel_ogden_compressible", compressible, [fibre], &[1.0, 5.0, 10.0, 5.0]);
    let full = HolzapfelOgden2009.nearly_incompressible(bulk_modulus);
    let theta = [0.059, 8.023, 18.472, 16.026, 2.481, 11.12, 0.216, 11.436];
    law(criterion, "holzapfel_ogden_2009", full, [fibre, sheet], &theta);
    let guccione = Guccione.nearly_incompressible(bulk_modulus);
    law(criterion, "guccione", guccione, Guccione::frame(FIBRE), &[2.0, 8.0, 2.0, 4.0]);
}

criterion_group!(benches, elements, laws);
criterion_main!(benches);
