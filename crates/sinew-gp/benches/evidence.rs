//! Evidence and gradient of Heat-BVP-1. The gradient's error against a finite difference stands beside the time.

mod heat;

use crate::heat::{heat, middle, relative_error};
use criterion::{BenchmarkId, Criterion};
use sinew_gp::{Evidence, GpError};
use std::hint::black_box;

fn main() -> Result<(), GpError> {
    let mut criterion = Criterion::default().configure_from_args();
    for evidence in [Evidence::Joint, Evidence::UnitInformation] {
        let mut group = criterion.benchmark_group(format!("{evidence:?} evidence and gradient"));
        for size in [50, 100, 300, 600, 1200] {
            let model = heat(size, evidence)?;
            let at = middle(&model);
            println!(
                "N = {size}: relative error of the gradient {:.1e}",
                relative_error(&model, &at)?
            );
            group.sample_size(if size > 300 { 10 } else { 50 });
            group.bench_function(BenchmarkId::from_parameter(size), |bench| {
                bench.iter(|| model.evaluate(black_box(&at)));
            });
        }
        group.finish();
    }
    criterion.final_summary();
    Ok(())
}
