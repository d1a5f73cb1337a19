//! Threads that stay awake.

use rayon::prelude::*;
use sinew_num::on_ready_threads;

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

#[test]
fn work_runs_once_on_any_number_of_threads() {
    for threads in 1..4 {
        let sum = pool(threads).install(|| {
            on_ready_threads(|| (0..100_u64).into_par_iter().map(|i| i * i).sum::<u64>())
        });
        assert_eq!(sum, 328_350);
    }
}

#[test]
fn a_panic_of_the_work_comes_through() {
    let outcome = std::panic::catch_unwind(|| {
        pool(2).install(|| on_ready_threads(|| panic!("of the work")));
    });
    assert!(outcome.is_err());
}
