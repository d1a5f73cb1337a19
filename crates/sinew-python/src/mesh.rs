//! Meshes from numpy arrays.

use crate::arrays::{Flat, triples};
use crate::errors::Result;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use sinew_mesh::{AnyMesh, Field, FieldValues, MixedMesh, ReadReport};
use std::sync::Mutex;

/// A mesh while it is put together: nodes, blocks of cells, names and fields.
#[pyclass(frozen, module = "pysinew._native")]
pub(crate) struct NativeMesh(Mutex<Option<MixedMesh>>);

impl NativeMesh {
    fn with<T>(&self, call: impl FnOnce(&mut MixedMesh) -> T) -> Result<T> {
        let mut held = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        Ok(call(held.as_mut().ok_or(MADE)?))
    }

    fn put(&self, name: &str, of_nodes: bool, field: Field) -> Result<()> {
        self.with(|mixed| {
            let fields = if of_nodes { &mut mixed.point_fields } else { &mut mixed.cell_fields };
            fields.insert(name.into(), field);
        })
    }

    /// The mesh, which can be made once.
    pub(crate) fn make(&self) -> Result<(AnyMesh, ReadReport)> {
        let taken = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
        Ok(taken.ok_or(MADE)?.into_mesh().map_err(|error| format!("mesh: {error}"))?)
    }
}

const MADE: &str = "the mesh is made already";

#[pymethods]
impl NativeMesh {
    /// Nodes, `n × 3`.
    #[new]
    fn new(points: Flat) -> Self {
        Self(Mutex::new(Some(MixedMesh::new(triples(points)))))
    }

    /// Adds cells of one kind, a row each; the number of the first of them.
    fn add_cells(&self, vtk_type: u8, cells: PyReadonlyArray2<'_, i64>) -> Result<usize> {
        let cells = cells.as_array();
        let indices: Vec<i64> = cells.iter().copied().collect();
        let added = self.with(|mixed| mixed.add_cells(vtk_type, cells.ncols(), &indices))?;
        Ok(added.map_err(|error| format!("mesh: {error}"))?.start)
    }

    /// Makes one node of those at the same place.
    fn merge_nodes(&self) -> Result<()> {
        self.with(|mixed| mixed.merge = true)
    }

    /// Names cells by their numbers.
    fn name_cells(&self, name: &str, cells: Flat<u64>) -> Result<()> {
        self.with(|mixed| mixed.name_cells(name, cells.0.iter().map(|&cell| cell as usize)))
    }

    /// Names nodes by their numbers.
    fn name_nodes(&self, name: &str, nodes: Flat<u64>) -> Result<()> {
        self.with(|mixed| mixed.name_nodes(name, nodes.0.iter().map(|&node| node as usize)))
    }

    /// Adds a field of real numbers, a row per node or per cell of any kind.
    fn add_field(&self, name: &str, of_nodes: bool, rows: PyReadonlyArray2<'_, f64>) -> Result<()> {
        let rows = rows.as_array();
        let values = FieldValues::Float(rows.iter().copied().collect());
        self.put(name, of_nodes, Field { components: rows.ncols(), values })
    }

    /// Adds a field of integers, a number per node or per cell of any kind.
    fn add_labels(&self, name: &str, of_nodes: bool, labels: Flat<i64>) -> Result<()> {
        self.put(name, of_nodes, Field::labels(labels.0))
    }
}
