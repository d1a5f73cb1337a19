//! GraphNetwork of the gravity beam: full forward pass, decoder alone, and a training step on energy
//! or on simulations with Muon or Adam, by number of parameter sets.
//!
//! `plain Burn` is the same step without fused operations: what these are worth.
//!
//! Beside every time stands the error of the fused kernels: the largest difference from the
//! reference path, relative to the largest displacement, and that of the loss of a step.
//! One core: `taskset -c 0 env RAYON_NUM_THREADS=1 cargo bench --profile dev -p sinew-gnn --bench emulator`.

mod beam;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion};
use sinew_gnn::*;

use crate::beam::{beam, distance, energy, thetas, trainer, trainer_of};

type MakeObjective = fn(&DataSet) -> Box<dyn Objective>;

/// Largest difference between fused and reference path, relative to the largest displacement.
fn fused_error(surrogate: &Surrogate, thetas: &[Vec<f64>]) -> f64 {
    let predict = |choice| {
        let surrogate = surrogate.clone().with_kernels(choice);
        surrogate
            .predict(&surrogate.geometries()[0], thetas)
            .expect("inside the range")
            .displacement
    };
    let (fused, reference) = (predict(KernelChoice::Fused), predict(KernelChoice::Reference));
    let size = reference.iter().fold(0f64, |m, u| m.max(u.abs()));
    fused.iter().zip(&reference).fold(0f64, |m, (a, b)| m.max((a - b).abs())) / size
}

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
        "{} nodes, {} stored edges, error of the fused kernels {:.1e}",
        data.geometries[0].topology.nodes,
        data.geometries[0].topology.senders.len(),
        fused_error(&surrogate, &thetas(8)),
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
            println!(
                "step/{name}/{batch}: error {:.1e}",
                step_error(&surrogate, &data, batch, objective)
            );
            for (rule, optimiser) in [("Adam", OptimiserConfig::adam()), ("Muon", muon())] {
                let mut trainer = trainer(&data, batch, objective(&data), optimiser);
                criterion.bench_function(&format!("step/{name}/{rule}/{batch}"), |bencher| {
                    bencher.iter(|| trainer.step().expect("finite loss"));
                });
            }
            let mut plain = trainer(&data, batch, objective(&data), muon())
                .with_kernels(KernelChoice::Reference);
            criterion.bench_function(&format!("step/{name}/Muon/{batch}, plain Burn"), |bencher| {
                bencher.iter(|| plain.step().expect("finite loss"));
            });
        }
    }
    criterion.final_summary();
}

/// Relative differences between fused and reference path in the loss and the norm of its gradient, at the weights of
/// a network that has learned a little: outputs of an untrained one are zero.
fn step_error(
    surrogate: &Surrogate,
    data: &DataSet,
    batch: usize,
    objective: MakeObjective,
) -> f64 {
    let run = |choice| {
        trainer_of(surrogate.clone(), data, batch, objective(data), OptimiserConfig::adam())
            .with_kernels(choice)
            .step()
            .expect("finite loss")
    };
    let (fused, reference) = (run(KernelChoice::Fused), run(KernelChoice::Reference));
    let relative = |a: f64, b: f64| (a / b - 1.0).abs();
    relative(fused.loss, reference.loss).max(relative(fused.gradient_norm, reference.gradient_norm))
}
