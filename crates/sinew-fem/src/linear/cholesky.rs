//! Cholesky factors of sparse symmetric matrices.

use super::elimination::{Elimination, Front};
use super::front::{BadPivot, Kind, eliminate};
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par};
use std::sync::Arc;

/// The Cholesky factor of a sparse symmetric matrix: the analysis, which others with the same pattern share, and
/// the numbers.
pub(crate) struct Cholesky {
    elimination: Arc<Elimination>,
    entries: Vec<f64>,
    workspace: [Vec<f64>; 2],
    kind: Kind,
}

impl Cholesky {
    /// Analyses the lower half of a matrix, compressed by columns with ascending rows. `None` without memory.
    pub fn new(starts: &[usize], rows: &[usize]) -> Option<Self> {
        Self::of(Arc::new(Elimination::new(starts, rows)))
    }

    /// Another factor for the same pattern.
    pub fn fresh(&self) -> Option<Self> {
        Self::of(self.elimination.clone())
    }

    fn of(elimination: Arc<Elimination>) -> Option<Self> {
        let [even, odd] = elimination.workspace;
        let workspace = [zeros(even)?, zeros(odd)?];
        let entries = zeros(elimination.entries)?;
        Some(Self { elimination, entries, workspace, kind: Kind::Cholesky })
    }

    /// Stored entries of the factor.
    pub fn entries(&self) -> usize {
        self.entries.len()
    }

    /// Stored entries besides those of the factor.
    pub fn workspace(&self) -> usize {
        self.workspace.iter().map(Vec::len).sum()
    }

    /// Operations of a factorisation.
    pub fn flops(&self) -> f64 {
        self.elimination.flops
    }

    /// Factorises `L Lᵀ`; false where the matrix is not positive definite.
    pub fn factorise(&mut self, values: &[f64]) -> bool {
        self.run(Kind::Cholesky, values).is_ok()
    }

    /// Factorises `L D Lᵀ` and counts the negative pivots: the number of negative eigenvalues by Sylvester's law
    /// of inertia. `None` where a pivot vanishes.
    pub fn factorise_indefinite(&mut self, values: &[f64]) -> Option<usize> {
        self.run(Kind::Signed, values).ok()?;
        let mut negative = 0;
        for front in &self.elimination.fronts {
            let shape = front.columns();
            for column in 0..shape.columns {
                let pivot = self.entries[front.start + shape.column(column)];
                if !pivot.is_finite() || pivot == 0.0 {
                    return None;
                }
                negative += usize::from(pivot < 0.0);
            }
        }
        Some(negative)
    }

    fn run(&mut self, kind: Kind, values: &[f64]) -> Result<(), BadPivot> {
        self.kind = kind;
        let elimination = &*self.elimination;
        let [even, odd] = &mut self.workspace;
        let run = Run { elimination, kind, values };
        // Roots have no update, so the subtrees follow each other in the same workspace.
        let mut roots = Vec::new();
        let mut end = elimination.fronts.len();
        while let Some(last) = end.checked_sub(1) {
            roots.push(last);
            end = elimination.fronts[last].subtree;
        }
        for &root in roots.iter().rev() {
            let front = &elimination.fronts[root];
            let first = elimination.fronts[front.subtree].start;
            let entries = &mut self.entries[first..front.start + front.columns().len()];
            run.subtree(root, Memory { entries, sides: [&mut even[..], &mut odd[..]], bases: [0; 2] })?;
        }
        Ok(())
    }

    /// Overwrites a right-hand side with the solution of the last factorised system.
    pub fn solve(&self, right: &mut [f64]) {
        let widest = self.elimination.fronts.iter().map(|f| f.columns().rows).max().unwrap_or(0);
        let mut local = vec![0.0; widest];
        for front in &self.elimination.fronts {
            self.forward(front, right, &mut local);
        }
        for front in self.elimination.fronts.iter().rev() {
            self.backward(front, right, &mut local);
        }
    }

