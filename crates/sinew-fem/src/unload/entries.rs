//! Small matrices that are not symmetric, added to a large one.

use super::lu::Entries;
use crate::linear::sparsity::Sparsity;

impl Entries {
    /// Adds a square matrix over the Cartesian components of some nodes, row by row; `places` are those of the sparsity, if it has
    /// them for these nodes, else they are looked up.
    pub(super) fn add(
        &mut self,
        sparsity: &Sparsity,
        nodes: &[usize],
        places: Option<&[u32]>,
        matrix: &mut [f64],
    ) {
        turn(sparsity, nodes, matrix);
        let size = 3 * nodes.len();
        let unknown = |local: usize| sparsity.unknown(3 * nodes[local / 3] + local % 3);
        for row in 0..size {
            for column in 0..=row {
                let (Some(r), Some(c)) = (unknown(row), unknown(column)) else { continue };
                let slot = match places {
                    Some(places) => places[row * (row + 1) / 2 + column] as usize,
                    None => slot(sparsity, r.max(c), r.min(c)),
                };
                let (direct, mirrored) = (matrix[row * size + column], matrix[column * size + row]);
                let (lower, upper) = if r >= c { (direct, mirrored) } else { (mirrored, direct) };
                self.lower[slot] += lower;
                self.upper[slot] += upper;
            }
        }
    }
}

/// Place of an entry of the lower half.
fn slot(sparsity: &Sparsity, row: usize, column: usize) -> usize {
    let start = sparsity.pattern.col_ptr()[column];
    let rows = &sparsity.pattern.row_idx()[start..sparsity.pattern.col_ptr()[column + 1]];
    start + rows.partition_point(|&r| r < row)
}

/// Turns the components of nodes with frames of their own along these.
fn turn(sparsity: &Sparsity, nodes: &[usize], matrix: &mut [f64]) {
    if sparsity.frames.is_empty() {
        return;
    }
    let size = 3 * nodes.len();
    for (a, &node) in nodes.iter().enumerate() {
        let Some(frame) = sparsity.frames.get(node) else { continue };
        // All rows, then all columns.
        for [own, across] in [[size, 1], [1, size]] {
            for other in 0..size {
                let place = |i: usize| (3 * a + i) * own + other * across;
                let turned = frame.apply(&std::array::from_fn(|i| matrix[place(i)]));
                (0..3).for_each(|i| matrix[place(i)] = turned[i]);
            }
        }
    }
}
