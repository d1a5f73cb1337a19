//! Training steps beside those of the JAX baseline `../shared/bench/jax_gnn_baseline.py`, run in turns.
//!
//! The baseline is not part of this repository: without it, or without a Python that has JAX
//! (`SINEW_JAX_PYTHON`), nothing is measured. Both sides inherit the cores and the memory settings:
//!
//! ```text
//! GLIBC_TUNABLES=glibc.malloc.hugetlb=1 SINEW_JAX_PYTHON=venv/bin/python taskset -c 0 \
//!     env RAYON_NUM_THREADS=1 cargo bench --profile dev -p sinew-gnn --bench against_jax -- 1 32
//! ```
//!
//! Both take one physics-informed step with Adam, on the same beam with the same network; ours
//! also with Muon. Figures are CPU time per step, which a busy machine disturbs least: the median
//! of the repetitions, and of these the least over the rounds.

mod beam;

use std::path::{Path, PathBuf};
use std::process::Command;

use sinew_gnn::{DataSet, OptimiserConfig};

use crate::beam::{beam, energy, trainer};

const ROUNDS: usize = 2;
const REPETITIONS: usize = 15;

fn main() {
    let script =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/bench/jax_gnn_baseline.py");
    if !script.exists() {
        eprintln!("skipped: no JAX baseline at {}", script.display());
        return;
    }
    let python: PathBuf =
        std::env::var_os("SINEW_JAX_PYTHON").unwrap_or_else(|| "python3".into()).into();
    let batches: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let batches = if batches.is_empty() { vec![1, 8, 32, 200] } else { batches };
    let data = beam();
    for batch in batches {
        let mut best = [f64::INFINITY; 3];
        for _ in 0..ROUNDS {
            let Some(jax) = jax_step(&python, &script, batch) else {
                eprintln!("skipped: {} has no JAX", python.display());
                return;
            };
            let ours = [OptimiserConfig::adam(), OptimiserConfig::default()]
                .map(|optimiser| our_step(&data, batch, optimiser));
            for (best, time) in best.iter_mut().zip([jax, ours[0], ours[1]]) {
                *best = best.min(time);
            }
        }
        let [jax, adam, muon] = best;
        println!(
            "batch {batch}: JAX {jax:.1} ms; ours {adam:.1} ms, ratio {:.2}; with Muon {muon:.1} ms, {:.2}",
            adam / jax,
            muon / jax
        );
    }
}

/// Median CPU time of a step of the baseline [ms].
fn jax_step(python: &Path, script: &Path, batch: usize) -> Option<f64> {
    let arguments = ["--batch", &batch.to_string(), "--reps", &REPETITIONS.to_string()];
    let output = Command::new(python).arg(script).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let line = text.lines().find(|line| line.starts_with("pi B"))?;
    let number = line.split("'cpu_med': ").nth(1)?;
    number.split([',', '}']).next()?.trim().parse().ok()
}

/// Median CPU time of one of our steps [ms].
fn our_step(data: &DataSet, batch: usize, optimiser: OptimiserConfig) -> f64 {
    let mut trainer = trainer(data, batch, energy(data), optimiser);
    let mut step = || {
        let start = cpu_milliseconds();
        trainer.step().expect("finite loss");
        cpu_milliseconds() - start
    };
    for _ in 0..3 {
        step();
    }
    let mut times: Vec<f64> = (0..REPETITIONS).map(|_| step()).collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// CPU time of all threads of this program, as Linux counts it.
fn cpu_milliseconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("the CPU time is read as on Linux");
    let of_thread = |entry: std::io::Result<std::fs::DirEntry>| -> Option<f64> {
        let text = std::fs::read_to_string(entry.ok()?.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse().ok()
    };
    tasks.filter_map(of_thread).sum::<f64>() / 1e6
}
