//! Grids of boxes and their names.

use crate::verify::case::Band;

/// Grids of boxes with the bands of an element on them.
pub(super) type Boxes = [([usize; 3], Band)];

/// Their name in a report.
pub(super) fn boxes([x, y, z]: [usize; 3]) -> String {
    format!("{x}×{y}×{z} boxes")
}
