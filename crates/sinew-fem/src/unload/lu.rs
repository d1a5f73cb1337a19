//! Factors L U of matrices that are not symmetric but have entries in symmetric places.
//!
//! Columns of one structure are eliminated together, with partial pivoting among their rows (Duff, Erisman & Reid, *Direct Methods for Sparse
//! Matrices*, 10.5). Order and structure are those of the stiffness' Cholesky factor.

use crate::elements::turn_square;
use crate::linear::{Factor, Sparsity};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::linalg::matmul::matmul;
use faer::perm::PermRef;
use faer::{Accum, Mat, MatMut, Par};
use std::ops::Range;
use std::sync::Arc;

/// Values of an unsymmetric matrix in the places of a [`Sparsity`], with one more slot each for what is prescribed.
#[derive(Clone, Debug)]
pub(super) struct Entries {
    /// Lower half by columns.
    pub lower: Vec<f64>,
    /// Upper half by rows, in the same places.
    pub upper: Vec<f64>,
}

impl Entries {
    pub(super) fn zero(sparsity: &Sparsity) -> Self {
        let zeros = vec![0.0; sparsity.entries() + 1];
        Self { lower: zeros.clone(), upper: zeros }
    }

    /// The matrix times a vector.
    pub(super) fn multiply(&self, sparsity: &Sparsity, from: &[f64], to: &mut [f64]) {
        sparsity.multiply([&self.lower, &self.upper], from, to);
    }

    /// Adds a square matrix over the Cartesian components of some nodes, row by row; `places` are those of the sparsity, if it has
    /// them for these nodes, else they are looked up.
    pub(super) fn add(
        &mut self,
        sparsity: &Sparsity,
        nodes: &[usize],
        places: Option<&[u32]>,
        matrix: &mut [f64],
    ) {
        turn_square(&sparsity.frames, nodes, matrix);
        let size = 3 * nodes.len();
        let unknown = |local: usize| sparsity.unknown(3 * nodes[local / 3] + local % 3);
        for row in 0..size {
            for column in 0..=row {
                let (Some(r), Some(c)) = (unknown(row), unknown(column)) else { continue };
                let slot = match places {
                    Some(places) => places[row * (row + 1) / 2 + column] as usize,
                    None => sparsity.slot(r, c),
                };
                let (direct, mirrored) = (matrix[row * size + column], matrix[column * size + row]);
                let (lower, upper) = if r >= c { (direct, mirrored) } else { (mirrored, direct) };
                self.lower[slot] += lower;
                self.upper[slot] += upper;
            }
        }
    }
}

/// Unknowns that are eliminated together, and the later ones that these depend on, ascending.
struct Front {
    own: Range<usize>,
    later: Vec<usize>,
}

impl Front {
    /// Place of an unknown in the front.
    fn place(&self, unknown: usize) -> usize {
        match unknown < self.own.end {
            true => unknown - self.own.start,
            false => self.own.len() + self.later.partition_point(|&row| row < unknown),
        }
    }
}

/// Numbers of a front.
struct Block {
    /// L and U of `A₁₁`, above `A₂₁`.
    columns: Mat<f64>,
    /// `A₁₁⁻¹ A₁₂`.
    right: Mat<f64>,
    /// Order of the rows of `A₁₁`, and its inverse.
    order: [Vec<usize>; 2],
}

/// A factor of an unsymmetric matrix; a clone shares what was factorised last until it factorises itself.
#[derive(Clone)]
pub(super) struct Lu {
    fronts: Arc<Vec<Front>>,
    blocks: Arc<Vec<Block>>,
}

impl Lu {
    /// The fronts of a symmetric matrix with entries in the same places.
    pub(super) fn new(symmetric: &Factor) -> Self {
        let fronts = symmetric.supernodes().into_iter();
        let fronts = fronts.map(|(own, below)| Front { own, later: below.to_vec() }).collect();
        Self { fronts: Arc::new(fronts), blocks: Arc::default() }
    }

    /// Whether something was factorised.
    pub(super) fn is_ready(&self) -> bool {
        self.blocks.len() == self.fronts.len()
    }

