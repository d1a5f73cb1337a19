//! Pieces of work side by side, each on one thread of its own.

use anyhow::Result;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Does all pieces from 0 to `count`, `threads` at a time; stops at the first error.
///
/// Within a piece, parallel loops find a pool of one thread: its time is that of one thread whatever runs
/// beside it, and its numbers do not depend on how many do.
pub(crate) fn each(
    threads: usize,
    count: usize,
    piece: impl Fn(usize) -> Result<()> + Sync,
) -> Result<()> {
    let next = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    let work = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return Ok(());
            }
            pool.install(|| piece(number))?;
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads.min(count) {
            scope.spawn(|| {
                if let Err(error) = work() {
                    next.store(count, Ordering::Relaxed);
                    // The first error is the one to tell.
                    failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(error);
                }
            });
        }
    });
    failure.into_inner().unwrap_or_else(|e| e.into_inner()).map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;

    #[test]
    fn every_piece_is_done_once_on_one_thread() {
        let done: Vec<AtomicUsize> = (0..50).map(|_| AtomicUsize::new(0)).collect();
        each(3, done.len(), |number| {
            assert_eq!(rayon::current_num_threads(), 1);
            done[number].fetch_add(1, Ordering::Relaxed);
            Ok(())
        })
        .unwrap();
        assert!(done.iter().all(|count| count.load(Ordering::Relaxed) == 1));
    }

    #[test]
    fn an_error_stops_the_rest() {
        let done = AtomicUsize::new(0);
        let error = each(1, 100, |number| {
            done.fetch_add(1, Ordering::Relaxed);
            if number == 3 { bail!("piece {number}") } else { Ok(()) }
        });
        assert_eq!(error.unwrap_err().to_string(), "piece 3");
        assert_eq!(done.into_inner(), 4);
    }
}
