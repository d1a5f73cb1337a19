//! Cells that lie over each other.

use crate::SceneError;
use crate::error::listed;
use sinew_mesh::{Mesh, folded_facets};
use sinew_num::ascending;

/// Checks that no two cells lie on the same side of a facet.
pub(super) fn check_overlaps<const N: usize>(mesh: &Mesh<N>) -> Result<(), SceneError> {
    let folds = folded_facets(mesh);
    let Some(pair) = folds.first() else { return Ok(()) };
    let cells = pair.map(|facet| facet.cell);
    let corners = mesh.nodes_of_facet(pair[0]).take(Mesh::<N>::ELEMENT.facet_corners);
    let [first, second] = cells.map(|cell| ascending(mesh.cells[cell]));
    let advice = if first == second {
        "they are one cell listed twice: remove one"
    } else {
        "one is folded over the other, the mesh is tangled there: move their nodes apart, or mesh the body anew"
    };
    Err(SceneError::Body(format!(
        "cells {} lie on the same side of the facet with nodes {}; {advice}",
        cells.map(|cell| cell.to_string()).join(" and "),
        listed(&ascending(corners))
    )))
}
