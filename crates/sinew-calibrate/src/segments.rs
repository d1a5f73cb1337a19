//! Divisions of a wall into segments.

use crate::error::{PatientError, Result, place_of, require};
use sinew_energy::listed;
use sinew_mesh::AnyMesh;
use sinew_num::ascending;

/// Segments of a mesh: each cell belongs to one or to none.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    names: Vec<String>,
    of_cell: Vec<Option<usize>>,
}

impl Segments {
    /// Segments from their names and the segment of each cell.
    ///
    /// # Errors
    /// A segment without cells.
    ///
    /// # Panics
    /// Where a cell is of a segment without name.
    pub fn new(names: Vec<String>, of_cell: Vec<Option<usize>>) -> Result<Self> {
        assert!(of_cell.iter().flatten().all(|&segment| segment < names.len()), "each has a name");
        for (place, segment) in names.iter().enumerate() {
            require(of_cell.contains(&Some(place)), || {
                format!(
                    "segment {segment} has no cells of {}: the mesh is too coarse for this division, or the wall does not reach there; take fewer segments",
                    of_cell.len()
                )
            })?;
        }
        Ok(Self { names, of_cell })
    }

    /// Segments by an integer field of the cells, named by its values; cells with a negative value belong to none.
    ///
    /// # Errors
    /// A field that is not there, has more than one component, or values that are no integers.
    pub fn by_field(mesh: &AnyMesh, field: &str) -> Result<Self> {
        let refuse = |problem: &str| {
            PatientError::Input(format!(
                "the cell field `{field}` {problem}; the mesh has {}",
                listed(&mesh.cell_fields().keys().collect::<Vec<_>>())
            ))
        };
        let found = mesh.cell_fields().get(field).ok_or_else(|| refuse("is not there"))?;
        let rows = found.to_vectors::<1>().ok_or_else(|| refuse("has more than one component"))?;
        let whole = |[value]: &[f64; 1]| value.fract() == 0.0 && value.abs() < f64::from(i32::MAX);
        if let Some([value]) = rows.iter().find(|row| !whole(row)) {
            return Err(refuse(&format!("has the value {value}, which is no integer")));
        }
        let values: Vec<i64> = rows.iter().map(|[value]| *value as i64).collect();
        let present = ascending(values.iter().copied().filter(|value| *value >= 0));
        if present.is_empty() {
            return Err(refuse("has no value that is not negative"));
        }
        let of_cell = values.iter().map(|value| present.binary_search(value).ok()).collect();
        Self::new(present.iter().map(i64::to_string).collect(), of_cell)
    }

    /// Names of the segments.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Segment of each cell, if it belongs to one.
    pub fn of_cell(&self) -> &[Option<usize>] {
        &self.of_cell
    }

    /// Cells of a segment, ascending.
    ///
    /// # Errors
    /// A name that no segment has.
    pub fn cells_of(&self, name: &str) -> Result<Vec<usize>> {
        let fault = || format!("there is no segment `{name}`; there are");
        let segment = place_of(name, &self.names, fault)?;
        let cells = 0..self.of_cell.len();
        Ok(cells.filter(|&cell| self.of_cell[cell] == Some(segment)).collect())
    }
}
