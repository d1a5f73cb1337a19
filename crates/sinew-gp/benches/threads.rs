//! Evidence and gradient on one and on two threads, in turns: wall time, speed-up and the gradient's error.
//!
//! `cargo bench --profile dev -p sinew-gp --bench threads -- 600 1200 4000`, on a machine that
//! does nothing else. The memory is the largest of the whole program so far, as Linux counts it.

mod heat;

use crate::heat::{heat, middle, relative_error};
use sinew_gp::{Evidence, GpError};
use std::hint::black_box;
use std::time::Instant;

/// Time spent on each size [s].
const SECONDS: f64 = 6.0;
/// Larger ones are not differentiated by differences, which would take minutes.
const LARGEST_CHECKED: usize = 1200;

fn main() -> Result<(), GpError> {
    let pools = [1, 2].map(|threads| {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        builder.build().expect("threads start")
    });
    let sizes: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    for size in if sizes.is_empty() { vec![600, 1200] } else { sizes } {
        let model = heat(size, Evidence::Joint)?;
        let at = middle(&model);
        let mut seconds = [vec![], vec![]];
        let mut gradients = [vec![], vec![]];
        let start = Instant::now();
        while seconds[1].len() < 2 || start.elapsed().as_secs_f64() < SECONDS {
            for ((pool, seconds), gradient) in pools.iter().zip(&mut seconds).zip(&mut gradients) {
                let start = Instant::now();
                *gradient = pool.install(|| model.evaluate(black_box(&at)))?.gradient;
                seconds.push(start.elapsed().as_secs_f64());
            }
        }
        assert_eq!(gradients[0], gradients[1], "the bits do not depend on the threads");
        let [one, two] = seconds.map(|mut times| {
            times.sort_by(f64::total_cmp);
            1e3 * times[times.len() / 2]
        });
        let error = match size <= LARGEST_CHECKED {
            true => format!("{:.1e}", relative_error(&model, &at)?),
            false => "not checked".to_string(),
        };
        println!(
            "N = {size}: one thread {one:.1} ms, two {two:.1} ms, ratio {:.2}; the same bits, error of the gradient {error}; \
             at most {} MB",
            one / two,
            largest_memory_mb(),
        );
    }
    Ok(())
}

fn largest_memory_mb() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<usize>().ok());
    kilobytes.unwrap_or(0) / 1000
}
