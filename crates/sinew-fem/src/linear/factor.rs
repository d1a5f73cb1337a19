//! Cholesky factors of the stiffness matrix, with one symbolic analysis for all: faer's supernodal ones in an order of our own.

use crate::linear::Sparsity;
use crate::{Result, SolveError};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, SparseColMatRef, Triplet};
use faer::traits::RealField;
use faer::{Conj, MatMut, Par, Side};
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Arc;

/// First shift of an indefinite matrix \[relative to the mean diagonal\], and its growth. It is small enough to keep
/// the soft directions of a slender body, along which it snaps or buckles: an arch takes 539 iterations from 1e-4, 10
/// from 1e-6. A few trials reach any matrix; they begin one below the last shift, which changes no result.
const FIRST_SHIFT: f64 = 1e-6;
const SHIFT_GROWTH: f64 = 8.0;
/// Number of shifts, none among them.
pub(crate) const MOST_SHIFTS: usize = 13;

/// Shift of a number \[relative to the mean diagonal\]; number 0 is no shift.
pub(crate) fn shift_of(number: usize) -> f64 {
    if number == 0 { 0.0 } else { FIRST_SHIFT * SHIFT_GROWTH.powi(number as i32 - 1) }
}

/// The Cholesky factor of a body's stiffness: `L Lᵀ`, or `L D Lᵀ` where negative eigenvalues are counted.
///
/// Large factors are computed on all threads, in shares that do not depend on their number (docs/design.md, "Linear solver").
pub(crate) struct Factor {
    symbolic: Arc<SymbolicCholesky<usize>>,
    entries: Vec<f64>,
    single: Vec<f32>,
    form: Form,
    /// Whether [`Factor::definite`] computes in single precision.
    pub rough: bool,
    /// Number of the last shift.
    last_shift: usize,
}

/// Form of a factor.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// No factor yet.
    Empty,
    /// `L Lᵀ`.
    Definite,
    /// `L D Lᵀ`.
    Signed,
    /// `L Lᵀ` of the matrix over its mean diagonal, which is given, in single precision.
    Single(f64),
}

