//! Conjugate gradients preconditioned by smoothed aggregation: memory grows with the body, not with the fill of a factor.

mod blocks;
mod groups;
mod multigrid;

use crate::linear::conjugate_gradients::{End, conjugate_gradients};
use crate::linear::factor::{MOST_SHIFTS, shift_of};
use crate::linear::sparsity::Sparsity;
use blocks::{Block, BlockMatrix};
use groups::MODES;
use multigrid::Multigrid;
use std::sync::Arc;

/// Most iterations of one linear system: a factor is cheaper beyond.
pub(crate) const MOST_ITERATIONS: usize = 400;

/// Most iterations with the hierarchy of another matrix \[per digit\]. A new one takes as long as twenty.
const STALE: f64 = 30.0;
/// Number of the least shift, 5e-4: smaller ones cost compact bodies trials, and save no steps.
const LEAST_SHIFT: usize = 4;
/// Shifts from one hierarchy to the next where an indefinite matrix has none.
const REBUILD: usize = 3;

/// A matrix with its sparsity.
#[derive(Clone, Copy)]
pub(crate) struct Matrix<'m> {
    pub sparsity: &'m Sparsity,
    /// Entries of the lower half.
    pub entries: &'m [f64],
}

/// Solves systems with a matrix plus a multiple of its mean diagonal by conjugate gradients.
#[derive(Default)]
pub(crate) struct Aggregation {
    pattern: Option<Arc<Pattern>>,
    hierarchy: Option<Multigrid>,
    /// Number of the shift of the last matrix, 0 without one.
    shift: usize,
    /// Mean diagonal of the last matrix.
    mean: f64,
    /// Iterations of all systems.
    pub iterations: usize,
}

impl Aggregation {
    /// Another one for the same sparsity.
    pub(crate) fn fresh(&self) -> Self {
        Self { pattern: self.pattern.clone(), ..Self::default() }
    }

    /// Frees the hierarchy, and forgets earlier matrices.
    pub(crate) fn clear(&mut self) {
        *self = self.fresh();
    }

    /// Frees the hierarchy alone.
    pub(crate) fn drop_hierarchy(&mut self) {
        self.hierarchy = None;
    }

    /// Solves with a matrix plus the least tried shift for which conjugate gradients meet no negative curvature: the solution and the
    /// shift [relative to the mean diagonal]. `None` where they do not converge.
    ///
    /// Trials begin without a shift and go on one below the last one. A hierarchy that is present is that of an earlier matrix; it serves all trials unless they take too long.
    /// `positions` are those of the deformed body.
    pub(crate) fn solve_shifted(
        &mut self,
        matrix: Matrix<'_>,
        positions: &[f64],
        right: &[f64],
        tolerance: f64,
    ) -> Option<(Vec<f64>, f64)> {
        self.mean = matrix.sparsity.mean_diagonal(matrix.entries);
        let (first, mut own) = (self.shift.saturating_sub(1).max(LEAST_SHIFT), false);
        self.shift = 0;
        loop {
            if self.shift >= MOST_SHIFTS {
                return None;
            }
            if self.hierarchy.is_none() {
                let number = self.build(matrix, positions)?;
                own = number == self.shift;
            }
            let most = if own { MOST_ITERATIONS } else { (-STALE * tolerance.log10()) as usize };
            let (solution, iterations, end) =
                self.solve(matrix, right, tolerance, most.min(MOST_ITERATIONS));
            self.iterations += iterations;
            match end {
                End::Converged => return Some((solution, shift_of(self.shift))),
                End::NegativeCurvature => (self.shift, own) = (first.max(self.shift + 1), false),
                End::Failed if own => return None,
                End::Failed => self.hierarchy = None,
            }
        }
    }

    /// Builds a hierarchy with the present shift, or the first of growing ones that allows it; returns the number of that one. Smaller shifts leave the
    /// matrix indefinite.
    fn build(&mut self, matrix: Matrix<'_>, positions: &[f64]) -> Option<usize> {
        let pattern = self.pattern.get_or_insert_with(|| Arc::new(Pattern::new(matrix.sparsity)));
        let modes = pattern.rigid_modes(matrix.sparsity, positions);
        let mut number = self.shift;
        while number < MOST_SHIFTS {
            let blocks = pattern.blocks(matrix.entries, shift_of(number), self.mean);
            self.hierarchy = Multigrid::new(blocks, &modes);
            if self.hierarchy.is_some() {
                return Some(number);
            }
            self.shift = number + 1;
            number += REBUILD;
        }
        None
    }

    /// Solves with the last matrix, shift and hierarchy to a residual of `tolerance` times the right-hand side: the solution, the iterations and their end.
    pub(crate) fn solve(
        &self,
        matrix: Matrix<'_>,
        right: &[f64],
        tolerance: f64,
        most: usize,
    ) -> (Vec<f64>, usize, End) {
        let (Some(hierarchy), Some(pattern)) = (&self.hierarchy, &self.pattern) else {
            return (vec![f64::NAN; right.len()], 0, End::Failed);
        };
        let shift = self.mean * shift_of(self.shift);
        let apply = |from: &[f64], to: &mut [f64]| {
            matrix.sparsity.multiply(matrix.entries, from, to);
            to.iter_mut().zip(from).for_each(|(to, from)| *to += shift * from);
        };
        let precondition = |from: &[f64], to: &mut [f64]| {
            // Single precision holds no small residuals.
            let size = from.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let mut blocks = vec![[0.0; 3]; pattern.diagonal.len()];
            let flat = blocks.as_flattened_mut();
            let slots = || pattern.component.iter().map(|&slot| slot as usize);
            slots().zip(from).for_each(|(slot, x)| flat[slot] = (x / size) as f32);
            let solution = hierarchy.apply(&blocks);
            let flat = solution.as_flattened();
            slots().zip(to).for_each(|(slot, to)| *to = size * f64::from(flat[slot]) / self.mean);
        };
        conjugate_gradients(apply, precondition, right, tolerance, most)
    }
}

