//! Parallel loops over one loop of rayon.
//!
//! Each of rayon's iterators is compiled again for every closure and collection, some 3 000 lines of LLVM's input a time.

use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A value of each part, on all threads of the current pool, in the order of the parts.
///
/// ```
/// use sinew_num::in_parallel;
///
/// let mut numbers = vec![1.0; 1000];
/// let sums = in_parallel(numbers.chunks_mut(300).enumerate(), |(index, chunk)| {
///     chunk.fill(index as f64);
///     chunk.iter().sum::<f64>()
/// });
/// assert_eq!(sums, [0.0, 300.0, 600.0, 300.0]);
/// ```
pub fn in_parallel<P: Send, T: Send>(
    parts: impl IntoIterator<Item = P>,
    value: impl Fn(P) -> T + Sync,
) -> Vec<T> {
    const ONCE: &str = "each part is taken once";
    let slot = |part| Mutex::new((Some(part), None));
    let slots: Vec<Mutex<(Option<P>, Option<T>)>> = parts.into_iter().map(slot).collect();
    each(slots.len(), &|index| {
        let (part, found) = &mut *slots[index].lock().expect(ONCE);
        *found = part.take().map(&value);
    });
    slots.into_iter().map(|slot| slot.into_inner().expect(ONCE).1.expect(ONCE)).collect()
}

/// Values of the parts as by [`in_parallel`], or an error: no part begins after one that fails.
///
/// ```
/// use sinew_num::try_in_parallel;
///
/// let root = |x: f64| if x < 0.0 { Err("negative") } else { Ok(x.sqrt()) };
/// assert_eq!(try_in_parallel([4.0, 9.0], root), Ok(vec![2.0, 3.0]));
/// assert_eq!(try_in_parallel([4.0, -9.0], root), Err("negative"));
/// ```
///
/// # Errors
/// The first error in the order of the parts that ran.
pub fn try_in_parallel<P: Send, T: Send, E: Send>(
    parts: impl IntoIterator<Item = P>,
    value: impl Fn(P) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let failed = AtomicBool::new(false);
    let found = in_parallel(parts, |part| {
        (!failed.load(Ordering::Relaxed))
            .then(|| value(part).inspect_err(|_| failed.store(true, Ordering::Relaxed)))
    });
    found.into_iter().flatten().collect()
}

/// A value of each of `0..count` in their order, on all threads, by tasks of `grain` that follow each other.
///
/// ```
/// assert_eq!(sinew_num::in_tasks(5, 2, |index| 10 * index), [0, 10, 20, 30, 40]);
/// ```
///
/// # Panics
/// A `grain` of zero.
pub fn in_tasks<T: Clone + Default + Send>(
    count: usize,
    grain: usize,
    value: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let mut values = vec![T::default(); count];
    fill(&mut values, grain, value);
    values
}

/// Overwrites each entry of a slice with a value of its index, on all threads, by tasks of `grain` that follow each other.
///
/// ```
/// let mut entries = [0; 5];
/// sinew_num::fill(&mut entries, 2, |index| 10 * index);
/// assert_eq!(entries, [0, 10, 20, 30, 40]);
/// ```
///
/// # Panics
/// A `grain` of zero.
pub fn fill<T: Send>(entries: &mut [T], grain: usize, value: impl Fn(usize) -> T + Sync) {
    in_parallel(entries.chunks_mut(grain).enumerate(), |(task, entries)| {
        entries.iter_mut().zip(grain * task..).for_each(|(entry, index)| *entry = value(index));
    });
}

fn each(count: usize, task: &(dyn Fn(usize) + Sync)) {
    match count {
        0 | 1 => (0..count).for_each(task),
        _ => (0..count).into_par_iter().for_each(task),
    }
}
