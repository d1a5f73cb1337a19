//! Cells that lie over each other.

use crate::SceneError;
use crate::error::listed;
use sinew_mesh::{Facet, Mesh};
use sinew_num::ascending;

/// The most corners that a facet has.
const MOST_CORNERS: usize = 4;

/// Checks that no two cells lie on the same side of a facet: neighbours run around it in opposite senses.
///
/// Finds cells that are listed twice and cells that are folded over a neighbour.
pub(super) fn check_overlaps<const N: usize>(mesh: &Mesh<N>) -> Result<(), SceneError> {
    let (corners, facets) = (Mesh::<N>::ELEMENT.facet_corners, Mesh::<N>::ELEMENT.facets.len());
    let mut sides = Vec::with_capacity(facets * mesh.cells.len());
    for cell in 0..mesh.cells.len() {
        for opposite in 0..facets {
            let mut side = [usize::MAX; MOST_CORNERS];
            let nodes = mesh.nodes_of_facet(Facet { cell, opposite });
            side.iter_mut().zip(nodes.take(corners)).for_each(|(at, node)| *at = node);
            // The same sense from the smallest node on; the ends of an edge are in order as they are.
            if corners > 2 {
                let smallest = (0..corners).min_by_key(|&corner| side[corner]).unwrap_or(0);
                side[..corners].rotate_left(smallest);
            }
            sides.push((side, cell));
        }
    }
    sides.sort_unstable();
    let Some(pair) = sides.windows(2).find(|pair| pair[0].0 == pair[1].0) else { return Ok(()) };
    let cells = [pair[0].1, pair[1].1];
    let [first, second] = cells.map(|cell| ascending(mesh.cells[cell]));
    let advice = if first == second {
        "they are one cell listed twice: remove one"
    } else {
        "one is folded over the other, the mesh is tangled there: move their nodes apart, or mesh the body anew"
    };
    Err(SceneError::Body(format!(
        "cells {} lie on the same side of the facet with nodes {}; {advice}",
        cells.map(|cell| cell.to_string()).join(" and "),
        listed(&ascending(&pair[0].0[..corners]))
    )))
}