impl Factor {
    /// Analyses a sparsity.
    pub(crate) fn new(sparsity: &Sparsity) -> Result<Self> {
        let memory = || SolveError::OutOfMemory { unknowns: sparsity.unknowns() };
        let lower = sparsity.pattern.as_ref();
        // The analysis reads the upper half, the lower one by rows.
        let upper = lower.transpose().to_col_major().map_err(|_| memory())?;
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let order = SymmetricOrdering::Identity;
        let symbolic = factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, order, parameters);
        symbolic.map(|symbolic| Self::of(Arc::new(symbolic))).map_err(|_| memory())
    }

    /// The factor of a positive definite matrix of its own, given by its lower half; `None` where it is not, or does not fit in memory.
    pub(crate) fn alone(size: usize, half: &[Triplet<usize, usize, f64>]) -> Option<Self> {
        let matrix = SparseColMat::try_new_from_triplets(size, size, half).ok()?;
        let (pattern, order) = (matrix.symbolic(), SymmetricOrdering::Amd);
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, order, Default::default());
        let mut factor = Self::of(Arc::new(symbolic.ok()?));
        factor.factorise(matrix.as_ref()).then_some(factor)
    }

    /// Another factor of the same sparsity: its own numbers, the same analysis.
    pub(crate) fn fresh(&self) -> Self {
        Self::of(self.symbolic.clone())
    }

    fn of(symbolic: Arc<SymbolicCholesky<usize>>) -> Self {
        Self {
            symbolic,
            entries: vec![],
            single: vec![],
            form: Form::Empty,
            rough: false,
            last_shift: 0,
        }
    }

    /// Reserves memory, which the first factorisation takes.
    pub(crate) fn reserved(mut self) -> Result<Self> {
        let reserved = self.entries.try_reserve_exact(self.entries());
        let memory = |_| SolveError::OutOfMemory { unknowns: self.symbolic.nrows() };
        reserved.map_err(memory).map(|()| self)
    }

    /// Number of stored entries of the factor.
    pub(crate) fn entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Operations of a factorisation: the squares of the entries of each column.
    pub(crate) fn operations(&self) -> f64 {
        let of_columns = |(own, below): (Range<usize>, &[usize])| {
            (1..=own.len()).map(|rows| ((rows + below.len()) as f64).powi(2)).sum::<f64>()
        };
        self.supernodes().into_iter().map(of_columns).sum()
    }

    /// Columns that are eliminated together, with the later rows that depend on them, ascending.
    pub(crate) fn supernodes(&self) -> Vec<(Range<usize>, &[usize])> {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                let own = symbolic.supernode_begin().iter().zip(symbolic.supernode_end());
                let below = (0..).map(|s| symbolic.supernode(s).pattern());
                own.map(|(&begin, &end)| begin..end).zip(below).collect()
            }
            // Tiny matrices have no supernodes, whatever is requested; the diagonal comes first in each column.
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let columns = symbolic.col_ptr().windows(2).zip(0..);
                let below = |ends: &[usize]| &symbolic.row_idx()[ends[0] + 1..ends[1]];
                columns.map(|(ends, column)| (column..column + 1, below(ends))).collect()
            }
        }
    }

    /// Whether solutions with the last factor are accurate to rounding errors in double precision.
    pub(crate) fn is_double(&self) -> bool {
        !matches!(self.form, Form::Single(_))
    }

    /// [`Factor::positive_definite`] or [`Factor::definite_in_single`].
    pub(crate) fn definite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        match self.rough {
            true => self.definite_in_single(sparsity, matrix),
            false => self.positive_definite(sparsity, matrix),
        }
    }

    /// Factorises `L Lᵀ`; false where the matrix is not positive definite.
    pub(crate) fn positive_definite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        self.factorise(lower_half(sparsity, matrix))
    }

    /// Factorises `L Lᵀ` in single precision, in half the memory and time; false where the matrix is not positive definite, or so nearly
    /// singular that this does not show.
    pub(crate) fn definite_in_single(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        self.entries = Vec::new();
        let mean = sparsity.mean_diagonal(matrix);
        self.form = Form::Single(mean);
        let entries = matrix[..sparsity.entries()].iter();
        let scaled: Vec<f32> = entries.map(|x| (x / mean) as f32).collect();
        let half = SparseColMatRef::new(sparsity.pattern.as_ref(), &scaled);
        cholesky(&self.symbolic, &mut self.single, half)
            && self.pivots(&self.single).all(|pivot| pivot > 0.0 && pivot.is_finite())
    }

    fn factorise(&mut self, half: SparseColMatRef<'_, usize, f64>) -> bool {
        self.single = Vec::new();
        self.form = Form::Definite;
        cholesky(&self.symbolic, &mut self.entries, half)
            && self.pivots(&self.entries).all(|pivot| pivot > 0.0 && pivot.is_finite())
    }

    /// Factorises `L D Lᵀ` and counts the negative pivots: the number of negative eigenvalues by
    /// Sylvester's law of inertia. `None` where a pivot vanishes.
    pub(crate) fn indefinite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> Option<usize> {
        self.single = Vec::new();
        self.form = Form::Signed;
        let symbolic = &*self.symbolic;
        let scratch = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = prepared(symbolic, &mut self.entries, scratch)?;
        let factor = symbolic.factorize_numeric_ldlt(
            &mut self.entries,
            lower_half(sparsity, matrix),
            Side::Lower,
            LdltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        factor.ok()?;
        let usable = self.pivots(&self.entries).all(|pivot| pivot.is_finite() && pivot != 0.0);
        usable.then(|| self.pivots(&self.entries).filter(|&pivot| pivot < 0.0).count())
    }

    /// Diagonal of `L`, or of `D`, from the entries of a factor.
    fn pivots<T: Copy>(&self, entries: &[T]) -> impl Iterator<Item = T> {
        let mut next = 0;
        self.supernodes().into_iter().flat_map(move |(own, below)| {
            let (start, rows) = (next, own.len() + below.len());
            next += own.len() * rows;
            (0..own.len()).map(move |i| entries[start + i * (rows + 1)])
        })
    }

    /// Factorises the matrix plus a multiple of its mean diagonal, the first of growing ones that makes it positive
    /// definite; returns the multiple. The diagonal in `matrix` is restored.
    pub(crate) fn shifted(&mut self, sparsity: &Sparsity, matrix: &mut [f64]) -> Option<f64> {
        let diagonal = &sparsity.pattern.col_ptr()[..sparsity.unknowns()];
        let original: Vec<_> = diagonal.iter().map(|&slot| matrix[slot]).collect();
        let mean = sparsity.mean_diagonal(matrix);
        let first = self.last_shift.max(2) - 1;
        let mut definite = |number: usize| {
            for (&slot, d) in diagonal.iter().zip(&original) {
                matrix[slot] = d + shift_of(number) * mean;
            }
            self.definite(sparsity, matrix)
        };
        let found = if definite(first) {
            // The last of falling shifts fails, so that the one before it is factorised again.
            let least = (1..first).rev().take_while(|&number| definite(number)).last();
            let least = least.unwrap_or(first);
            (least == 1 || definite(least)).then_some(least)
        } else {
            (first + 1..MOST_SHIFTS).find(|&number| definite(number))
        };
        diagonal.iter().zip(&original).for_each(|(&slot, &d)| matrix[slot] = d);
        self.last_shift = found.unwrap_or(0);
        found.map(shift_of)
    }

    /// Overwrites a right-hand side with the solution of the last factorised system; NaN if there is none.
    pub(crate) fn solve(&self, right: &mut [f64]) {
        match self.form {
            Form::Empty => right.fill(f64::NAN),
            Form::Definite => back_substitute(&self.symbolic, &self.entries, false, right),
            Form::Signed => back_substitute(&self.symbolic, &self.entries, true, right),
            Form::Single(mean) => {
                // Single precision holds no small forces.
                let size = right.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
                let mut scaled: Vec<f32> = right.iter().map(|x| (x / size) as f32).collect();
                back_substitute(&self.symbolic, &self.single, false, &mut scaled);
                let unscale = |(to, x): (&mut f64, &f32)| *to = size / mean * f64::from(*x);
                right.iter_mut().zip(&scaled).for_each(unscale);
            }
        }
    }
}

