//! Memory of large matrices, reused between evaluations.
//!
//! A fit evaluates hundreds of times; fresh memory would be cleared by one thread every time.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Numbers kept for reuse [64 MiB]; beyond that, returned buffers are freed.
const KEPT: usize = 8 << 20;

static SHELF: Mutex<Vec<Vec<f64>>> = Mutex::new(Vec::new());

/// A borrowed stretch of numbers with unspecified content, returned when dropped.
#[derive(Debug)]
pub(crate) struct Buffer(Vec<f64>);

impl Buffer {
    /// `len` numbers, whatever they hold.
    pub fn take(len: usize) -> Self {
        let mut shelf = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
        let fitting = shelf.iter().position(|numbers| numbers.len() == len);
        let kept = fitting.map(|index| shelf.swap_remove(index));
        drop(shelf);
        Self(kept.unwrap_or_else(|| vec![0.0; len]))
    }
}

impl Clone for Buffer {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let numbers = std::mem::take(&mut self.0);
        let mut shelf = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
        let kept: usize = shelf.iter().map(Vec::len).sum();
        if numbers.is_empty() || numbers.len() > KEPT {
            return;
        }
        if kept + numbers.len() > KEPT {
            // Sizes change between models: the oldest have to go.
            shelf.clear();
        }
        shelf.push(numbers);
    }
}

impl Deref for Buffer {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

#[cfg(test)]
mod tests {
    use super::Buffer;

    #[test]
    fn memory_comes_back_in_the_size_asked_for() {
        let mut buffer = Buffer::take(12_345);
        buffer.fill(7.0);
        let copy = buffer.clone();
        drop(buffer);
        assert_eq!(Buffer::take(12_345).len(), 12_345);
        assert_eq!(Buffer::take(12_344).len(), 12_344);
        assert!(copy.iter().all(|x| *x == 7.0));
    }
}
