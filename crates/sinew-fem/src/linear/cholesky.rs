//! Cholesky factors of sparse symmetric matrices.

use super::elimination::{Elimination, Front};
use super::front::{BadPivot, Kind, eliminate};
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par};
use std::sync::Arc;

/// The Cholesky factor of a sparse symmetric matrix: the analysis, which others with the same pattern share, and
/// the numbers.
#[derive(Clone)]
pub struct Cholesky {
    elimination: Arc<Elimination>,
    entries: Vec<f64>,
    workspace: [Vec<f64>; 2],
    kind: Kind,
    /// The right-hand side in one front.
    local: Vec<f64>,
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
        let tallest = elimination.fronts.iter().map(|front| front.columns().rows).max();
        let local = vec![0.0; tallest.unwrap_or(0)];
        Some(Self { elimination, entries, workspace, kind: Kind::Cholesky, local })
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.elimination.size
    }

    /// Stored entries of the factor.
    pub fn entries(&self) -> usize {
        self.entries.len()
    }

    /// Stored entries of the workspace that a factorisation needs beside the factor.
    pub fn workspace_entries(&self) -> usize {
        self.workspace.iter().map(Vec::len).sum()
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
        let mut memory =
            Memory { entries: &mut self.entries, first: 0, sides: [even, odd], bases: [0; 2] };
        // Roots have no update, so their subtrees use the same workspace one after the other.
        elimination.roots.iter().try_for_each(|&root| run.subtree(root as usize, &mut memory))
    }

    /// Overwrites a right-hand side with the solution of the last factorised system.
    pub fn solve(&mut self, right: &mut [f64]) {
        let mut local = std::mem::take(&mut self.local);
        for front in &self.elimination.fronts {
            self.forward(front, right, &mut local);
        }
        for front in self.elimination.fronts.iter().rev() {
            self.backward(front, right, &mut local);
        }
        self.local = local;
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

/// What subtrees may write to: the entries of their fronts, and their parts of the workspace; with the places
/// where these start in the whole.
struct Memory<'m> {
    entries: &'m mut [f64],
    first: usize,
    sides: [&'m mut [f64]; 2],
    bases: [usize; 2],
}

impl Memory<'_> {
    /// Divides the memory before that of a front's subtree.
    fn split(&mut self, subtree: usize, bases: [usize; 2]) -> (Memory<'_>, Memory<'_>) {
        let [even, odd] = &mut self.sides;
        let (entries, later_entries) = self.entries.split_at_mut(subtree - self.first);
        let (even, later_even) = even.split_at_mut(bases[0] - self.bases[0]);
        let (odd, later_odd) = odd.split_at_mut(bases[1] - self.bases[1]);
        let (first, sides) = (self.first, [even, odd]);
        let earlier = Memory { entries, first, sides, bases: self.bases };
        let sides = [later_even, later_odd];
        (earlier, Memory { entries: later_entries, first: subtree, sides, bases })
    }
}

