//! The elimination of the pivots of one dense front.

use super::trapezoid::{PANEL, Panel, Trapezoid};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt, llt};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Fronts with more operations than this are worked on by several threads.
const PARALLEL_FRONT: f64 = 2e7;

/// The kinds of factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `L Lᵀ`, which positive definite matrices have.
    Cholesky,
    /// `L D Lᵀ` with ones on the diagonal of `L`; `D` is kept in their place.
    Signed,
}

/// A pivot that cannot be eliminated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BadPivot;

/// Eliminates the pivots of a front: `columns` becomes the factor, and what the pivots change below is
/// subtracted from `update`.
///
/// The work is split the same way for any number of threads, so the numbers do not depend on it.
pub(super) fn eliminate(
    kind: Kind,
    shape: Trapezoid,
    columns: &mut [f64],
    update: &mut [f64],
    flops: f64,
) -> Result<(), BadPivot> {
    let parallel = flops > PARALLEL_FRONT;
    let mut left = &mut columns[..];
    for panel in shape.panels() {
        let (own, rest) = left.split_at_mut(panel.rows * panel.columns);
        left = rest;
        factorise_panel(kind, panel.alone(own), parallel)?;
        let source = MatRef::from_column_major_slice(own, panel.rows, panel.columns);
        let later = shape.panels().skip_while(|p| p.first <= panel.first);
        each_panel(later, left, parallel, |target, matrix| {
            subtract(kind, matrix, source, target.first - panel.first);
        });
    }
    let below = shape.rows - shape.columns;
    let update_shape = Trapezoid { rows: below, columns: below };
    let columns = &*columns;
    each_panel(update_shape.panels(), update, parallel, |target, mut matrix| {
        for panel in shape.panels() {
            let at = shape.columns + target.first - panel.first;
            subtract(kind, matrix.rb_mut(), panel.of(columns), at);
        }
    });
    Ok(())
}

/// Calls `work` for each panel with its entries, which follow each other in `entries`.
fn each_panel(
    panels: impl Iterator<Item = Panel>,
    mut entries: &mut [f64],
    parallel: bool,
    work: impl Fn(Panel, MatMut<f64>) + Sync,
) {
    let mut split = |panel: Panel| {
        let (own, rest) = std::mem::take(&mut entries).split_at_mut(panel.rows * panel.columns);
        entries = rest;
        (panel, panel.alone(own))
    };
    if parallel {
        let all: Vec<_> = panels.map(split).collect();
        all.into_par_iter().with_max_len(1).for_each(|(panel, matrix)| work(panel, matrix));
    } else {
        panels.for_each(|panel| {
            let (panel, matrix) = split(panel);
            work(panel, matrix);
        });
    }
}

/// Factorises the square at the top of a panel and solves for what is below.
fn factorise_panel(kind: Kind, panel: MatMut<f64>, parallel: bool) -> Result<(), BadPivot> {
    let width = panel.ncols();
    let (mut top, bottom) = panel.split_at_row_mut(width);
    let needed = llt::factor::cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(needed);
    let stack = MemStack::new(&mut memory);
    match kind {
        Kind::Cholesky => {
            let plain = Default::default();
            llt::factor::cholesky_in_place(
                top.rb_mut(),
                plain,
                Par::Seq,
                stack,
                Default::default(),
            )
            .map_err(|_| BadPivot)?;
        }
        Kind::Signed => {
            let plain = Default::default();
            ldlt::factor::cholesky_in_place(
                top.rb_mut(),
                plain,
                Par::Seq,
                stack,
                Default::default(),
            )
            .map_err(|_| BadPivot)?;
        }
    }
    let top = top.rb();
    let solve = |rows: MatMut<f64>| match kind {
        Kind::Cholesky => {
            triangular_solve::solve_lower_triangular_in_place(top, rows.transpose_mut(), Par::Seq);
        }
        Kind::Signed => {
            let mut rows = rows;
            triangular_solve::solve_unit_lower_triangular_in_place(
                top,
                rows.rb_mut().transpose_mut(),
                Par::Seq,
            );
            for column in 0..width {
                let pivot = top[(column, column)];
                rows.rb_mut().col_mut(column).iter_mut().for_each(|x| *x /= pivot);
            }
        }
    };
    in_row_blocks(bottom, parallel, &solve);
    Ok(())
}

/// Calls `work` on blocks of rows of a matrix.
fn in_row_blocks(matrix: MatMut<f64>, parallel: bool, work: &(impl Fn(MatMut<f64>) + Sync)) {
    const ROWS: usize = 512;
    if matrix.nrows() == 0 {
    } else if matrix.nrows() <= ROWS {
        work(matrix);
    } else {
        let middle = (matrix.nrows() / 2).next_multiple_of(ROWS);
        let middle = if middle < matrix.nrows() { middle } else { ROWS };
        let (above, below) = matrix.split_at_row_mut(middle);
        if parallel {
            rayon::join(|| in_row_blocks(above, true, work), || in_row_blocks(below, true, work));
        } else {
            in_row_blocks(above, false, work);
            in_row_blocks(below, false, work);
        }
    }
}

/// Subtracts from a panel what a factorised one changes in it: `source`'s row `first` is the row of the
/// target's first diagonal entry.
fn subtract(kind: Kind, target: MatMut<f64>, source: MatRef<f64>, first: usize) {
    let width = target.ncols();
    let rows = source.get(first.., ..);
    let (top, bottom) = rows.split_at_row(width);
    let scaled;
    let right = match kind {
        Kind::Cholesky => top,
        Kind::Signed => {
            scaled = Mat::from_fn(width, source.ncols(), |i, j| top[(i, j)] * source[(j, j)]);
            scaled.as_ref()
        }
    };
    let (target_top, target_bottom) = target.split_at_row_mut(width);
    triangular::matmul(
        target_top,
        BlockStructure::TriangularLower,
        Accum::Add,
        top,
        BlockStructure::Rectangular,
        right.transpose(),
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
    matmul::matmul(target_bottom, Accum::Add, bottom, right.transpose(), -1.0, Par::Seq);
}

const _: () = assert!(PANEL.is_multiple_of(8));
