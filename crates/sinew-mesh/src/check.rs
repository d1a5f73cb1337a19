//! The rules every mesh obeys.

use crate::{Field, Mesh, Refusal};
use std::collections::BTreeMap;

impl<const N: usize> Mesh<N> {
    /// A mesh without sets and fields.
    ///
    /// # Errors
    /// The first rule of [`Mesh::check`] that is broken.
    pub fn new(points: Vec<[f64; 3]>, cells: Vec<[usize; N]>) -> Result<Self, Refusal> {
        let mesh = Mesh { points, cells, ..Mesh::default() };
        mesh.check()?;
        Ok(mesh)
    }

    /// Checks that coordinates are finite, that cells name different nodes that exist, that
    /// fields have one row per node or cell and that sets name what exists; of hexahedra and
    /// quadratic cells also that the Jacobian is positive at every node. (Linear simplices may be
    /// flat or negative: [`crate::quality`] tells.)
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn check(&self) -> Result<(), Refusal> {
        check_points(&self.points)?;
        for (index, cell) in self.cells.iter().enumerate() {
            let raw = cell.map(|node| i64::try_from(node).unwrap_or(i64::MAX));
            check_cell(index, &raw, self.points.len())?;
        }
        self.check_shapes()?;
        check_fields(&self.point_fields, self.points.len())?;
        check_fields(&self.cell_fields, self.cells.len())?;
        check_sets(&self.node_sets, self.points.len())?;
        check_sets(&self.cell_sets, self.cells.len())?;
        for (set, facets) in &self.facet_sets {
            for facet in facets {
                check_member(set, facet.cell, self.cells.len())?;
                check_member(set, facet.opposite, Self::ELEMENT.facets.len())?;
            }
        }
        Ok(())
    }

    /// Checks that no cell whose Jacobian varies is folded over at a node.
    pub(crate) fn check_shapes(&self) -> Result<(), Refusal> {
        if N == Self::ELEMENT.dimension + 1 {
            return Ok(());
        }
        for cell in 0..self.cells.len() {
            for (local, &at) in Self::ELEMENT.nodes.iter().enumerate() {
                let jacobian = self.jacobian(cell, at);
                // An overflow is no Jacobian either.
                if jacobian.is_nan() || jacobian <= 0.0 {
                    let node = self.cells[cell][local];
                    return Err(Refusal(format!(
                        "cell {cell} is folded over at its node {node}: its Jacobian there is {jacobian:e}, but must \
                         be positive; move the node, or number the cell in the order of VTK"
                    )));
                }
            }
        }
        Ok(())
    }
}

pub(crate) fn check_points(points: &[[f64; 3]]) -> Result<(), Refusal> {
    let Some(node) = points.iter().position(|point| point.iter().any(|x| !x.is_finite())) else {
        return Ok(());
    };
    let [x, y, z] = points[node];
    Err(Refusal(format!("node {node} lies at ({x}, {y}, {z}); give it finite coordinates")))
}

/// Checks raw indices from a file, which may be negative.
pub(crate) fn check_cell(cell: usize, raw: &[i64], nodes: usize) -> Result<(), Refusal> {
    for (i, &node) in raw.iter().enumerate() {
        if usize::try_from(node).map_or(true, |node| node >= nodes) {
            let last = nodes.saturating_sub(1);
            return Err(Refusal(format!(
                "cell {cell} names node {node}, but nodes run from 0 to {last} (nodes: {nodes}); renumber its nodes"
            )));
        }
        if raw[..i].contains(&node) {
            return Err(Refusal(format!(
                "cell {cell} names node {node} twice; mesh it by cells without repeated nodes, such as tetrahedra"
            )));
        }
    }
    Ok(())
}

pub(crate) fn check_fields(fields: &BTreeMap<String, Field>, rows: usize) -> Result<(), Refusal> {
    for (name, field) in fields {
        let (components, values) = (field.components, field.values.len());
        if components == 0 || components.checked_mul(rows) != Some(values) {
            return Err(Refusal(format!(
                "field `{}` holds {values} numbers, but {rows} rows of {components} components are needed; resize it",
                name.escape_debug()
            )));
        }
    }
    Ok(())
}

fn check_sets(sets: &BTreeMap<String, Vec<usize>>, limit: usize) -> Result<(), Refusal> {
    for (set, members) in sets {
        members.iter().try_for_each(|&index| check_member(set, index, limit))?;
    }
    Ok(())
}

pub(crate) fn check_member(set: &str, index: usize, limit: usize) -> Result<(), Refusal> {
    if index < limit {
        return Ok(());
    }
    let set = set.escape_debug();
    Err(Refusal(format!(
        "set `{set}` names index {index}, but there are only {limit}; remove it from the set"
    )))
}
