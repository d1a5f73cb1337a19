//! Beams of random length, thickness, taper, waves, bend and twist.

use super::checked::{check_cells, padded};
use anyhow::{Result, ensure};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// A beam along x, about 100 long and 10 × 10 across; its numbers set length, thickness, taper, waves, bend and twist.
///
/// Numbers of mean zero and variance one, uniform over `[−√3, √3]`, make the population; 0 for all of them is the straight beam.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BeamShape {
    numbers: [f64; Self::NUMBERS],
}

/// Length and thickness of the straight beam.
const SIZE: [f64; 2] = [100.0, 10.0];
/// Deviations: of ln length; of ln thickness, its taper and two waves, across y and z; of bends \[length\]; of the twist \[rad\].
const DEVIATIONS: [f64; BeamShape::NUMBERS] =
    [0.115, 0.144, 0.173, 0.106, 0.106, 0.144, 0.173, 0.106, 0.106, 15.0, 15.0, 0.346];

impl BeamShape {
    /// Numbers of a shape.
    pub(crate) const NUMBERS: usize = 12;

    /// Shape of at most [`Self::NUMBERS`] numbers; those left out are zero.
    pub(crate) fn new(numbers: &[f64]) -> Result<Self> {
        let numbers: [f64; Self::NUMBERS] = padded(numbers)?;
        Ok(Self { numbers: std::array::from_fn(|i| DEVIATIONS[i] * numbers[i]) })
    }

    /// The mesh of [`box_tetrahedra`] with `cells` along each axis, in its place.
    pub(crate) fn tetrahedra(&self, cells: [usize; 3]) -> Result<TetMesh> {
        check_cells(&cells, cells.iter().all(|&n| n > 0), "one along each axis, or more")?;
        let mut mesh = box_tetrahedra([1.0; 3], cells);
        mesh.map_points(|x| self.place(x));
        for cell in 0..mesh.cells.len() {
            let volume = mesh.cell_volume(cell);
            ensure!(
                volume > 0.0,
                "cell {cell} has a volume of {volume:.3e}: the shape is folded; draw other numbers"
            );
        }
        Ok(mesh)
    }

    /// The place of a point of the unit cube.
    fn place(&self, [s, y, z]: [f64; 3]) -> [f64; 3] {
        let n = &self.numbers;
        let wave = std::f64::consts::TAU * s;
        let across = |n: &[f64]| {
            SIZE[1] * (n[0] + n[1] * (s - 0.5) + n[2] * wave.sin() + n[3] * wave.cos()).exp()
        };
        let (y, z) = ((y - 0.5) * across(&n[1..5]), (z - 0.5) * across(&n[5..9]));
        let (sin, cos) = (n[11] * s).sin_cos();
        [
            SIZE[0] * n[0].exp() * s,
            cos * y - sin * z + n[9] * s * s,
            sin * y + cos * z + n[10] * s * s,
        ]
    }
}
