//! Populations of shapes: bodies that differ by a few numbers, drawn independently.

mod ventricle;

pub use ventricle::VentricleShape;

/// Errors of shapes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ShapeError {
    /// Too many or too few numbers, or one that is not finite.
    #[error("a shape has {most} finite numbers; {found} were given, or one of them is not finite")]
    Numbers { found: usize, most: usize },
    /// A measure outside the population's range.
    #[error("the {what} of {value:.3} is not between {least} and {most}: draw other numbers")]
    Measure { what: &'static str, value: f64, least: f64, most: f64 },
    /// Cells that make no mesh.
    #[error("a mesh cannot have {} cells; give {needed}", found.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x "))]
    Cells { found: Vec<usize>, needed: &'static str },
    /// A cell without volume \[length³\], or inverted.
    #[error("cell {cell} has a volume of {volume:.3e}: the shape is folded; draw other numbers")]
    Folded { cell: usize, volume: f64 },
}

fn within(what: &'static str, value: f64, [least, most]: [f64; 2]) -> Result<(), ShapeError> {
    let inside = (least..=most).contains(&value);
    inside.then_some(()).ok_or(ShapeError::Measure { what, value, least, most })
}

fn cells(found: &[usize], fit: bool, needed: &'static str) -> Result<(), ShapeError> {
    fit.then_some(()).ok_or_else(|| ShapeError::Cells { found: found.to_vec(), needed })
}

/// At most `N` finite numbers, followed by zeros.
fn padded<const N: usize>(numbers: &[f64]) -> Result<[f64; N], ShapeError> {
    let fits = numbers.len() <= N && numbers.iter().all(|x| x.is_finite());
    let all = std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0));
    fits.then_some(all).ok_or(ShapeError::Numbers { found: numbers.len(), most: N })
}

/// The mesh, if every tetrahedron has the orientation it should.
fn unfolded(mesh: crate::TetMesh) -> Result<crate::TetMesh, ShapeError> {
    let mut volumes = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).enumerate();
    let folded = volumes.find(|(_, volume)| volume.is_nan() || *volume <= 0.0);
    match folded {
        Some((cell, volume)) => Err(ShapeError::Folded { cell, volume }),
        None => Ok(mesh),
    }
}
