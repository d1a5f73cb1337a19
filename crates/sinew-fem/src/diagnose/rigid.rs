//! Supports that leave a body free to move, as a whole or in pieces that hinges join.

use crate::{Result, RigidMode, SolveError};
use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector3};
use sinew_energy::{Body, BodyArrays};
use sinew_num::{cells_of_nodes, connected_components};
use std::collections::{BTreeMap, HashSet};

/// More hinged pieces than this are not analysed: the dense eigenvalues would take longer than a solve.
const MOST_PIECES: usize = 100;
/// A motion counts as free when joints and supports resist it by less than this, relative to what they
/// resist most; a support that grips a millionth of the body's size still holds.
const FREE: f64 = 1e-12;
/// A piece takes part in a motion \[of unit norm\] when it moves by more than this.
const MOVES: f64 = 1e-6;

/// Checks that each connected part of the body, and each piece of it that is only hinged to the others, is held
/// against all rigid motions.
pub(crate) fn check_supports(body: &Body) -> Result<()> {
    let mut parts = connected_components(body.nodes, body.cell_nodes());
    // A node in no cell is held: lowering refuses others.
    parts.retain(|part| part.len() > 1);
    parts.chunks(1).try_for_each(|part| check(body, part))?;
    let pieces = pieces(body);
    let hinged = pieces.len() != parts.len() && pieces.len() <= MOST_PIECES;
    if hinged { check(body, &pieces) } else { Ok(()) }
}

/// Refuses a piece that can move, with its free rigid motions.
fn check(body: &Body, pieces: &[Vec<usize>]) -> Result<()> {
    let eigen = SymmetricEigen::new(resistance(body, pieces));
    let strongest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
    let free: Vec<_> = (0..6 * pieces.len())
        .filter(|&i| eigen.eigenvalues[i] <= FREE * strongest)
        .map(|i| eigen.eigenvectors.column(i))
        .collect();
    if free.is_empty() {
        return Ok(());
    }
    for (index, nodes) in pieces.iter().enumerate() {
        let mut own = DMatrix::from_fn(6, free.len(), |i, k| free[k][6 * index + i]);
        if pieces.len() > 1 {
            // The motions of this piece alone, without repetition.
            let singular = own.svd(true, false);
            let values = singular.singular_values.iter().enumerate();
            let moving: Vec<_> = values.filter(|(_, v)| **v > MOVES).map(|(k, _)| k).collect();
            own = singular.u.unwrap_or_default().select_columns(&moving);
        }
        if own.ncols() > 0 {
            let modes = own.column_iter().map(|motion| RigidMode {
                translation: std::array::from_fn(|i| motion[i]),
                rotation: std::array::from_fn(|i| motion[3 + i]),
            });
            let (node, modes) = (nodes[0], modes.collect());
            return Err(SolveError::FreeToMove { node, nodes: nodes.len(), modes });
        }
    }
    Ok(())
}

