//! Blocks of nodes in a sparse matrix.

use super::blocks::{Block, BlockMatrix};
use super::groups::MODES;
use crate::linear::sparsity::Sparsity;

/// The places of a matrix and its vectors in blocks of nodes.
pub(super) struct Pattern {
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
    pub(super) fn new(sparsity: &Sparsity) -> Self {
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

    /// Blocks of the nodes of a vector times a scale.
    pub(super) fn scattered(&self, from: &[f64], scale: f64) -> Vec<[f32; 3]> {
        let mut blocks = vec![[0.0; 3]; self.diagonal.len()];
        let flat = blocks.as_flattened_mut();
        let unknowns = self.component.iter().zip(from);
        unknowns.for_each(|(&slot, x)| flat[slot as usize] = (scale * x) as f32);
        blocks
    }

    /// Overwrites a vector with that of the given blocks times a scale.
    pub(super) fn gather(&self, blocks: &[[f32; 3]], scale: f64, to: &mut [f64]) {
        let flat = blocks.as_flattened();
        let unknowns = self.component.iter().zip(to);
        unknowns.for_each(|(&slot, to)| *to = scale * f64::from(flat[slot as usize]));
    }

    /// The blocks of a matrix over its mean diagonal, plus a shift. Prescribed components of a node are decoupled.
    pub(super) fn blocks(&self, entries: &[f64], shift: f64, mean: f64) -> BlockMatrix<f64, 3, 3> {
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
    pub(super) fn rigid_modes(
        &self,
        sparsity: &Sparsity,
        positions: &[f64],
    ) -> Vec<Block<f64, 3, MODES>> {
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
