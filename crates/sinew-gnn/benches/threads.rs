//! Training steps on one and on two threads, in turns: wall time, and the speed-up with its error.
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
    let pool = |threads| {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        builder.build().expect("threads start")
    };
    let pools = [pool(1), pool(2)];
    for batch in [1, 8, 32, 200] {
        let mut trainers =
            [(); 2].map(|()| trainer(&data, batch, energy(&data), OptimiserConfig::default()));
        let mut seconds = [vec![], vec![]];
        let mut losses = [0.0; 2];
        for turn in 0..WARM_UP + TURNS {
            for which in 0..2 {
                let trainer = &mut trainers[which];
                let start = Instant::now();
                losses[which] = pools[which].install(|| trainer.step().expect("finite loss").loss);
                if turn >= WARM_UP {
                    seconds[which].push(start.elapsed().as_secs_f64());
                }
            }
        }
        assert_eq!(losses[0], losses[1], "numbers do not depend on the threads");
        let [one, two] = seconds.map(|mut times| {
            times.sort_by(f64::total_cmp);
            1e3 * times[times.len() / 2]
        });
        println!(
            "batch {batch}: one thread {one:.1} ms, two {two:.1} ms: {:.2} times as fast, difference of the losses 0",
            one / two
        );
    }
}
