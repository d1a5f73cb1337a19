//! Pieces of work side by side, each on one thread of its own.

use anyhow::Result;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

/// Results of all pieces, `threads` at a time; stops at an error.
///
/// Within a piece, parallel loops find a pool of one thread: its time is that of one thread whatever runs
/// beside it, and its numbers do not depend on how many do.
pub(crate) fn each<P: Sync, T: Send>(
    threads: usize,
    pieces: &[P],
    piece: impl Fn(&P) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    let one = |of: &P| pool(1)?.install(|| piece(of));
    // One after the other, so that the first come first.
    pool(threads)?.install(|| pieces.par_iter().with_max_len(1).map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_piece_is_done_once_on_one_thread() {
        let pieces: Vec<usize> = (0..50).collect();
        let done = each(3, &pieces, |number| {
            assert_eq!(rayon::current_num_threads(), 1);
            Ok(2 * number)
        });
        assert_eq!(done.unwrap(), pieces.iter().map(|number| 2 * number).collect::<Vec<_>>());
    }

    #[test]
    fn an_error_stops_the_rest() {
        let done = AtomicUsize::new(0);
        let pieces: Vec<usize> = (0..100).collect();
        let error = each(1, &pieces, |number| {
            done.fetch_add(1, Ordering::Relaxed);
            if *number == 3 { bail!("piece {number}") } else { Ok(()) }
        });
        assert_eq!(error.unwrap_err().to_string(), "piece 3");
        assert!(done.into_inner() < 100);
    }
}
