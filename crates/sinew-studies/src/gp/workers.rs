//! Pieces of work side by side, each on one thread of its own.

use anyhow::Result;
use rayon::ThreadPoolBuilder;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Results of all pieces, `threads` at a time; stops at an error.
///
/// Within a piece, parallel loops find a pool of one thread: its time is that of one thread whatever runs
/// beside it, and its numbers do not depend on how many do.
pub(crate) fn each<P: Sync, T: Send>(
    threads: usize,
    pieces: &[P],
    piece: impl Fn(&P) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = || -> Result<Vec<(usize, Result<T>)>> {
        let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
        let mut done = Vec::new();
        while !failed.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(of) = pieces.get(index) else { break };
            let result = pool.install(|| piece(of));
            failed.fetch_or(result.is_err(), Ordering::Relaxed);
            done.push((index, result));
        }
        Ok(done)
    };
    // A scope of its own, for threads of a pool that wait for another pool take further pieces meanwhile.
    let joined = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join()).collect::<Vec<_>>()
    });
    let mut done = Vec::with_capacity(pieces.len());
    for found in joined {
        done.extend(found.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
    }
    done.sort_by_key(|&(index, _)| index);
    done.into_iter().map(|(_, result)| result).collect()
}