/// Resistance of joints, supports and springs against velocities of the pieces, six components per piece: translation, and rotation about the centre of
/// its joints (of its held nodes if it has none, else of all) in units that move its farthest node by a unit.
fn resistance(body: &Body, pieces: &[Vec<usize>]) -> DMatrix<f64> {
    let BodyArrays { prescribed, frames, springs, positions, .. } = &**body;
    let mut owners = BTreeMap::<usize, Vec<usize>>::new();
    for (index, nodes) in pieces.iter().enumerate() {
        nodes.iter().for_each(|&node| owners.entry(node).or_default().push(index));
    }
    let sprung: HashSet<_> =
        springs.iter().flat_map(|spring| spring.nodes.iter().copied()).collect();
    let at = |node: usize| Vector3::from(positions[node]);
    let arms = |nodes: &Vec<usize>| {
        let fixed = |n: &usize| (0..3).any(|i| prescribed[3 * n + i].is_some());
        let joints: Vec<_> = nodes.iter().filter(|node| owners[node].len() > 1).collect();
        let held: Vec<_> = nodes.iter().filter(|n| fixed(n) || sprung.contains(n)).collect();
        let found = [joints, held].into_iter().find(|nodes| !nodes.is_empty());
        let of = found.unwrap_or_else(|| nodes.iter().collect());
        let centre = of.iter().map(|&&node| at(node)).sum::<Vector3<f64>>() / of.len() as f64;
        let distances = nodes.iter().map(|&node| (at(node) - centre).norm());
        (centre, distances.fold(0.0, f64::max))
    };
    let arms: Vec<_> = pieces.iter().map(arms).collect();
    let size = 6 * pieces.len();
    let mut resistance = DMatrix::zeros(size, size);
    // The velocity of a node along an axis as part of a piece, or its difference from that as part of another.
    let velocity = |pieces: &[usize], node: usize, axis: Vector3<f64>| {
        let mut row = DVector::zeros(size);
        for (&piece, sign) in pieces.iter().zip([1.0, -1.0]) {
            let (centre, size) = arms[piece];
            let turn = ((at(node) - centre) / size).cross(&axis);
            row.fixed_rows_mut::<3>(6 * piece).copy_from(&(sign * axis));
            row.fixed_rows_mut::<3>(6 * piece + 3).copy_from(&(sign * turn));
        }
        row
    };
    for (&node, owners) in &owners {
        for i in 0..3 {
            let others = owners[1..].iter();
            let joined = |&other| velocity(&[owners[0], other], node, Vector3::ith(i, 1.0));
            others.map(joined).for_each(|row| resistance.ger(1.0, &row, &row, 1.0));
            if prescribed[3 * node + i].is_some() {
                let row = velocity(&owners[..1], node, frames.axis(3 * node + i).into());
                resistance.ger(1.0, &row, &row, 1.0);
            }
        }
    }
    let stiffest = springs.iter().flat_map(|spring| &spring.stiffness);
    let stiffest = stiffest.fold(f64::MIN_POSITIVE, |m: f64, k| m.max(k.abs()));
    for spring in springs {
        let of_node = |node: &usize| {
            let owners = owners.get(node)?;
            Some([0, 1, 2].map(|i| velocity(&owners[..1], *node, Vector3::ith(i, 1.0))))
        };
        // A facet belongs to one part.
        let Some(rows) = spring.nodes.iter().map(of_node).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let rows = rows.as_flattened();
        for (row, entries) in rows.iter().zip(spring.stiffness.chunks_exact(rows.len())) {
            for (other, entry) in rows.iter().zip(entries) {
                resistance.ger(entry / stiffest, row, other, 1.0);
            }
        }
    }
    resistance
}

/// Nodes of rigid pieces: a cell belongs to a piece if they share three nodes that are not collinear (two in a plane).
fn pieces(body: &Body) -> Vec<Vec<usize>> {
    let cells_of = cells_of_nodes(body.nodes, body.cell_nodes());
    let position = |node: &usize| Vector3::from(body.positions[*node]);
    let plane = body.element().dimension == 2;
    const NONE: usize = usize::MAX;
    let mut piece_of_cell = vec![NONE; body.cell_count()];
    // The last piece that has the node; hinges are in several.
    let mut piece_of_node = vec![NONE; body.nodes];
    let mut pieces = Vec::new();
    for start in 0..body.cell_count() {
        if piece_of_cell[start] != NONE {
            continue;
        }
        let index = pieces.len();
        let (mut nodes, mut joining) = (Vec::new(), vec![start]);
        piece_of_cell[start] = index;
        while let Some(cell) = joining.pop() {
            for &node in body.nodes_of_cell(cell) {
                if std::mem::replace(&mut piece_of_node[node], index) == index {
                    continue;
                }
                nodes.push(node);
                for &other in &cells_of[node] {
                    let corners = body.nodes_of_cell(other).iter();
                    let shared = corners.filter(|&&n| piece_of_node[n] == index).map(position);
                    if piece_of_cell[other] == NONE && fixes(plane, shared) {
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
