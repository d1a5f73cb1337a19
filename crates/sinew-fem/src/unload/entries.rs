//! Small matrices that are not symmetric, added to a large one.

use super::lu::Entries;
use crate::elements::cell::turn_square;
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