    /// Factorises; false where a pivot vanishes or is not finite.
    pub(super) fn factorise(&mut self, sparsity: &Sparsity, entries: &Entries) -> bool {
        self.blocks = Arc::default();
        let block = |front: &Front| Block::new(front, sparsity, entries);
        let mut blocks: Vec<_> = self.fronts.iter().map(block).collect();
        for (Front { own, later }, at) in self.fronts.iter().zip(0..) {
            let block = &mut blocks[at];
            if !block.eliminate() {
                return false;
            }
            let mut change = Mat::<f64>::zeros(later.len(), later.len());
            let (_, below) = block.columns.as_ref().split_at_row(own.len());
            matmul(change.as_mut(), Accum::Add, below, block.right.as_ref(), -1.0, Par::Seq);
            // Each part of the change goes to the front that eliminates it.
            let mut first = 0;
            while let Some(&row) = later.get(first) {
                let next = self.fronts.partition_point(|front| front.own.end <= row);
                let (front, Block { columns, right, .. }) = (&self.fronts[next], &mut blocks[next]);
                let places: Vec<_> = later[first..].iter().map(|&row| front.place(row)).collect();
                let own = places.partition_point(|&place| place < front.own.len());
                for (column, &place) in (first..).zip(&places) {
                    let (to, rows) = match place.checked_sub(front.own.len()) {
                        None => (columns.col_as_slice_mut(place), &places[..]),
                        Some(place) => (right.col_as_slice_mut(place), &places[..own]),
                    };
                    let from = &change.col_as_slice(column)[first..];
                    rows.iter().zip(from).for_each(|(&row, x)| to[row] += x);
                }
                first += own;
            }
        }
        self.blocks = Arc::new(blocks);
        true
    }

    /// Overwrites a right-hand side with the solution of the last factorised system.
    pub(super) fn solve(&self, right: &mut [f64]) {
        let fronts = || self.fronts.iter().zip(&*self.blocks);
        for (Front { own, later }, block) in fronts() {
            let mut own_part =
                MatMut::from_column_major_slice_mut(&mut right[own.clone()], own.len(), 1);
            block.solve(own_part.as_mut());
            let mut change = Mat::<f64>::zeros(later.len(), 1);
            let (_, below) = block.columns.as_ref().split_at_row(own.len());
            matmul(change.as_mut(), Accum::Add, below, own_part.as_ref(), -1.0, Par::Seq);
            later.iter().zip(change.col_as_slice(0)).for_each(|(&row, x)| right[row] += x);
        }
        for (Front { own, later }, block) in fronts().rev() {
            let known = Mat::from_fn(later.len(), 1, |i, _| right[later[i]]);
            let own_part =
                MatMut::from_column_major_slice_mut(&mut right[own.clone()], own.len(), 1);
            matmul(own_part, Accum::Add, block.right.as_ref(), known.as_ref(), -1.0, Par::Seq);
        }
    }
}

impl Block {
    /// The matrix' entries in the eliminated columns and rows.
    fn new(front: &Front, sparsity: &Sparsity, entries: &Entries) -> Self {
        let (own, later) = (front.own.len(), front.later.len());
        let mut columns = Mat::zeros(own + later, own);
        let mut right = Mat::zeros(own, later);
        let (starts, rows) = (sparsity.pattern.col_ptr(), sparsity.pattern.row_idx());
        for (at, column) in front.own.clone().enumerate() {
            for slot in starts[column]..starts[column + 1] {
                let place = front.place(rows[slot]);
                columns[(place, at)] = entries.lower[slot];
                match place.checked_sub(own) {
                    None => columns[(at, place)] = entries.upper[slot],
                    Some(place) => right[(at, place)] = entries.upper[slot],
                }
            }
        }
        Self { columns, right, order: [vec![0; own], vec![0; own]] }
    }

    /// Factorises `A₁₁`; false where a pivot vanishes or is not finite.
    fn eliminate(&mut self) -> bool {
        let own = self.columns.ncols();
        let scratch =
            factor::lu_in_place_scratch::<usize, f64>(own, own, Par::Seq, Default::default());
        let (mut memory, [order, inverse]) = (MemBuffer::new(scratch), &mut self.order);
        let (mut square, _) = self.columns.as_mut().split_at_row_mut(own);
        let stack = MemStack::new(&mut memory);
        factor::lu_in_place(square.as_mut(), order, inverse, Par::Seq, stack, Default::default());
        let usable = (0..own).all(|i| square[(i, i)] != 0.0 && square[(i, i)].is_finite());
        if usable {
            let mut right = std::mem::replace(&mut self.right, Mat::new());
            self.solve(right.as_mut());
            self.right = right;
        }
        usable
    }

    /// Overwrites right-hand sides with the solutions of `A₁₁`.
    fn solve(&self, right: MatMut<'_, f64>) {
        let own = self.columns.ncols();
        let (triangles, _) = self.columns.as_ref().split_at_row(own);
        let order = PermRef::new_checked(&self.order[0], &self.order[1], own);
        let scratch = solve::solve_in_place_scratch::<usize, f64>(own, right.ncols(), Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        solve::solve_in_place(triangles, triangles, order, right, Par::Seq, stack);
    }
}
