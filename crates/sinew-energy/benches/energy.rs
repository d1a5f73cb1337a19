//! Energy, stress and tangent of each law per tetrahedron: closed forms against Taylor numbers in ∇u.
//! The largest relative difference between the two is printed beside the times.

use criterion::{Criterion, Throughput};
use sinew_energy::laws::{
    Compressible, Guccione, HolzapfelOgden, HolzapfelOgden2009, HolzapfelOgdenCompressible,
    LinearElastic, NeoHookean,
};
use sinew_energy::{
    Barriers, Body, Exact, FacetRule, Law, Magnitude, PressureSurface, Response, Scene, Solid,
    Support, SurfaceResponse, response_by_jets, stress_by_slopes,
};
use sinew_mesh::{TetMesh, box_tetrahedra};
use std::hint::black_box;

fn beam() -> TetMesh {
    box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5])
}

fn potential<L: Law<D>, const D: usize>(law: L) -> Body {
    let mesh = beam();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let directions = vec![std::array::from_fn(|d| axes[d]); mesh.cells.len()];
    let parameter = |name: &&str| sinew_energy::Parameter {
        name: name.to_string(),
        unit: "kPa".into(),
        range: [1.0, 2.0],
        sampling: sinew_energy::Sampling::Log,
    };
    let scene = Scene {
        name: "beam".into(),
        parameters: L::PARAMETERS.iter().map(parameter).collect(),
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, law.along(directions))
    };
    scene.lower().expect("the scene is complete")
}

/// Bending with some stretch: every invariant differs from rest.
fn displacement(mesh: &TetMesh) -> Vec<f64> {
    let bend = |&[x, y, z]: &[f64; 3]| {
        [-2e-3 * x * z + 0.01 * x, -0.02 * y + 5e-4 * x * z, 1e-3 * x * x + 1e-3 * y]
    };
    mesh.points.iter().flat_map(bend).collect()
}

fn compare<L: Law<D>, const D: usize>(criterion: &mut Criterion, label: &str, law: L) {
    let theta = vec![1.5; L::PARAMETERS.len()];
    let potential = potential(law.clone());
    let u = displacement(&beam());
    let cells = potential.cell_count();
    let gradients: Vec<_> = (0..cells).map(|c| potential.displacement_gradient(c, &u)).collect();
    let directions = potential.material.directions(0);
    let directions: &[[f64; 3]; D] = directions.try_into().expect("one row per direction");
    let law = &law;

    let difference = |h| {
        let (closed, jets) =
            (law.response(&theta, h, directions), response_by_jets(law, &theta, h, directions));
        let flat = |r: &Response| [r.stress.0.as_flattened(), r.tangent.as_flattened()].concat();
        let (closed, jets) = (flat(&closed), flat(&jets));
        let scale = jets.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        closed.iter().zip(&jets).map(|(x, y)| (x - y).abs() / scale).fold(0.0, f64::max)
    };
    let error = gradients.iter().map(difference).fold(0.0, f64::max);
    println!("{label}: largest relative difference of closed form and jets {error:.1e}");

    let mut group = criterion.benchmark_group(label);
    group.throughput(Throughput::Elements(cells as u64)).sample_size(20);
    let mut gradient = vec![0.0; u.len()];
    group.bench_function("potential, energy and gradient", |bench| {
        bench.iter(|| potential.value_and_gradient(black_box(&u), black_box(&theta), &mut gradient))
    });
    let guarded = potential.clone().with_barriers(Barriers::default());
    group.bench_function("potential, energy and gradient, guarded", |bench| {
        bench.iter(|| guarded.value_and_gradient(black_box(&u), black_box(&theta), &mut gradient))
    });
    group.bench_function("stress, closed form", |bench| {
        let stress = |h| law.stress(black_box(&theta), h, directions, &Exact).0;
        bench.iter(|| gradients.iter().map(stress).sum::<f64>())
    });
    group.bench_function("stress, slopes", |bench| {
        let stress = |h| stress_by_slopes(law, black_box(&theta), h, directions, &Exact).0;
        bench.iter(|| gradients.iter().map(stress).sum::<f64>())
    });
    group.bench_function("tangent, closed form", |bench| {
        let energy = |h| black_box(law.response(black_box(&theta), h, directions)).energy;
        bench.iter(|| gradients.iter().map(energy).sum::<f64>())
    });
    group.bench_function("tangent, jets", |bench| {
        let energy = |h| black_box(response_by_jets(law, black_box(&theta), h, directions)).energy;
        bench.iter(|| gradients.iter().map(energy).sum::<f64>())
    });
}

fn pressure(criterion: &mut Criterion) {
    let mesh = beam();
    let facets = mesh.facet_sets["z_min"].iter();
    let nodes: Vec<_> = facets.flat_map(|&facet| mesh.facet_nodes(facet)).collect();
    let positions = nodes.iter().map(|&node| mesh.points[node]).collect();
    let u = displacement(&mesh);
    let load = PressureSurface {
        magnitude: Magnitude::Fixed(1.0),
        thesis: false,
        lids: Vec::new(),
        rule: FacetRule::of_cells::<4>(),
        nodes,
        positions,
    };
    let mut group = criterion.benchmark_group("pressure");
    group.throughput(Throughput::Elements(load.facets() as u64)).sample_size(20);
    let mut gradient = vec![0.0; u.len()];
    group.bench_function("energy and gradient", |bench| {
        bench.iter(|| load.value_and_add_gradient(black_box(&u), &[], &mut gradient))
    });
    group.bench_function("Hessian", |bench| {
        let mut response = SurfaceResponse::default();
        let mut energy = |facet| {
            load.facet_response(facet, black_box(&u), black_box(&mut response));
            response.energy
        };
        bench.iter(|| (0..load.facets()).map(&mut energy).sum::<f64>())
    });
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let bulk_modulus = 50.0;
    compare(&mut criterion, "neo-Hookean", NeoHookean);
    compare(&mut criterion, "Holzapfel-Ogden", HolzapfelOgden.nearly_incompressible(bulk_modulus));
    compare(
        &mut criterion,
        "Holzapfel-Ogden 2009",
        HolzapfelOgden2009.nearly_incompressible(bulk_modulus),
    );
    let compressible = Solid::new(HolzapfelOgdenCompressible, Compressible { kappa: 25.0 });
    compare(&mut criterion, "Holzapfel-Ogden, compressible", compressible);
    compare(&mut criterion, "Guccione", Guccione.nearly_incompressible(bulk_modulus));
    compare(&mut criterion, "linear", LinearElastic);
    pressure(&mut criterion);
    criterion.final_summary();
}