    /// Solves with the columns of a front in `L`, from the right-hand side on to what is below.
    fn forward(&self, front: &Front, right: &mut [f64], local: &mut [f64]) {
        let shape = front.columns();
        let local = &mut local[..shape.rows];
        let (own, below) = local.split_at_mut(shape.columns);
        own.copy_from_slice(&right[front.pivots.clone()]);
        below.fill(0.0);
        let entries = &self.entries[front.start..];
        for panel in shape.panels() {
            let (top, bottom) = panel.of(entries).split_at_row(panel.columns);
            let local = column(&mut local[panel.first..]);
            let (mut solved, rest) = local.split_at_row_mut(panel.columns);
            match self.kind {
                Kind::Cholesky => triangular_solve::solve_lower_triangular_in_place(
                    top,
                    solved.rb_mut(),
                    Par::Seq,
                ),
                Kind::Signed => triangular_solve::solve_unit_lower_triangular_in_place(
                    top,
                    solved.rb_mut(),
                    Par::Seq,
                ),
            }
            matmul::matmul(rest, Accum::Add, bottom, solved.rb(), -1.0, Par::Seq);
        }
        right[front.pivots.clone()].copy_from_slice(&local[..shape.columns]);
        let rows = &self.elimination.rows[front.rows.clone()];
        for (&row, change) in rows.iter().zip(&local[shape.columns..]) {
            right[row as usize] += change;
        }
    }

    /// Solves with the columns of a front in `D` and `Lᵀ`.
    fn backward(&self, front: &Front, right: &mut [f64], local: &mut [f64]) {
        let shape = front.columns();
        let local = &mut local[..shape.rows];
        let (own, below) = local.split_at_mut(shape.columns);
        own.copy_from_slice(&right[front.pivots.clone()]);
        let rows = &self.elimination.rows[front.rows.clone()];
        for (value, &row) in below.iter_mut().zip(rows) {
            *value = right[row as usize];
        }
        let entries = &self.entries[front.start..];
        for index in (0..shape.columns.div_ceil(super::trapezoid::PANEL)).rev() {
            let panel = shape.panel(index);
            let (top, bottom) = panel.of(entries).split_at_row(panel.columns);
            let local = column(&mut local[panel.first..]);
            let (mut solved, rest) = local.split_at_row_mut(panel.columns);
            if self.kind == Kind::Signed {
                for i in 0..panel.columns {
                    solved[(i, 0)] /= top[(i, i)];
                }
            }
            matmul::matmul(
                solved.rb_mut(),
                Accum::Add,
                bottom.transpose(),
                rest.rb(),
                -1.0,
                Par::Seq,
            );
            match self.kind {
                Kind::Cholesky => triangular_solve::solve_upper_triangular_in_place(
                    top.transpose(),
                    solved,
                    Par::Seq,
                ),
                Kind::Signed => triangular_solve::solve_unit_upper_triangular_in_place(
                    top.transpose(),
                    solved,
                    Par::Seq,
                ),
            }
        }
        right[front.pivots.clone()].copy_from_slice(&local[..shape.columns]);
    }
}

fn column(values: &mut [f64]) -> MatMut<'_, f64> {
    let rows = values.len();
    MatMut::from_column_major_slice_mut(values, rows, 1)
}

fn zeros(size: usize) -> Option<Vec<f64>> {
    let mut entries = Vec::new();
    entries.try_reserve_exact(size).ok()?;
    entries.resize(size, 0.0);
    Some(entries)
}

/// A factorisation in progress.
struct Run<'a> {
    elimination: &'a Elimination,
    kind: Kind,
    values: &'a [f64],
}

/// What a subtree may write to: entries of its fronts, and its parts of the workspace with where they start.
struct Memory<'m> {
    entries: &'m mut [f64],
    sides: [&'m mut [f64]; 2],
    bases: [usize; 2],
}

