//! Cells and rigid motions as errors and diagnoses name them.

use sinew_num::norm;
use std::fmt;

/// Components of a unit vector below this are left out of its name.
const NAMED: f64 = 1e-6;

/// A number and the cell that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellValue {
    /// Index of the cell.
    pub cell: usize,
    /// The number.
    pub value: f64,
}

impl fmt::Display for CellValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} (cell {})", self.value, self.cell)
    }
}

/// A rigid motion to first order, `translation + rotation × (X − centre)` with the centre of the held
/// nodes (of all nodes when none is held), or of the joints of a part that hangs on others by a node or edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMode {
    /// Velocity of the centre.
    pub translation: [f64; 3],
    /// Angular velocity.
    pub rotation: [f64; 3],
}

impl fmt::Display for RigidMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (translation, rotation) = (norm(&self.translation), norm(&self.rotation));
        if translation > NAMED {
            write!(f, "translation along {}", Axis(&self.translation))?;
        }
        if translation > NAMED && rotation > NAMED {
            write!(f, " with ")?;
        }
        if rotation > NAMED {
            write!(f, "rotation about {}", Axis(&self.rotation))?;
        }
        Ok(())
    }
}

/// An axis by name, or by components when it is not a coordinate axis.
struct Axis<'a>(&'a [f64; 3]);

impl fmt::Display for Axis<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let largest = self.0.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let present: Vec<_> = (0..3).filter(|&i| self.0[i].abs() > NAMED * largest).collect();
        match present[..] {
            [i] => write!(f, "{}", ["x", "y", "z"][i]),
            _ => write!(f, "({:.3}, {:.3}, {:.3})", self.0[0], self.0[1], self.0[2]),
        }
    }
}
