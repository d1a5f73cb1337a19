//! Grids of boxes in the elements of a formulation.

use crate::verify::case::{Band, Formulation};
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra};

/// Grids of boxes with the bands of an element on them.
pub(super) type Boxes = [([usize; 3], Band)];

pub(super) fn boxes([x, y, z]: [usize; 3]) -> String {
    format!("{x}×{y}×{z} boxes")
}

pub(super) fn box_mesh(size: [f64; 3], cells: [usize; 3], formulation: Formulation) -> AnyMesh {
    match formulation {
        Formulation::P1 | Formulation::FBar => box_tetrahedra(size, cells).into(),
        Formulation::P2 | Formulation::Mixed => box_tetrahedra(size, cells).quadratic().into(),
        Formulation::Q1 | Formulation::Q1FBar => box_hexahedra(size, cells).into(),
    }
}
