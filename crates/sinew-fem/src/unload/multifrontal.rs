//! Factors of matrices that are not symmetric but have entries in symmetric places: the multifrontal method.
//!
//! I. S. Duff, J. K. Reid, ACM Trans. Math. Software 9 (1983). Columns of one structure are eliminated together in a dense front,
//! with partial pivoting among their rows; the Schur complement is added to the front of the parent. The order is that
//! of the
//! stiffness, so that fill is that of its Cholesky factor.

use crate::linear::sparsity::Sparsity;
use crate::linear::vector::add;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve as triangular;
use faer::prelude::IntoConst;
use faer::{Accum, Mat, Par};
use std::sync::Arc;

/// Largest growth of a front when a column joins it \[relative to its entries\].
const PADDING: f64 = 0.2;

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
}

/// Columns that are eliminated together.
#[derive(Debug)]
struct Front {
    /// The unknowns of the front, ascending: first those that are eliminated.
    rows: Vec<usize>,
    eliminated: usize,
    children: Vec<usize>,
}

/// Numbers of a front: `P A₁₁ = L U`, `A₂₁ U⁻¹` and the transpose of `L⁻¹ P A₁₂`.
#[derive(Debug)]
struct Block {
    triangles: Mat<f64>,
    order: Vec<usize>,
    below: Mat<f64>,
    right: Mat<f64>,
}

/// A factor of an unsymmetric matrix.
#[derive(Debug)]
pub(super) struct Multifrontal {
    fronts: Arc<Vec<Front>>,
    blocks: Arc<Vec<Block>>,
}

impl Multifrontal {
    /// Finds the fronts of a sparsity.
    pub(super) fn new(sparsity: &Sparsity) -> Self {
        let size = sparsity.unknowns();
        let (starts, rows) = (sparsity.pattern.col_ptr(), sparsity.pattern.row_idx());
        let mut fronts: Vec<Front> = Vec::new();
        // Fronts whose first remaining row is a column.
        let mut waiting: Vec<Vec<usize>> = vec![Vec::new(); size];
        for column in 0..size {
            let children = std::mem::take(&mut waiting[column]);
            let mut structure = rows[starts[column]..starts[column + 1]].to_vec();
            for &child in &children {
                structure.extend(&fronts[child].rows[fronts[child].eliminated..]);
            }
            structure.sort_unstable();
            structure.dedup();
            let at = match children.iter().position(|&child| joins(&fronts, child, &structure)) {
                Some(position) => {
                    let at = children[position];
                    let Front { rows, eliminated, .. } = &mut fronts[at];
                    rows.truncate(*eliminated);
                    rows.extend(&structure);
                    *eliminated += 1;
                    let others = children.iter().filter(|&&child| child != at).copied();
                    fronts[at].children.extend(others.collect::<Vec<_>>());
                    at
                }
                None => {
                    fronts.push(Front { rows: structure, eliminated: 1, children });
                    fronts.len() - 1
                }
            };
            if let Some(&parent) = fronts[at].rows.get(fronts[at].eliminated) {
                waiting[parent].push(at);
            }
        }
        Self { fronts: Arc::new(in_order(fronts)), blocks: Arc::default() }
    }

    /// Another one, which shares what was factorised last until it factorises itself.
    pub(super) fn fresh(&self) -> Self {
        Self { fronts: self.fronts.clone(), blocks: self.blocks.clone() }
    }

    /// Whether something was factorised.
    pub(super) fn is_ready(&self) -> bool {
        self.blocks.len() == self.fronts.len()
    }

    /// Factorises; false where a pivot vanishes or is not finite.
    pub(super) fn factorise(&mut self, sparsity: &Sparsity, entries: &Entries) -> bool {
        self.blocks = Arc::default();
        let mut blocks = Vec::with_capacity(self.fronts.len());
        // Fronts whose eliminated part is done with.
        let mut left: Vec<Option<Mat<f64>>> = Vec::with_capacity(self.fronts.len());
        let mut local = vec![usize::MAX; sparsity.unknowns()];
        for front in self.fronts.iter() {
            front.rows.iter().enumerate().for_each(|(at, &row)| local[row] = at);
            let mut dense = Mat::<f64>::zeros(front.rows.len(), front.rows.len());
            scatter(sparsity, entries, front, &local, &mut dense);
            for &child in &front.children {
                let Some(part) = left[child].take() else { continue };
                let Front { rows, eliminated, .. } = &self.fronts[child];
                let rows = &rows[*eliminated..];
                for (j, &column) in rows.iter().enumerate() {
                    let to = dense.col_as_slice_mut(local[column]);
                    let from = &part.col_as_slice(eliminated + j)[*eliminated..];
                    rows.iter().zip(from).for_each(|(&row, value)| to[local[row]] += value);
                }
            }
            let Some(block) = eliminate(&mut dense, front.eliminated) else { return false };
            blocks.push(block);
            left.push(Some(dense));
        }
        self.blocks = Arc::new(blocks);
        true
    }

