//! Scratch memory reused between training steps.
//!
//! A step needs some tens of megabytes of activations. Fresh pages from the operating system cost
//! a fault per 4 KiB, a tenth of the step; buffers returned here are handed out again, and the
//! allocator is brought to keep what Burn's tensors free.

use bytemuck::{Pod, Zeroable};
use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, Once, PoisonError};

/// Memory kept for reuse; beyond it, returned buffers are freed.
const KEPT_BYTES: usize = 256 << 20;

/// A buffer is not given to a request smaller than this part of it.
const LARGEST_MISFIT: usize = 4;

/// Numbers of a cache line, at its place: registers are as wide at most, and loads
/// across two lines cost twice.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

/// Numbers of a cache line.
pub(crate) const LINE: usize = 16;

static SHELF: Mutex<Vec<Vec<Line>>> = Mutex::new(Vec::new());

/// Freeing a block of this size raises the threshold above which glibc's allocator returns memory to the system,
/// so that later blocks up to this size come from memory that it keeps; with other allocators the block is allocated and freed without touching a page.
const LESSON_BYTES: usize = (32 << 20) - (64 << 10);

static LESSON: Once = Once::new();

/// Lets glibc keep up to twice [`LESSON_BYTES`] of freed memory instead of returning it after
/// every step.
///
/// Its allocator maps large blocks afresh, and raises the size from which it does, and the amount
/// of free memory it trims, whenever such a block is freed (mallopt(3), `M_MMAP_THRESHOLD`).
pub(crate) fn keep_freed_memory() {
    LESSON.call_once(|| drop(std::hint::black_box(Vec::<u8>::with_capacity(LESSON_BYTES))));
}

/// A borrowed stretch of numbers with unspecified content, returned when dropped.
#[derive(Debug)]
pub(crate) struct Buffer {
    lines: Vec<Line>,
    len: usize,
}

impl Buffer {
    /// `len` numbers, whatever they hold.
    pub(crate) fn take(len: usize) -> Self {
        let count = len.div_ceil(LINE);
        let mut lines = best_fit(count).unwrap_or_default();
        if lines.len() < count {
            lines.resize(count, Line([0.0; LINE]));
        }
        Self { lines, len }
    }

    /// `len` zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        let mut buffer = Self::take(len);
        buffer.fill(0.0);
        buffer
    }
}

/// The smallest buffer on the shelf that holds `count` lines.
fn best_fit(count: usize) -> Option<Vec<Line>> {
    let mut shelf = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
    let (index, _) = shelf
        .iter()
        .enumerate()
        .filter(|(_, lines)| lines.len() >= count && lines.len() / LARGEST_MISFIT <= count)
        .min_by_key(|(_, lines)| lines.len())?;
    Some(shelf.swap_remove(index))
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let lines = std::mem::take(&mut self.lines);
        let mut shelf = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
        let kept: usize = shelf.iter().map(Vec::len).sum();
        if (kept + lines.len()) * size_of::<Line>() <= KEPT_BYTES {
            shelf.push(lines);
        }
    }
}

impl Deref for Buffer {
    type Target = [f32];
    fn deref(&self) -> &[f32] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.len]
    }
}