fn lower_half<'m>(sparsity: &'m Sparsity, matrix: &'m [f64]) -> SparseColMatRef<'m, usize, f64> {
    SparseColMatRef::new(sparsity.pattern.as_ref(), &matrix[..sparsity.entries()])
}

/// Shares of the dense blocks of a large factor. The division is fixed, so that results do not depend on the number of
/// threads; a single thread does not divide, with the same bits.
const SHARES: NonZeroUsize = NonZeroUsize::new(4).unwrap();
/// Least number of entries of a factor whose blocks are divided.
const LARGE: usize = 2_000_000;

/// Overwrites a right-hand side by the solution with a factor, one with signs or one of a definite matrix.
fn back_substitute<T: RealField>(
    symbolic: &SymbolicCholesky<usize>,
    entries: &[T],
    signed: bool,
    right: &mut [T],
) {
    let (size, par) = (right.len(), Par::Seq);
    let right = MatMut::from_column_major_slice_mut(right, size, 1);
    let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<T>(1, par));
    let (conj, memory) = (Conj::No, MemStack::new(&mut memory));
    if signed {
        LdltRef::new(symbolic, entries).solve_in_place_with_conj(conj, right, par, memory);
    } else {
        LltRef::new(symbolic, entries).solve_in_place_with_conj(conj, right, par, memory);
    }
}

/// Factorises `L Lᵀ` of a matrix with this lower half; false where that fails.
fn cholesky<T: RealField + Default>(
    symbolic: &SymbolicCholesky<usize>,
    entries: &mut Vec<T>,
    half: SparseColMatRef<'_, usize, T>,
) -> bool {
    let scratch = symbolic.factorize_numeric_llt_scratch::<T>(shares(symbolic), Default::default());
    let Some(mut memory) = prepared(symbolic, entries, scratch) else { return false };
    let (side, regularisation) = (Side::Lower, LltRegularization::default());
    let (par, memory, spec) = (shares(symbolic), MemStack::new(&mut memory), Default::default());
    symbolic.factorize_numeric_llt(entries, half, side, regularisation, par, memory, spec).is_ok()
}

/// Room for the entries of a factor, and memory to compute it in; `None` where they do not fit.
fn prepared<T: Clone + Default>(
    symbolic: &SymbolicCholesky<usize>,
    entries: &mut Vec<T>,
    scratch: StackReq,
) -> Option<MemBuffer> {
    entries.try_reserve_exact(symbolic.len_val() - entries.len()).ok()?;
    entries.resize(symbolic.len_val(), T::default());
    MemBuffer::try_new(scratch).ok()
}

/// Division of a factor's blocks.
fn shares(symbolic: &SymbolicCholesky<usize>) -> Par {
    let alone = rayon::current_num_threads() == 1;
    if alone || symbolic.len_val() < LARGE { Par::Seq } else { Par::Rayon(SHARES) }
}