/// Blocks of nodes in a sparse matrix.
struct Pattern {
    /// Three times the block row plus the component of each unknown.
    component: Vec<u32>,
    starts: Vec<usize>,
    columns: Vec<u32>,
    /// Diagonal block of each row.
    diagonal: Vec<u32>,
    /// Transposed block of each block.
    mirror: Vec<u32>,
    /// Slot of each entry of the lower half among the entries of all blocks.
    slots: Vec<u32>,
}

impl Pattern {
    fn new(sparsity: &Sparsity) -> Self {
        let (starts, rows) = (sparsity.pattern.col_ptr(), sparsity.pattern.row_idx());
        let (mut component, mut last, mut count) = (Vec::new(), usize::MAX, 0);
        for &dof in &sparsity.degree_of_freedom {
            count += u32::from(dof / 3 != last);
            last = dof / 3;
            component.push(3 * (count - 1) + (dof % 3) as u32);
        }
        let node = |unknown: usize| component[unknown] as usize / 3;
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count as usize];
        for column in 0..component.len() {
            let b = node(column);
            // Unknowns of a node have the same rows below; the first one shows them all.
            if column > 0 && node(column - 1) == b {
                continue;
            }
            for &row in &rows[starts[column]..starts[column + 1]] {
                let a = node(row);
                if neighbours[b].last() != Some(&(a as u32)) {
                    neighbours[b].push(a as u32);
                    if a != b {
                        neighbours[a].push(b as u32);
                    }
                }
            }
        }
        let mut block_starts = vec![0];
        for list in &mut neighbours {
            list.sort_unstable();
            block_starts.push(block_starts[block_starts.len() - 1] + list.len());
        }
        let find = |row: usize, column: usize| {
            let place = neighbours[row].partition_point(|&c| (c as usize) < column);
            (block_starts[row] + place) as u32
        };
        let diagonal = (0..neighbours.len()).map(|row| find(row, row)).collect();
        let pairs = neighbours.iter().enumerate();
        let mirror = pairs
            .flat_map(|(row, list)| list.iter().map(move |&column| (column as usize, row)))
            .map(|(row, column)| find(row, column))
            .collect();
        let mut slots = Vec::with_capacity(rows.len());
        for column in 0..component.len() {
            let mut block = (usize::MAX, 0);
            for &row in &rows[starts[column]..starts[column + 1]] {
                if block.0 != node(row) {
                    block = (node(row), find(node(row), node(column)));
                }
                slots.push(9 * block.1 + 3 * (component[row] % 3) + component[column] % 3);
            }
        }
        let columns = neighbours.concat();
        Self { component, starts: block_starts, columns, diagonal, mirror, slots }
    }

    /// The blocks of a matrix over its mean diagonal, plus a shift. Prescribed components of a node are decoupled.
    fn blocks(&self, entries: &[f64], shift: f64, mean: f64) -> BlockMatrix<f64, 3, 3> {
        let mut blocks = vec![[[0.0; 3]; 3]; self.columns.len()];
        for &block in &self.diagonal {
            (0..3).for_each(|i| blocks[block as usize][i][i] = 1.0);
        }
        let flat = blocks.as_flattened_mut().as_flattened_mut();
        for (&slot, value) in self.slots.iter().zip(entries) {
            let (block, inside) = (slot as usize / 9, slot as usize % 9);
            flat[slot as usize] = value / mean;
            flat[9 * self.mirror[block] as usize + 3 * (inside % 3) + inside / 3] = value / mean;
        }
        for &block in &self.diagonal {
            (0..3).for_each(|i| blocks[block as usize][i][i] += shift);
        }
        let (starts, columns) = (self.starts.clone(), self.columns.clone());
        BlockMatrix { width: self.diagonal.len(), starts, columns, blocks }
    }

    /// Translations, and rotations about the centre in units of the mean distance from it, along the frames of the nodes; zero where a
    /// component is no unknown.
    fn rigid_modes(&self, sparsity: &Sparsity, positions: &[f64]) -> Vec<Block<f64, 3, MODES>> {
        let (nodes, _) = positions.as_chunks::<3>();
        let count = nodes.len() as f64;
        let centre: [f64; 3] =
            std::array::from_fn(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / count);
        let arm = |x: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|i| x[i] - centre[i]) };
        let square = nodes.iter().flat_map(arm).map(|x| x * x).sum::<f64>() / count;
        let unit = if square > 0.0 { 1.0 / square.sqrt() } else { 1.0 };
        let mut modes = vec![[[0.0; MODES]; 3]; self.diagonal.len()];
        for mode in 0..MODES {
            let motion = nodes.iter().flat_map(|x| {
                let [x, y, z] = arm(x).map(|x| unit * x);
                [
                    [1.0, 0.0, 0.0],
                    [0.0, 1.0, 0.0],
                    [0.0, 0.0, 1.0],
                    [0.0, -z, y],
                    [z, 0.0, -x],
                    [-y, x, 0.0],
                ][mode]
            });
            let motion: Vec<f64> = motion.collect();
            for (&slot, value) in self.component.iter().zip(sparsity.gather(&motion)) {
                modes[slot as usize / 3][slot as usize % 3][mode] = value;
            }
        }
        modes
    }
}
