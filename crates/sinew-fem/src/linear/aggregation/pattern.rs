//! Blocks of nodes in a sparse matrix, groups of neighbouring nodes, and coarse functions on them.

use crate::linear::Sparsity;
use crate::linear::aggregation::blocks::{Block, BlockMatrix};
use sinew_num::{fill, in_tasks, sub3};

/// No slot, or no group.
const NONE: u32 = u32::MAX;

/// The places of a matrix and its vectors in blocks of nodes.
pub(super) struct Pattern {
    /// Three times the block row plus the component of each unknown.
    component: Vec<u32>,
    starts: Vec<usize>,
    columns: Vec<u32>,
    /// Diagonal block of each row.
    diagonal: Vec<u32>,
    /// Slot in the lower half of each entry of the blocks, [`NONE`] where one of its components is prescribed.
    slots: Vec<[[u32; 3]; 3]>,
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
        for list in &neighbours {
            block_starts.push(block_starts[block_starts.len() - 1] + list.len());
        }
        let find = |row: usize, column: usize| {
            block_starts[row] + neighbours[row].partition_point(|&c| (c as usize) < column)
        };
        let diagonal = (0..neighbours.len()).map(|row| find(row, row) as u32).collect();
        let mut slots = vec![[[NONE; 3]; 3]; block_starts[neighbours.len()]];
        for column in 0..component.len() {
            let (mut last, mut places) = (usize::MAX, [0; 2]);
            for slot in starts[column]..starts[column + 1] {
                let [a, b] = [rows[slot], column].map(node);
                // The rows of one node follow each other.
                if a != last {
                    (last, places) = (a, [find(a, b), find(b, a)]);
                }
                let [i, k] = [rows[slot], column].map(|unknown| component[unknown] as usize % 3);
                slots[places[0]][i][k] = slot as u32;
                slots[places[1]][k][i] = slot as u32;
            }
        }
        let columns = neighbours.concat();
        Self { component, starts: block_starts, columns, diagonal, slots }
    }

    /// Blocks of the nodes of a vector, over a number; zero at prescribed components.
    pub(super) fn scattered(&self, from: &[f64], over: f64) -> Vec<f64> {
        let mut blocks = vec![0.0; 3 * self.diagonal.len()];
        let unknowns = self.component.iter().zip(from);
        unknowns.for_each(|(&slot, x)| blocks[slot as usize] = x / over);
        blocks
    }

    /// The vector with the given blocks.
    pub(super) fn gathered(&self, blocks: &[f64]) -> Vec<f64> {
        self.component.iter().map(|&slot| blocks[slot as usize]).collect()
    }

    /// A matrix for [`Pattern::load`].
    pub(super) fn empty(&self) -> BlockMatrix<f64, 3, 3> {
        let blocks = vec![[[0.0; 3]; 3]; self.slots.len()];
        let (starts, columns) = (self.starts.clone(), self.columns.clone());
        BlockMatrix { width: self.diagonal.len(), starts, columns, blocks }
    }

    /// Overwrites the blocks with those of a matrix over its mean diagonal, plus a shift. Prescribed components of a node are decoupled.
    pub(super) fn load(
        &self,
        entries: &[f64],
        shift: f64,
        mean: f64,
        to: &mut BlockMatrix<f64, 3, 3>,
    ) {
        let value = |slot: u32| if slot == NONE { 0.0 } else { entries[slot as usize] / mean };
        let block = |slot: usize| self.slots[slot].map(|row| row.map(value));
        fill(&mut to.blocks, 4096, block);
        for &block in &self.diagonal {
            let slots = &self.slots[block as usize];
            for i in 0..3 {
                let decoupled = if slots[i][i] == NONE { 1.0 } else { 0.0 };
                to.blocks[block as usize][i][i] += shift + decoupled;
            }
        }
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
        let centre = [0, 1, 2].map(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / count);
        let arm = |x: &[f64; 3]| sub3(x, &centre);
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

/// Rigid motions of a body.
pub(super) const MODES: usize = 6;

/// Least new part of a coarse function \[relative to itself\]; below it the others on its group describe it.
const DEPENDENT: f64 = 1e-8;

/// Groups each node with its strong neighbours: the group of each node, and the number of groups
/// (P. Vaněk, J. Mandel, M. Brezina, Computing 56, 1996, Algorithm 5.1).
///
/// Nodes are strongly coupled when the norm of their block is above `strong` times the geometric mean of their diagonal
/// blocks' norms.
pub(super) fn groups<const B: usize>(
    matrix: &BlockMatrix<f64, B, B>,
    strong: f64,
) -> (Vec<u32>, usize) {
    let size = matrix.height();
    let square = |block: &Block<f64, B, B>| block.as_flattened().iter().map(|x| x * x).sum::<f64>();
    let diagonal = |row| matrix.row(row).find(|&(c, _)| c == row).map_or(0.0, |(_, b)| square(b));
    let diagonal: Vec<f64> = (0..size).map(diagonal).collect();
    let neighbours = |row: usize| {
        let diagonal = &diagonal;
        matrix.row(row).filter_map(move |(column, block)| {
            let coupling = square(block);
            let least = strong * strong * (diagonal[row] * diagonal[column]).sqrt();
            (column != row && coupling > least).then_some((column, coupling))
        })
    };
    let (mut group, mut count) = (vec![NONE; size], 0);
    // Whole neighbourhoods first.
    for node in 0..size {
        if group[node] == NONE && neighbours(node).all(|(n, _)| group[n] == NONE) {
            group[node] = count;
            neighbours(node).for_each(|(n, _)| group[n] = count);
            count += 1;
        }
    }
    // Other nodes join the group that they are coupled to most.
    let whole = group.clone();
    for node in (0..size).filter(|&node| whole[node] == NONE) {
        let beside = neighbours(node).filter(|&(n, _)| whole[n] != NONE);
        match beside.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((nearest, _)) => group[node] = whole[nearest],
            None => {
                group[node] = count;
                count += 1;
            }
        }
    }
    (group, count as usize)
}

