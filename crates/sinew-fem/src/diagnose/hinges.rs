//! Parts of a body that share only a node or an edge, so that they rotate against each other.

use nalgebra::Vector3;
use sinew_energy::Body;
use sinew_num::cells_of_nodes;

/// Fewest shared nodes that may fix a cell.
const FIXING: usize = 2;

/// Nodes of rigid pieces: a cell belongs to a piece if they share three nodes that are not collinear (two in a plane).
pub(crate) fn pieces(potential: &Body) -> Vec<Vec<usize>> {
    let cells_of = cells_of_nodes(potential.nodes, potential.cell_nodes());
    let position = |node: &usize| Vector3::from(potential.positions[*node]);
    let plane = potential.element().dimension == 2;
    const NONE: usize = usize::MAX;
    let mut piece_of_cell = vec![NONE; potential.cell_count()];
    // The last piece that each node was counted for; for each cell, the last piece it shares nodes with and their
    // number.
    let mut piece_of_node = vec![NONE; potential.nodes];
    let mut shared = vec![(NONE, 0); potential.cell_count()];
    let mut pieces = Vec::new();
    for start in 0..potential.cell_count() {
        if piece_of_cell[start] != NONE {
            continue;
        }
        let index = pieces.len();
        let (mut nodes, mut joining) = (Vec::new(), vec![start]);
        piece_of_cell[start] = index;
        while let Some(cell) = joining.pop() {
            for &node in potential.nodes_of_cell(cell) {
                if std::mem::replace(&mut piece_of_node[node], index) == index {
                    continue;
                }
                nodes.push(node);
                for &other in &cells_of[node] {
                    if piece_of_cell[other] != NONE {
                        continue;
                    }
                    let (last, count) = shared[other];
                    let count = if last == index { count + 1 } else { 1 };
                    shared[other] = (index, count);
                    let fixed = || {
                        let corners = potential.nodes_of_cell(other).iter();
                        fixes(plane, corners.filter(|&&n| piece_of_node[n] == index).map(position))
                    };
                    if count >= FIXING && fixed() {
                        piece_of_cell[other] = index;
                        joining.push(other);
                    }
                }
            }
        }
        pieces.push(nodes);
    }
    pieces
}

/// Whether fixed nodes fix a cell: three that are not collinear in space, two in a plane.
fn fixes(plane: bool, mut places: impl Iterator<Item = Vector3<f64>>) -> bool {
    let (Some(first), Some(second)) = (places.next(), places.next()) else { return false };
    let along = second - first;
    // Nodes of a cell are not nearly on a line unless they are on an edge.
    plane
        || places
            .any(|x| along.cross(&(x - first)).norm() > 1e-9 * along.norm() * (x - first).norm())
}