impl Run<'_> {
    /// Factorises the subtree of a front.
    fn subtree(&self, root: usize, mut memory: Memory) -> Result<(), BadPivot> {
        let Elimination { fronts, children, .. } = self.elimination;
        let first = fronts[fronts[root].subtree].start;
        if !fronts[root].parallel {
            // No subtree of it is parallel either.
            for front in fronts[root].subtree..=root {
                self.front(front, first, &mut memory)?;
            }
            return Ok(());
        }
        let children = &children[fronts[root].children.clone()];
        let Memory { entries, sides: [even, odd], bases } = &mut memory;
        self.subtrees(children, Memory { entries, sides: [even, odd], bases: *bases })?;
        self.front(root, first, &mut memory)
    }

    /// Factorises subtrees that follow each other, in parallel.
    fn subtrees(&self, roots: &[u32], memory: Memory) -> Result<(), BadPivot> {
        let fronts = &self.elimination.fronts;
        if let [root] = roots {
            return self.subtree(*root as usize, memory);
        }
        let (left, right) = roots.split_at(roots.len() / 2);
        let start = fronts[fronts[left[0] as usize].subtree].start;
        let middle = &fronts[right[0] as usize];
        let Memory { entries, sides: [even, odd], bases } = memory;
        let [even_at, odd_at] = middle.workspace().map(|range| range.start);
        let (entries, right_entries) = entries.split_at_mut(fronts[middle.subtree].start - start);
        let (even, right_even) = even.split_at_mut(even_at - bases[0]);
        let (odd, right_odd) = odd.split_at_mut(odd_at - bases[1]);
        let right_memory = Memory {
            entries: right_entries,
            sides: [right_even, right_odd],
            bases: [even_at, odd_at],
        };
        let (first, second) = rayon::join(
            || self.subtrees(left, Memory { entries, sides: [even, odd], bases }),
            || self.subtrees(right, right_memory),
        );
        first.and(second)
    }

    /// Assembles and eliminates one front; `first` is where `memory.entries` start in the factor.
    fn front(&self, index: usize, first: usize, memory: &mut Memory) -> Result<(), BadPivot> {
        let front = &self.elimination.fronts[index];
        let (shape, update_shape) = (front.columns(), front.update_shape());
        let start = front.start - first;
        let columns = &mut memory.entries[start..start + shape.len()];
        let (own, other) = if front.odd { (1, 0) } else { (0, 1) };
        let from = front.update - memory.bases[own];
        let base = memory.bases[other];
        let [even, odd] = &mut memory.sides;
        let (mine, others) = if front.odd { (odd, &*even) } else { (even, &*odd) };
        let update = &mut mine[from..from + update_shape.len()];
        columns.fill(0.0);
        update.fill(0.0);
        self.add_matrix(front, columns);
        for &child in &self.elimination.children[front.children.clone()] {
            let child = &self.elimination.fronts[child as usize];
            let waiting = &others[child.update - base..];
            self.add_update(child, waiting, front, columns, update);
        }
        eliminate(self.kind, shape, columns, update, front.flops)
    }

    fn add_matrix(&self, front: &Front, columns: &mut [f64]) {
        let starts = &self.elimination.starts;
        let range = starts[front.pivots.start]..starts[front.pivots.end];
        for (&place, value) in self.elimination.scatter[range.clone()].iter().zip(&self.values[range]) {
            columns[place as usize] += value;
        }
    }

    /// Adds a child's update to its parent's front.
    fn add_update(
        &self,
        child: &Front,
        waiting: &[f64],
        parent: &Front,
        columns: &mut [f64],
        update: &mut [f64],
    ) {
        let (shape, update_shape) = (parent.columns(), parent.update_shape());
        let places = &self.elimination.relative[child.rows.clone()];
        let child_shape = child.update_shape();
        for (inside, &column) in places.iter().enumerate() {
            let source = &waiting[child_shape.column(inside)..][..places.len() - inside];
            let column = column as usize;
            let target = if column < shape.columns {
                &mut columns[shape.column(column)..]
            } else {
                &mut update[update_shape.column(column - shape.columns)..]
            };
            for (&place, value) in places[inside..].iter().zip(source) {
                target[place as usize - column] += value;
            }
        }
    }
}
