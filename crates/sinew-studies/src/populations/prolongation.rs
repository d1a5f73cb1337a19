//! Fields of a coarse mesh at the nodes of a finer one.

use nalgebra::{Const, Matrix3, SymmetricEigen, Vector3};

/// Values at other points from those at the nodes of a mesh of the same body, by moving least squares (P. Lancaster & K. Salkauskas,
/// Math. Comp. 37, 1981): fields that are linear in the position are met exactly, and points need not lie in a cell, so that the two
/// meshes may cut a curved surface differently.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Prolongation {
    /// Nodes and weights of the value at each point.
    rows: Vec<Vec<(usize, f64)>>,
}

/// Number of nodes for the value at a point: those of about three cells, which spread in all directions.
const NODES: usize = 12;
/// Distance within which a point counts as the node itself \[relative to that of the farthest node\].
const AT_NODE: f64 = 0.03;
/// Least spread of nodes in a direction with a slope \[relative to the largest spread\].
const FLAT: f64 = 1e-6;

impl Prolongation {
    /// Prolongation from nodes at `from` to points `to` \[length\], in the reference configuration.
    ///
    /// # Panics
    /// Where there is no node.
    pub(super) fn new(from: &[[f64; 3]], to: &[[f64; 3]]) -> Self {
        assert!(!from.is_empty(), "a field on no nodes has no value anywhere");
        let all: Vec<_> = (0..from.len()).map(|node| (node, 1.0)).collect();
        let directions = Neighbourhood::of(from, &[0.0; 3], all).directions();
        let row = |point: &[f64; 3]| {
            let nearest = nearest(from, point);
            // Where cells are stretched, the nearest nodes may lie on a line.
            let mut count = NODES.min(from.len());
            loop {
                let neighbourhood = Neighbourhood::of(from, point, weighed(&nearest[..count]));
                if count == from.len() || neighbourhood.directions() == directions {
                    return neighbourhood.shares();
                }
                count = (2 * count).min(from.len());
            }
        };
        Self { rows: to.iter().map(row).collect() }
    }

    /// The field with three components per point of three components per node.
    ///
    /// # Panics
    /// Where there are fewer values than nodes.
    pub(super) fn vectors(&self, values: &[f64]) -> Vec<f64> {
        let at = |row: &Vec<(usize, f64)>| -> [f64; 3] {
            std::array::from_fn(|i| {
                row.iter().map(|(node, share)| share * values[3 * node + i]).sum()
            })
        };
        self.rows.iter().flat_map(at).collect()
    }
}

/// Squared distances to all nodes with their numbers, the nearest first.
fn nearest(from: &[[f64; 3]], point: &[f64; 3]) -> Vec<(f64, usize)> {
    let squared = |x: &[f64; 3]| (Vector3::from(*x) - Vector3::from(*point)).norm_squared();
    let mut near: Vec<_> = from.iter().enumerate().map(|(node, x)| (squared(x), node)).collect();
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near
}

/// Weights that fall from the point to the last of its neighbours.
fn weighed(near: &[(f64, usize)]) -> Vec<(usize, f64)> {
    let radius = near.last().map_or(1.0, |last| last.0).max(f64::MIN_POSITIVE);
    let weight = |squared: f64| 1.0 / (squared / radius + AT_NODE.powi(2)).powi(2);
    near.iter().map(|&(squared, node)| (node, weight(squared))).collect()
}

/// Weighted nodes about a point.
struct Neighbourhood {
    /// Node, weight, place relative to the centre.
    nodes: Vec<(usize, f64, Vector3<f64>)>,
    total: f64,
    /// The centre, relative to the point.
    centre: Vector3<f64>,
    spread: SymmetricEigen<f64, Const<3>>,
}

impl Neighbourhood {
    fn of(from: &[[f64; 3]], point: &[f64; 3], weights: Vec<(usize, f64)>) -> Self {
        let apart = |node: usize| Vector3::from(from[node]) - Vector3::from(*point);
        let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
        let sum: Vector3<f64> = weights.iter().map(|&(node, weight)| weight * apart(node)).sum();
        let centre = sum / total;
        let placed = |(node, weight): (usize, f64)| (node, weight, apart(node) - centre);
        let nodes: Vec<_> = weights.into_iter().map(placed).collect();
        let spread: Matrix3<f64> =
            nodes.iter().map(|(_, weight, place)| *weight * place * place.transpose()).sum();
        Self { nodes, total, centre, spread: spread.symmetric_eigen() }
    }

    /// Weight of a direction by the spread of the nodes along it: zero where they do not spread.
    fn slope(&self, spread: f64) -> f64 {
        let flat = FLAT * self.spread.eigenvalues.max();
        if spread > flat { 1.0 / spread } else { 0.0 }
    }

    /// Directions in which the nodes spread.
    fn directions(&self) -> usize {
        self.spread.eigenvalues.iter().filter(|&&spread| self.slope(spread) > 0.0).count()
    }

    /// Weight of each node in the value at the point.
    fn shares(&self) -> Vec<(usize, f64)> {
        let vectors = &self.spread.eigenvectors;
        let slopes = self.spread.eigenvalues.map(|spread| self.slope(spread));
        // The point itself is the origin.
        let towards =
            -(vectors * Matrix3::from_diagonal(&slopes) * vectors.transpose() * self.centre);
        let share = |(node, weight, place): &(usize, f64, Vector3<f64>)| {
            (*node, weight * (1.0 / self.total + place.dot(&towards)))
        };
        self.nodes.iter().map(share).collect()
    }
}
