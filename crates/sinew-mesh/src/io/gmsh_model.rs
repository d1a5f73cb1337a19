//! Content of a gmsh file: nodes, elements and groups by their tags.

use super::cursor::{Cursor, Encoding};
use super::grid::{UnstructuredGrid, vtk_type};
use crate::Problem;
use std::collections::HashMap;

/// Versions whose sections are read.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) enum Version {
    #[default]
    None,
    Two,
    Four,
}

/// Entities read so far.
pub(super) struct Gmsh<'a> {
    pub cursor: Cursor<'a>,
    pub version: Version,
    /// Encoding of the binary sections, or text.
    pub binary: Encoding,
    pub grid: UnstructuredGrid,
    /// Names of physical groups by dimension and tag.
    pub names: HashMap<(i64, i64), String>,
    /// Physical tags of the model's entities by dimension and tag (version 4).
    pub physicals: HashMap<(i64, i64), Vec<i64>>,
    /// Index of each node tag.
    pub node_index: HashMap<i64, usize>,
    /// Index of each element tag.
    pub element_index: HashMap<i64, usize>,
}

impl Gmsh<'_> {
    /// Adds a node.
    pub(super) fn node(&mut self, tag: i64, point: [f64; 3]) -> Result<(), Problem> {
        if self.node_index.insert(tag, self.grid.points.len()).is_some() {
            return Err(Problem::expected("a node tag that is not used yet", tag.to_string()));
        }
        self.grid.points.push(point);
        Ok(())
    }

    /// Adds an element with the tags of its nodes and returns its index.
    pub(super) fn element(&mut self, kind: u8, nodes: &[i64]) -> Result<usize, Problem> {
        for tag in nodes {
            let Some(&index) = self.node_index.get(tag) else {
                return Err(Problem::expected("the tag of a node in $Nodes", tag.to_string()));
            };
            self.grid.connectivity.push(index as i64);
        }
        if kind == vtk_type::QUADRATIC_TETRAHEDRON
            && let [.., second_last, last] = self.grid.connectivity.as_mut_slice()
        {
            // gmsh numbers the middles of the edges 23 and 13 the other way round.
            std::mem::swap(second_last, last);
        }
        self.grid.types.push(kind);
        self.grid.offsets.push(self.grid.connectivity.len());
        Ok(self.grid.types.len() - 1)
    }

    /// Puts an element into a physical group.
    pub(super) fn join_group(&mut self, dimension: i64, tag: i64, element: usize) {
        // A minus sign means reversed orientation, which facets do not need.
        let tag = tag.saturating_abs();
        let named = self.names.get(&(dimension, tag)).cloned();
        let name = named.unwrap_or_else(|| format!("physical_{tag}"));
        self.grid.groups.entry(name).or_default().push(element);
    }
}

/// VTK type and number of nodes of a gmsh element type.
pub(super) fn element_type(gmsh_type: i64) -> Result<(u8, usize), Problem> {
    Ok(match gmsh_type {
        1 => (3, 2),
        2 => (5, 3),
        3 => (9, 4),
        4 => (10, 4),
        5 => (12, 8),
        6 => (13, 6),
        7 => (14, 5),
        8 => (21, 3),
        9 => (22, 6),
        10 => (28, 9),
        11 => (24, 10),
        12 => (29, 27),
        15 => (1, 1),
        16 => (23, 8),
        17 => (25, 20),
        18 => (26, 15),
        19 => (27, 13),
        _ => {
            return Err(Problem::Unsupported {
                what: "gmsh element type",
                value: gmsh_type.to_string(),
                advice: "save the mesh with first-order elements (Mesh.ElementOrder = 1)",
            });
        }
    })
}