impl Run<'_> {
    /// Factorises the subtree of a front.
    fn subtree(&self, root: usize, memory: &mut Memory) -> Result<(), BadPivot> {
        let Elimination { fronts, children, .. } = self.elimination;
        let front = &fronts[root];
        if !front.split {
            return (front.subtree..=root).try_for_each(|front| self.front(front, memory));
        }
        let children = &children[front.children.clone()];
        if front.parallel {
            self.subtrees(children, memory)?;
        } else {
            children.iter().try_for_each(|&child| self.subtree(child as usize, memory))?;
        }
        self.front(root, memory)
    }

    /// Factorises subtrees that follow each other, in parallel.
    fn subtrees(&self, roots: &[u32], memory: &mut Memory) -> Result<(), BadPivot> {
        if let [root] = roots {
            return self.subtree(*root as usize, memory);
        }
        let fronts = &self.elimination.fronts;
        let (left, right) = roots.split_at(roots.len() / 2);
        let middle = &fronts[right[0] as usize];
        let bases = middle.workspace().map(|range| range.start);
        let (mut earlier, mut later) = memory.split(fronts[middle.subtree].start, bases);
        let (first, second) =
            rayon::join(|| self.subtrees(left, &mut earlier), || self.subtrees(right, &mut later));
        first.and(second)
    }

    /// Assembles and eliminates one front.
    fn front(&self, index: usize, memory: &mut Memory) -> Result<(), BadPivot> {
        let front = &self.elimination.fronts[index];
        let (shape, update_shape) = (front.columns(), front.update_shape());
        let columns = &mut memory.entries[front.start - memory.first..][..shape.len()];
        let [even, odd] = &mut memory.sides;
        let [even_base, odd_base] = memory.bases;
        let (own, own_base, other, other_base) = if front.odd {
            (odd, odd_base, &*even, even_base)
        } else {
            (even, even_base, &*odd, odd_base)
        };
        let update = &mut own[front.update - own_base..][..update_shape.len()];
        columns.fill(0.0);
        update.fill(0.0);
        self.add_matrix(front, columns);
        for &child in &self.elimination.children[front.children.clone()] {
            let child = &self.elimination.fronts[child as usize];
            self.add_update(child, &other[child.update - other_base..], front, columns, update);
        }
        eliminate(self.kind, shape, columns, update, front.flops)
    }

    fn add_matrix(&self, front: &Front, columns: &mut [f64]) {
        let starts = &self.elimination.starts;
        let range = starts[front.pivots.start]..starts[front.pivots.end];
        for (&place, value) in
            self.elimination.scatter[range.clone()].iter().zip(&self.values[range])
        {
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

#[cfg(test)]
mod tests {
    use super::super::samples::{Sample, compressed, grid, reordered};
    use super::super::trapezoid::PANEL;
    use super::*;
    use crate::linear::ordering::fill_reducing_order;

    /// Largest error of the solution relative to it: these matrices are well conditioned.
    const ROUNDING: f64 = 1e-11;

    fn error(factor: &mut Cholesky, sample: &Sample) -> f64 {
        let expected: Vec<f64> = (0..sample.size()).map(|i| (i % 11) as f64 - 4.5).collect();
        let mut x = sample.times(&expected);
        factor.solve(&mut x);
        x.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / 5.5
    }

    fn ordered_grid(size: [usize; 3]) -> Vec<Vec<usize>> {
        let graph = grid(size);
        let (starts, neighbours) = compressed(&graph);
        reordered(&graph, &fill_reducing_order(&starts, &neighbours))
    }

    /// Graphs with all kinds of trees: none, a chain, several parts, a dense matrix of several panels, an order
    /// that is no postorder, and one large enough to be worked on in parallel.
    fn graphs() -> Vec<Vec<Vec<usize>>> {
        let chain = |i: usize| if i == 0 { vec![1] } else { vec![i - 1, i + 1] };
        let mut line: Vec<_> = (0..200).map(chain).collect();
        line[199] = vec![198];
        let evens_first: Vec<_> = (0..200).step_by(2).chain((1..200).step_by(2)).collect();
        let size = 2 * PANEL + 30;
        let complete = (0..size).map(|v| (0..size).filter(|&n| n != v).collect()).collect();
        vec![
            vec![],
            vec![vec![]; 7],
            reordered(&line, &evens_first),
            line,
            complete,
            grid([9, 7, 5]),
            ordered_grid([14, 14, 20]),
        ]
    }

    #[test]
    fn definite_systems_are_solved() {
        for graph in graphs() {
            let sample = Sample::of_graph(&graph, |i| graph[i].len() as f64 + 0.5);
            let mut factor = Cholesky::new(&sample.starts, &sample.rows).unwrap();
            assert!(factor.factorise(&sample.values));
            let first = error(&mut factor, &sample);
            // Again in the same memory, and with signs.
            assert_eq!(factor.factorise_indefinite(&sample.values), Some(0));
            let second = error(&mut factor, &sample);
            assert!(first.max(second) < ROUNDING, "{} unknowns: {first:e} {second:e}", graph.len());
        }
    }

    #[test]
    fn negative_eigenvalues_are_counted() {
        for graph in graphs() {
            // Dominant diagonals: their signs are those of the eigenvalues (Gershgorin).
            let negative = |i: usize| i % 5 == 2;
            let sign = |i: usize| if negative(i) { -1.0 } else { 1.0 };
            let sample = Sample::of_graph(&graph, |i| sign(i) * (graph[i].len() as f64 + 0.5));
            let mut factor = Cholesky::new(&sample.starts, &sample.rows).unwrap();
            let expected = (0..graph.len()).filter(|&i| negative(i)).count();
            assert_eq!(factor.factorise(&sample.values), expected == 0);
            assert_eq!(factor.factorise_indefinite(&sample.values), Some(expected));
            let error = error(&mut factor, &sample);
            assert!(error < ROUNDING, "{} unknowns: {error:e}", graph.len());
        }
    }

    #[test]
    fn what_is_singular_or_no_number_is_refused() {
        let graph = grid([4, 3, 2]);
        for bad in [0.0, f64::NAN] {
            let mut sample = Sample::of_graph(&graph, |i| graph[i].len() as f64 + 0.5);
            sample.values[0] = bad;
            if bad == 0.0 {
                sample.values[..sample.starts[1]].fill(0.0);
            }
            let mut factor = Cholesky::new(&sample.starts, &sample.rows).unwrap();
            assert!(!factor.factorise(&sample.values));
            assert_eq!(factor.factorise_indefinite(&sample.values), None);
        }
    }

    #[test]
    fn numbers_do_not_depend_on_the_number_of_threads() {
        // Large enough for subtrees in parallel and panels in parallel.
        let graph = ordered_grid([20, 20, 50]);
        let sample = Sample::of_graph(&graph, |i| graph[i].len() as f64 + 0.5);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut factor = Cholesky::new(&sample.starts, &sample.rows).unwrap();
                assert!(factor.elimination.fronts.iter().any(|front| front.parallel));
                assert!(factor.factorise(&sample.values));
                factor.entries
            })
        };
        assert!(on(1) == on(3));
    }
}
