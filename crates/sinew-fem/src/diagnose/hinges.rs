//! Parts of a body that share only a node or an edge, so that they rotate against each other.

use crate::RigidMode;
use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector3};
use sinew_energy::Body;
use sinew_num::cells_of_nodes;

/// More hinged pieces than this are not analysed: the dense eigenvalues would take longer than a solve.
const MOST_PIECES: usize = 100;
/// A motion is free if joints and supports resist it by less than this \[relative to the largest resistance\].
const FREE: f64 = 1e-12;
/// Fewest shared nodes that may fix a cell.
const FIXING: usize = 2;
/// A piece takes part in a motion \[of unit norm\] when it moves by more than this.
const MOVES: f64 = 1e-6;

/// Cells that form a rigid piece, with the centre of its joints.
struct Piece {
    nodes: Vec<usize>,
    centre: Vector3<f64>,
    /// Largest distance of a node from the centre \[length\]; a unit rotation moves that node by a unit.
    size: f64,
}

/// A piece that can move although the body as a whole is supported: one of its nodes, their number, and its free rigid
/// motions.
pub(crate) fn free_piece(potential: &Body, parts: usize) -> Option<(usize, usize, Vec<RigidMode>)> {
    let pieces = pieces(potential);
    if pieces.len() == parts || pieces.len() > MOST_PIECES {
        return None;
    }
    let rows = rows(potential, &pieces);
    let eigen = SymmetricEigen::new(
        rows.iter().fold(DMatrix::zeros(6 * pieces.len(), 6 * pieces.len()), |sum, row| {
            sum + row * row.transpose()
        }),
    );
    let strongest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
    let free: Vec<_> = (0..6 * pieces.len())
        .filter(|&i| eigen.eigenvalues[i] <= FREE * strongest)
        .map(|i| eigen.eigenvectors.column(i))
        .collect();
    pieces.iter().enumerate().find_map(|(index, piece)| {
        let own: Vec<_> = free.iter().map(|mode| mode.rows(6 * index, 6)).collect();
        // The motions of this piece alone, without repetition.
        let own = DMatrix::from_fn(6, own.len().max(1), |i, k| own.get(k).map_or(0.0, |m| m[i]));
        let singular = own.svd(true, false);
        let directions = singular.u?;
        let moving =
            (0..singular.singular_values.len()).filter(|&k| singular.singular_values[k] > MOVES);
        let modes: Vec<_> = moving
            .map(|k| RigidMode {
                translation: std::array::from_fn(|i| directions[(i, k)]),
                rotation: std::array::from_fn(|i| directions[(3 + i, k)]),
            })
            .collect();
        (!modes.is_empty()).then(|| (piece.nodes[0], piece.nodes.len(), modes))
    })
}

/// Constraints of joints and supports: combinations of the pieces' velocities that must vanish, six components per
/// piece.
fn rows(potential: &Body, pieces: &[Piece]) -> Vec<DVector<f64>> {
    let mut owners = vec![Vec::new(); potential.nodes];
    for (index, piece) in pieces.iter().enumerate() {
        piece.nodes.iter().for_each(|&node| owners[node].push(index));
    }
    // Velocity of a node along an axis as part of a piece.
    let velocity =
        |row: &mut DVector<f64>, index: usize, node: usize, axis: &Vector3<f64>, sign: f64| {
            let piece = &pieces[index];
            let arm = (Vector3::from(potential.positions[node]) - piece.centre) / piece.size;
            let turn = arm.cross(axis);
            for i in 0..3 {
                row[6 * index + i] += sign * axis[i];
                row[6 * index + 3 + i] += sign * turn[i];
            }
        };
    let mut rows = Vec::new();
    let mut row = |terms: &[(usize, f64)], node: usize, axis: &Vector3<f64>| {
        let mut row = DVector::zeros(6 * pieces.len());
        terms.iter().for_each(|&(piece, sign)| velocity(&mut row, piece, node, axis, sign));
        rows.push(row);
    };
    for (node, owners) in owners.iter().enumerate() {
        let Some((&first, others)) = owners.split_first() else { continue };
        for i in 0..3 {
            let axis = Vector3::ith(i, 1.0);
            others.iter().for_each(|&other| row(&[(first, 1.0), (other, -1.0)], node, &axis));
            if potential.prescribed[3 * node + i].is_some() {
                row(&[(first, 1.0)], node, &potential.frames.axis(3 * node + i).into());
            }
        }
    }
    for spring in &potential.springs {
        let Some(&first) = owners[spring.node].first() else { continue };
        for direction in &spring.stiffness {
            let direction = Vector3::from(*direction);
            if direction.norm() > 0.0 {
                row(&[(first, 1.0)], spring.node, &direction.normalize());
            }
        }
    }
    rows
}

/// Rigid pieces: a cell belongs to a piece if they share three nodes that are not collinear (two in a plane).
fn pieces(potential: &Body) -> Vec<Piece> {
    let cells_of = cells_of_nodes(potential.nodes, potential.cell_nodes());
    let position = |node: &usize| Vector3::from(potential.positions[*node]);
    let plane = potential.element().dimension == 2;
    const NONE: usize = usize::MAX;
    let mut piece_of_cell = vec![NONE; potential.cell_count()];
    // The last piece that each node was counted for; for each cell, the last piece it shares nodes with and their
    // number.
    let mut piece_of_node = vec![NONE; potential.nodes];
    let mut shared = vec![(NONE, 0); potential.cell_count()];
    let mut pieces: Vec<Piece> = Vec::new();
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
        pieces.push(Piece { nodes, centre: Vector3::zeros(), size: 1.0 });
    }
    place(potential, &mut pieces);
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

/// Centres of the joints of each piece (of all its nodes if it has none), and sizes.
fn place(potential: &Body, pieces: &mut [Piece]) {
    let mut owners = vec![0; potential.nodes];
    pieces.iter().flat_map(|piece| &piece.nodes).for_each(|&node| owners[node] += 1);
    for piece in pieces {
        let at = |node: &usize| Vector3::from(potential.positions[*node]);
        let joints: Vec<_> = piece.nodes.iter().filter(|&&node| owners[node] > 1).collect();
        let of = if joints.is_empty() { piece.nodes.iter().collect() } else { joints };
        piece.centre = of.iter().map(|node| at(node)).sum::<Vector3<f64>>() / of.len() as f64;
        let distances = piece.nodes.iter().map(|node| (at(node) - piece.centre).norm());
        piece.size = distances.fold(0.0, f64::max);
    }
}
