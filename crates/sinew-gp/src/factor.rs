//! Cholesky factors.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::{MatMut, MatRef, Par};
use rayon::prelude::*;

use crate::buffer::Buffer;

/// A lower triangular matrix, stored column by column; what is above the diagonal means nothing.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    entries: Buffer,
    size: usize,
}

impl Factor {
    /// Of a symmetric matrix by its lower triangle; none where it is not positive
    /// definite or not finite.
    pub fn new(mut entries: Buffer, size: usize, par: Par) -> Option<Self> {
        let finite = |(number, column): (usize, &[f64])| {
            column[number..].iter().all(|entry| entry.is_finite())
        };
        let all_finite = match par {
            Par::Seq => entries.chunks(size.max(1)).enumerate().all(finite),
            Par::Rayon(_) => entries.par_chunks(size.max(1)).enumerate().all(finite),
        };
        if !all_finite {
            return None;
        }
        let scratch = cholesky_in_place_scratch::<f64>(size, par, Default::default());
        cholesky_in_place(
            MatMut::from_column_major_slice_mut(&mut entries, size, size),
            LltRegularization::default(),
            par,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        )
        .ok()?;
        Some(Self { entries, size })
    }

    pub fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.entries, self.size, self.size)
    }

    /// Rows at and below the diagonal of a column.
    pub fn column(&self, column: usize) -> &[f64] {
        &self.entries[column * self.size + column..(column + 1) * self.size]
    }

    /// x ← L⁻¹ x.
    pub fn forward(&self, x: &mut [f64]) {
        for column in 0..x.len() {
            let (pivot, below) = self.column(column).split_first().expect("a diagonal entry");
            let (value, rest) = x[column..].split_first_mut().expect("a column of x");
            *value /= pivot;
            rest.iter_mut().zip(below).for_each(|(x, l)| *x -= *value * l);
        }
    }

    /// x ← L⁻ᵀ x, for the leading rows of L as many as x has.
    pub fn backward(&self, x: &mut [f64]) {
        for column in (0..x.len()).rev() {
            let (pivot, below) = self.column(column).split_first().expect("a diagonal entry");
            let (value, rest) = x[column..].split_first_mut().expect("a column of x");
            *value = (*value - rest.iter().zip(below).map(|(x, l)| x * l).sum::<f64>()) / pivot;
        }
    }
}
