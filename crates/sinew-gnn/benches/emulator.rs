//! GraphNetwork of the gravity beam: full forward pass, decoder alone, and a training step on energy
//! or on simulations with Muon or Adam, by number of parameter sets.
//!
//! One core: `taskset -c 0 env RAYON_NUM_THREADS=1 cargo bench --profile dev -p sinew-gnn --bench emulator`.

mod beam;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion};
use sinew_gnn::*;

use crate::beam::{beam, distance, energy, thetas, trainer};

type MakeObjective = fn(&DataSet) -> Box<dyn Objective>;

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args();
    let data = beam();
    let muon = OptimiserConfig::default;
    let mut brief = trainer(&data, 8, distance(&data), muon()).with_learning_rate(4e-3);
    for _ in 0..20 {
        brief.step().expect("finite loss");
    }
    let surrogate = brief.current_surrogate();
    println!(
        "{} nodes, {} stored edges",
        data.geometries[0].topology.nodes,
        data.geometries[0].topology.senders.len(),
    );
    let geometry = &data.geometries[0];
    let fixed = surrogate.fixed_geometry(geometry).expect("the trained geometry");
    for batch in [1, 32, 200] {
        let thetas = thetas(batch);
        criterion.bench_with_input(
            BenchmarkId::new("forward", batch),
            &thetas,
            |bencher, thetas| {
                bencher.iter(|| black_box(surrogate.predict(geometry, thetas)));
            },
        );
        criterion.bench_with_input(
            BenchmarkId::new("decoder", batch),
            &thetas,
            |bencher, thetas| {
                bencher.iter(|| black_box(fixed.predict(thetas)));
            },
        );
    }
    for batch in [1, 8, 32, 200] {
        let objectives = [("energy", energy as MakeObjective), ("simulations", distance)];
        for (name, objective) in objectives {
            for (rule, optimiser) in [("Adam", OptimiserConfig::adam()), ("Muon", muon())] {
                let mut trainer = trainer(&data, batch, objective(&data), optimiser);
                criterion.bench_function(&format!("step/{name}/{rule}/{batch}"), |bencher| {
                    bencher.iter(|| trainer.step().expect("finite loss"));
                });
            }
        }
    }
    criterion.final_summary();
}
