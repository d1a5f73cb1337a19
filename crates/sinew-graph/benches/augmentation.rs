//! Time of the augmentation.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use sinew_graph::{AugmentationConfig, augment};
use sinew_mesh::{box_tetrahedra, edges};
use std::hint::black_box;

/// The beam of thesis chapter 3 and two of its cubes.
const BODIES: [([f64; 3], [usize; 3]); 3] = [
    ([100.0, 10.0, 10.0], [12, 4, 5]),
    ([10.0, 10.0, 10.0], [15, 15, 15]),
    ([10.0, 10.0, 10.0], [27, 27, 27]),
];

fn augmentation(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("augment");
    group.sample_size(10);
    for (extent, cells) in BODIES {
        let mesh = box_tetrahedra(extent, cells);
        let (nodes, edges) = (mesh.points.len(), edges(&mesh));
        let config = AugmentationConfig::for_nodes(nodes);
        let start = std::time::Instant::now();
        augment(&mesh.points, &edges, &config).expect("the mesh is valid");
        println!("{nodes} nodes, {:.2?}", start.elapsed());
        group.bench_with_input(BenchmarkId::from_parameter(nodes), &config, |bencher, config| {
            bencher.iter(|| augment(black_box(&mesh.points), &edges, config));
        });
    }
    group.finish();
}

criterion_group!(benches, augmentation);
criterion_main!(benches);