/// Functions on each group that span the modes there, orthonormal: the prolongation, and the modes in
/// terms of its functions.
pub(super) fn tentative<const B: usize>(
    group: &[u32],
    count: usize,
    modes: &[Block<f64, B, MODES>],
) -> (BlockMatrix<f64, B, MODES>, Vec<Block<f64, MODES, MODES>>) {
    let mut members = vec![Vec::new(); count];
    group.iter().enumerate().for_each(|(node, &g)| members[g as usize].push(node));
    let orthonormal = in_tasks(count, 32, |group| {
        let mut blocks: Vec<_> = members[group].iter().map(|&node| modes[node]).collect();
        (orthonormalise(&mut blocks), blocks)
    });
    let (mut blocks, mut coarse) = (vec![[[0.0; MODES]; B]; modes.len()], Vec::new());
    for (nodes, (triangle, of_nodes)) in members.into_iter().zip(orthonormal) {
        coarse.push(triangle);
        nodes.into_iter().zip(of_nodes).for_each(|(node, block)| blocks[node] = block);
    }
    let starts = (0..=group.len()).collect();
    (BlockMatrix { width: count, starts, columns: group.to_vec(), blocks }, coarse)
}

/// Makes the columns of blocks orthonormal (Gram–Schmidt, twice for accuracy); returns the
/// triangle that restores them. Dependent columns become zero.
fn orthonormalise<const B: usize>(blocks: &mut [Block<f64, B, MODES>]) -> Block<f64, MODES, MODES> {
    let product = |blocks: &[Block<f64, B, MODES>], a: usize, b: usize| -> f64 {
        blocks.iter().flatten().map(|row| row[a] * row[b]).sum()
    };
    let mut triangle = [[0.0; MODES]; MODES];
    for column in 0..MODES {
        let before = product(blocks, column, column).sqrt();
        for _ in 0..2 {
            for other in 0..column {
                let along = product(blocks, other, column);
                triangle[other][column] += along;
                let rows = blocks.as_flattened_mut().iter_mut();
                rows.for_each(|row| row[column] -= along * row[other]);
            }
        }
        let length = product(blocks, column, column).sqrt();
        let scale = if length > DEPENDENT * before { 1.0 / length } else { 0.0 };
        triangle[column][column] = if scale > 0.0 { length } else { 0.0 };
        blocks.as_flattened_mut().iter_mut().for_each(|row| row[column] *= scale);
    }
    triangle
}
