//! Training steps on one and on two threads, in turns: wall time and speed-up; the losses agree to the last bit.
//!
//! `cargo bench --profile dev -p sinew-gnn --bench threads`, on a machine that does nothing else.

mod beam;

use std::time::Instant;

use sinew_gnn::OptimiserConfig;

use crate::beam::{beam, energy, trainer};

const TURNS: usize = 15;
const WARM_UP: usize = 3;

fn main() {
    let data = beam();
    let pools = [1, 2].map(|threads| {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        builder.build().expect("threads start")
    });
    let batches: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let batches = if batches.is_empty() { vec![1, 8, 32, 200] } else { batches };
    for batch in batches {
        let mut trainers =
            [(); 2].map(|()| trainer(&data, batch, energy(&data), OptimiserConfig::default()));
        let mut seconds = [vec![], vec![]];
        let mut losses = [0.0; 2];
        for turn in 0..WARM_UP + TURNS {
            for ((trainer, pool), (seconds, loss)) in
                trainers.iter_mut().zip(&pools).zip(seconds.iter_mut().zip(&mut losses))
            {
                let start = Instant::now();
                *loss = pool.install(|| trainer.step().expect("finite loss").loss);
                if turn >= WARM_UP {
                    seconds.push(start.elapsed().as_secs_f64());
                }
            }
        }
        assert_eq!(losses[0].to_bits(), losses[1].to_bits(), "losses of one and two threads");
        let [one, two] = seconds.map(|mut times| {
            times.sort_by(f64::total_cmp);
            1e3 * times[times.len() / 2]
        });
        println!(
            "batch {batch}: one thread {one:.1} ms, two {two:.1} ms, ratio {:.2}; losses agree to the last bit",
            one / two
        );
    }
}
