//! Threads that stay awake.

use rayon::prelude::*;
use sinew_num::{in_parallel, on_ready_threads};

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

/// Two waiting threads that lie above each other's work would wait for ever.
#[test]
fn works_of_several_threads_end() {
    let parts = || {
        in_parallel(0..16, |i| (0..20_000_u64).map(|k| std::hint::black_box(k ^ i)).sum::<u64>())
            .len()
    };
    let works = || (0..400).map(|_| on_ready_threads(parts)).sum::<usize>();
    for threads in 2..4 {
        let counts = pool(threads).install(|| in_parallel(0..8, |_| works()));
        assert_eq!(counts, [6400; 8]);
    }
}

#[test]
fn a_panic_of_the_work_comes_through() {
    let outcome = std::panic::catch_unwind(|| {
        pool(2).install(|| on_ready_threads(|| panic!("of the work")));
    });
    assert!(outcome.is_err());
    assert_eq!(pool(2).install(|| on_ready_threads(|| 1)), 1);
}
