//! Content of a gmsh file: nodes, elements and groups by their tags.

use super::cursor::{Cursor, Encoding, Result};
use super::grid::{MixedMesh, cell_type, indices};
use crate::{Problem, QuadraticTetMesh};
use std::collections::{BTreeMap, HashMap};

/// Entities read so far.
#[derive(Default)]
pub(super) struct Gmsh<'a> {
    pub cursor: Cursor<'a>,
    /// Major version of the format, 0 until it is read.
    pub version: u8,
    /// Encoding of the binary sections, or text.
    pub binary: Encoding,
    pub grid: MixedMesh,
    /// Names of physical groups by dimension and tag.
    pub names: HashMap<(i64, i64), String>,
    /// Elements of physical groups by dimension and tag.
    pub groups: BTreeMap<(i64, i64), Vec<usize>>,
    /// Physical tags of the model's entities by dimension and tag (version 4).
    pub physicals: HashMap<(i64, i64), Vec<i64>>,
    /// Index of each node tag.
    pub node_index: HashMap<i64, usize>,
    /// Index of each element tag.
    pub element_index: HashMap<i64, usize>,
    /// Index of each element by type and nodes (version 2).
    pub known: HashMap<(u8, Vec<i64>), usize>,
}

impl Gmsh<'_> {
    /// Names the groups. Numbers of groups without a name are given anew in each dimension.
    pub(super) fn name_groups(&mut self) {
        let top = self.grid.types.iter().map(|&kind| cell_type(kind).1).max().unwrap_or(3);
        let groups = std::mem::take(&mut self.groups);
        let unnamed = |key: &(i64, i64)| groups.contains_key(key) && !self.names.contains_key(key);
        for (&(dimension, tag), members) in &groups {
            let mut others = (0..top).filter(|&other| other != dimension && dimension < top);
            let twice = others.any(|other| unnamed(&(other, tag)));
            let kinds = ["point_", "curve_", "surface_"].iter();
            let kind = kinds.filter(|_| twice).nth(dimension as usize).unwrap_or(&"");
            let named = self.names.get(&(dimension, tag)).cloned();
            let name = named.unwrap_or_else(|| format!("physical_{kind}{tag}"));
            self.grid.groups.entry(name).or_default().extend(members);
        }
    }

    /// Adds a node.
    pub(super) fn node(&mut self, tag: i64, point: [f64; 3]) -> Result<()> {
        let before = self.node_index.insert(tag, self.grid.points.len());
        Problem::unless_used(before.is_some(), "a node tag that is not used yet", tag)?;
        self.grid.points.push(point);
        Ok(())
    }

    /// Adds an element with the tags of its nodes and returns its index.
    pub(super) fn element(&mut self, kind: u8, nodes: &[i64]) -> Result<usize> {
        let index = |tag: &i64| self.node_index.get(tag);
        let mut nodes = indices(nodes, "the tag of a node in $Nodes", index)?;
        if kind == QuadraticTetMesh::ELEMENT.vtk_type {
            // gmsh numbers the middles of the edges 23 and 13 the other way round.
            nodes.swap(8, 9);
        }
        self.grid.push(kind, &nodes);
        Ok(self.grid.types.len() - 1)
    }

    /// Puts an element into a physical group.
    pub(super) fn join_group(&mut self, dimension: i64, tag: i64, element: usize) {
        // A minus sign means reversed orientation, which facets do not need.
        self.groups.entry((dimension, tag.saturating_abs())).or_default().push(element);
    }
}

/// VTK types of gmsh's element types from 0 on; 0 for those without one.
const VTK_TYPES: [u8; 20] =
    [0, 3, 5, 9, 10, 12, 13, 14, 21, 22, 28, 24, 29, 0, 0, 1, 23, 25, 26, 27];

/// VTK type and number of nodes of a gmsh element type.
pub(super) fn element_type(gmsh_type: i64) -> Result<(u8, usize)> {
    let vtk_type = usize::try_from(gmsh_type).ok().and_then(|index| VTK_TYPES.get(index).copied());
    let found = vtk_type.and_then(|vtk_type| Some((vtk_type, cell_type(vtk_type).2?)));
    found.ok_or_else(|| {
        let advice = "save the mesh with first-order elements (Mesh.ElementOrder = 1)";
        Problem::unsupported("gmsh element type", gmsh_type.to_string(), advice)
    })
}
