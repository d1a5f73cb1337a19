//! Threads that stay awake between short parallel parts.

use rayon::Yield;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs `work` on a thread of the current pool, while another one waits for its parallel parts without going to sleep.
///
/// A training step or an evaluation of an evidence is a number of parallel parts of a tenth of a millisecond each, with little in
/// between; waking a sleeping thread takes as long as such a part. The waiting thread gives way to other programs. A pool of
/// one thread runs the work and its parallel parts without ever handing over.
///
/// Works of several threads do not block each other: threads steal the oldest part first, so that parts of a work are taken only after its waiting
/// thread, and each waits for work that began later than its own.
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