    /// Overwrites a right-hand side with the solution of the last factorised system.
    pub(super) fn solve(&self, right: &mut [f64]) {
        let fronts = || self.fronts.iter().zip(&*self.blocks);
        let (mut own, mut rest) = (Vec::new(), Vec::new());
        for (front, block) in fronts() {
            let (eliminated, others) = front.rows.split_at(front.eliminated);
            own.clear();
            own.extend(block.order.iter().map(|&at| right[eliminated[at]]));
            rest.clear();
            rest.resize(others.len(), 0.0);
            for at in 0..own.len() {
                let value = own[at];
                add(&mut own[at + 1..], -value, &block.triangles.col_as_slice(at)[at + 1..]);
                add(&mut rest, value, block.below.col_as_slice(at));
            }
            eliminated.iter().zip(&own).for_each(|(&row, value)| right[row] = *value);
            others.iter().zip(&rest).for_each(|(&row, value)| right[row] -= value);
        }
        for (front, block) in fronts().rev() {
            let (eliminated, others) = front.rows.split_at(front.eliminated);
            rest.clear();
            rest.extend(others.iter().map(|&row| right[row]));
            own.clear();
            let columns = eliminated.iter().enumerate();
            own.extend(
                columns.map(|(at, &row)| right[row] - dot(&rest, block.right.col_as_slice(at))),
            );
            for at in (0..own.len()).rev() {
                let column = block.triangles.col_as_slice(at);
                let value = own[at] / column[at];
                own[at] = value;
                add(&mut own[..at], -value, &column[..at]);
            }
            eliminated.iter().zip(&own).for_each(|(&row, value)| right[row] = *value);
        }
    }
}

/// Product of two vectors, in sums that a processor takes at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|i| sums[i] += a[i] * b[i]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Whether a column of some structure joins the front of a child: it follows that front's columns, and adds few entries.
fn joins(fronts: &[Front], child: usize, structure: &[usize]) -> bool {
    let Front { rows, eliminated, .. } = &fronts[child];
    let follows = rows[*eliminated - 1] + 1 == structure[0];
    let added = (structure.len() + eliminated - rows.len()) * eliminated;
    follows && added as f64 <= PADDING * ((structure.len() + eliminated) * (eliminated + 1)) as f64
}

/// Fronts with children before their parents, numbered anew.
fn in_order(fronts: Vec<Front>) -> Vec<Front> {
    let mut order: Vec<_> = (0..fronts.len()).collect();
    order.sort_by_key(|&at| fronts[at].rows[fronts[at].eliminated - 1]);
    let mut place = vec![0; fronts.len()];
    order.iter().enumerate().for_each(|(new, &old)| place[old] = new);
    let mut moved: Vec<Option<Front>> = fronts.into_iter().map(Some).collect();
    let renumbered = order.into_iter().filter_map(|at| moved[at].take());
    let renumber = |front: Front| {
        let children = front.children.iter().map(|&child| place[child]).collect();
        Front { children, ..front }
    };
    renumbered.map(renumber).collect()
}

/// Adds the matrix' entries of the eliminated columns and rows.
fn scatter(
    sparsity: &Sparsity,
    entries: &Entries,
    front: &Front,
    local: &[usize],
    dense: &mut Mat<f64>,
) {
    let (starts, rows) = (sparsity.pattern.col_ptr(), sparsity.pattern.row_idx());
    for (at, &column) in front.rows[..front.eliminated].iter().enumerate() {
        let range = starts[column]..starts[column + 1];
        let lower = dense.col_as_slice_mut(at);
        range.clone().for_each(|slot| lower[local[rows[slot]]] += entries.lower[slot]);
        for slot in range {
            let row = local[rows[slot]];
            if row != at {
                dense.col_as_slice_mut(row)[at] += entries.upper[slot];
            }
        }
    }
}

/// Eliminates the first unknowns of a front; the rest of it is for the parent.
fn eliminate(dense: &mut Mat<f64>, count: usize) -> Option<Block> {
    let (mut order, mut inverse) = (vec![0; count], vec![0; count]);
    let scratch = lu_in_place_scratch::<usize, f64>(count, count, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    let size = dense.nrows();
    let (mut own, right, mut below, rest) = dense.as_mut().split_at_mut(count, count);
    let right = right.into_const();
    lu_in_place(
        own.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    );
    let usable = (0..count).all(|i| own[(i, i)] != 0.0 && own[(i, i)].is_finite());
    if !usable {
        return None;
    }
    let triangles = own.as_ref();
    let mut ordered = Mat::<f64>::zeros(size - count, count);
    for (at, &from) in order.iter().enumerate() {
        let to = ordered.col_as_slice_mut(at).iter_mut();
        to.zip(right.row(from).iter()).for_each(|(to, from)| *to = *from);
    }
    let turned = ordered.as_mut().transpose_mut();
    triangular::solve_unit_lower_triangular_in_place(triangles, turned, Par::Seq);
    // A₂₁ U⁻¹ by its transpose.
    let transposed = below.as_mut().transpose_mut();
    triangular::solve_lower_triangular_in_place(triangles.transpose(), transposed, Par::Seq);
    matmul(rest, Accum::Add, below.as_ref(), ordered.as_ref().transpose(), -1.0, Par::Seq);
    let (triangles, below) = (triangles.to_owned(), below.as_ref().to_owned());
    Some(Block { triangles, order, below, right: ordered })
}
