//! Threads that stay awake between short parallel parts.

use rayon::Yield;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs `work` on a thread of the current pool, while another one waits for its parallel parts without going to sleep.
///
/// A training step or an evaluation of an evidence is a number of parallel parts of a tenth of a millisecond each, with little in
/// between; waking a sleeping thread takes as long as such a part. The waiting thread gives way to other programs. A pool of
/// one thread runs the work and its parallel parts without ever handing over.
pub fn on_ready_threads<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let done = AtomicBool::new(false);
    let work = || {
        let _finished = SetOnDrop(&done);
        work()
    };
    let wait = || {
        while !done.load(Ordering::Acquire) {
            if rayon::yield_now() != Some(Yield::Executed) {
                std::thread::yield_now();
            }
        }
    };
    rayon::join(work, wait).0
}

/// Ends the waiting even if the work panics.
struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::on_ready_threads;
    use rayon::prelude::*;

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
}
