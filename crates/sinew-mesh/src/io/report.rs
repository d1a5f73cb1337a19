//! Changes of a reader, in words.

use std::collections::BTreeMap;

/// Changes of a reader that made a mesh out of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadReport {
    /// Cells whose negative orientation was repaired by [`repair_orientation`](crate::repair_orientation).
    pub repaired_cells: usize,
    /// Cells of the boundary (such as triangles of a tetrahedral mesh, lines of a triangle mesh) that
    /// became members of facet sets.
    pub matched_facets: usize,
    /// Cells of the boundary's dimension that are not a facet of any cell, and were left out.
    pub unmatched_facets: usize,
    /// Facet sets that lack members of the file, because these are not facets of any cell: how many each.
    pub incomplete_sets: BTreeMap<String, usize>,
    /// Cells of still lower dimension (vertices, lines of a tetrahedral mesh), left out.
    pub dropped_cells: usize,
    /// Nodes that belong to no cell, left out with their rows of fields.
    pub unused_nodes: usize,
    /// Nodes at the place of another, within [`SELECTION_TOLERANCE`](crate::SELECTION_TOLERANCE).
    pub coincident_nodes: usize,
    /// Such nodes that became one with the other; see [`read_merged`](crate::read_merged).
    pub merged_nodes: usize,
    /// Arrays and elements of the file that are nothing of a mesh, such as arrays of text.
    pub left_out: Vec<String>,
    /// Whether the file's lengths were taken for µm, the unit of CARP, and converted to mm.
    pub in_micrometres: bool,
}

impl ReadReport {
    /// Doubts about the file, a sentence each: facets of no cell, nodes at the place of others.
    pub fn warnings(&self) -> Vec<String> {
        let mut said = Vec::new();
        let lacking = self.incomplete_sets.iter();
        let sets: String = lacking.map(|(name, n)| format!(", `{name}` lacks {n}")).collect();
        // Sides of elements that are none of the mesh are in sets alone.
        let count =
            self.unmatched_facets.max(self.incomplete_sets.values().copied().max().unwrap_or(0));
        if count > 0 {
            said.push(format!(
                "{} of the boundary left out, not faces of cells{sets}; write surface and cells from one mesh",
                counted(count, "element")
            ));
        }
        if self.coincident_nodes > 0 {
            said.push(format!(
                "{} at the place of another: cells do not hold together there; merge = true under [mesh] (`read_merged`) joins them",
                counted(self.coincident_nodes, "node")
            ));
        }
        said
    }

    /// Other changes, a phrase each.
    pub fn changes(&self) -> Vec<String> {
        let counts = [
            (self.merged_nodes, "node", "merged with others at the same place"),
            (self.unused_nodes, "node", "of no cell left out"),
            (self.dropped_cells, "point, line or collapsed element", "left out"),
            (self.repaired_cells, "cell", "of negative volume renumbered"),
        ];
        let some = counts.into_iter().filter(|(count, ..)| *count > 0);
        let counted = some.map(|(count, what, how)| format!("{} {how}", counted(count, what)));
        let left_out = self.left_out.iter().map(|what| format!("{what} left out"));
        let unit = "coordinates converted to mm from µm, the unit of CARP";
        counted.chain(left_out).chain(self.in_micrometres.then(|| unit.into())).collect()
    }
}

pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
