//! Meshes from numpy arrays.

use crate::arrays::triples;
use crate::errors::Kind;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use sinew_mesh::{AnyMesh, Field, FieldValues, MixedMesh, ReadReport};
use std::sync::Mutex;

/// A mesh while it is put together: nodes, blocks of cells, names and fields.
#[pyclass(frozen, module = "pysinew._native")]
pub(crate) struct NativeMesh(Mutex<Option<MixedMesh>>);

impl NativeMesh {
    fn with<T>(&self, py: Python<'_>, call: impl FnOnce(&mut MixedMesh) -> T) -> PyResult<T> {
        let mut held = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mixed = held.as_mut().ok_or_else(|| Kind::Case.of(py, "the mesh is made already"))?;
        Ok(call(mixed))
    }

    fn put(&self, py: Python<'_>, name: &str, of_nodes: bool, field: Field) -> PyResult<()> {
        self.with(py, |mixed| match of_nodes {
            true => mixed.add_point_field(name, field),
            false => mixed.add_cell_field(name, field),
        })
    }

    /// The mesh, which can be made once.
    pub(crate) fn make(&self, py: Python<'_>) -> PyResult<(AnyMesh, ReadReport)> {
        let taken = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
        let mixed = taken.ok_or_else(|| Kind::Case.of(py, "the mesh is made already"))?;
        mixed.into_mesh().map_err(|error| Kind::Case.of(py, format!("mesh: {error}")))
    }
}

#[pymethods]
impl NativeMesh {
    /// Nodes, `n × 3`.
    #[new]
    fn new(points: PyReadonlyArray2<'_, f64>) -> Self {
        Self(Mutex::new(Some(MixedMesh::new(triples(&points)))))
    }

    /// Adds cells of one kind, a row each; the number of the first of them.
    fn add_cells(
        &self,
        py: Python<'_>,
        vtk_type: u8,
        cells: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<usize> {
        let cells = cells.as_array();
        let indices: Vec<i64> = cells.iter().copied().collect();
        let added = self.with(py, |mixed| mixed.add_cells(vtk_type, cells.ncols(), &indices))?;
        added.map(|range| range.start).map_err(|error| Kind::Case.of(py, format!("mesh: {error}")))
    }

    /// Makes one node of those at the same place.
    fn merge_nodes(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, MixedMesh::merge_nodes)
    }

    /// Names cells by their numbers.
    fn name_cells(
        &self,
        py: Python<'_>,
        name: &str,
        cells: PyReadonlyArray1<'_, u64>,
    ) -> PyResult<()> {
        let cells: Vec<usize> = cells.as_array().iter().map(|&cell| cell as usize).collect();
        self.with(py, |mixed| mixed.name_cells(name, cells))
    }

    /// Names nodes by their numbers.
    fn name_nodes(
        &self,
        py: Python<'_>,
        name: &str,
        nodes: PyReadonlyArray1<'_, u64>,
    ) -> PyResult<()> {
        let nodes: Vec<usize> = nodes.as_array().iter().map(|&node| node as usize).collect();
        self.with(py, |mixed| mixed.name_nodes(name, nodes))
    }

    /// Adds a field of real numbers, a row per node or per cell of any kind.
    fn add_field(
        &self,
        py: Python<'_>,
        name: &str,
        of_nodes: bool,
        rows: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let rows = rows.as_array();
        let values = FieldValues::Float(rows.iter().copied().collect());
        self.put(py, name, of_nodes, Field { components: rows.ncols(), values })
    }

    /// Adds a field of integers, a number per node or per cell of any kind.
    fn add_labels(
        &self,
        py: Python<'_>,
        name: &str,
        of_nodes: bool,
        labels: PyReadonlyArray1<'_, i64>,
    ) -> PyResult<()> {
        self.put(py, name, of_nodes, Field::labels(labels.as_array().to_vec()))
    }
}
