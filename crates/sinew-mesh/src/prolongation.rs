//! Fields of a coarse mesh at the nodes of a finer one.

use nalgebra::{Matrix3, Vector3};

/// Values at other points from those at the nodes of a mesh of the same body, by moving least squares (P. Lancaster & K. Salkauskas,
/// Math. Comp. 37, 1981): fields that are linear in the position are met exactly, and points need not lie in a cell, so that the two
/// meshes may cut a curved surface differently.
///
/// ```
/// use sinew_mesh::{Prolongation, box_tetrahedra};
///
/// let [coarse, fine] = [[3, 1, 1], [12, 4, 4]].map(|cells| box_tetrahedra([6.0, 2.0, 2.0], cells));
/// let field = |[x, y, z]: &[f64; 3]| [1.0 + x, 2.0 * y - z, 0.5 * x + z];
/// let found = Prolongation::new(&coarse.points, &fine.points).vectors(&coarse.points.iter().flat_map(field).collect::<Vec<_>>());
/// let exact = fine.points.iter().flat_map(field);
/// assert!(found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Prolongation {
    /// For each point the nodes that it is made of, and how much of each.
    rows: Vec<Vec<(usize, f64)>>,
}

/// Nodes that the value at a point is made of: those of three cells or so, which leave no direction out.
const NODES: usize = 12;
/// Distance, as a part of that of the farthest of them, within which a point counts as the node itself.
const AT_NODE: f64 = 0.03;
/// Directions in which nodes spread less than this, relative to where they spread most, have no slope.
const FLAT: f64 = 1e-6;

impl Prolongation {
    /// From nodes at `from` to points `to` \[length\], in the reference configuration.
    ///
    /// # Panics
    /// Where there is no node.
    pub fn new(from: &[[f64; 3]], to: &[[f64; 3]]) -> Self {
        assert!(!from.is_empty(), "a field on no nodes has no value anywhere");
        Self { rows: to.iter().map(|point| row(from, point)).collect() }
    }

    /// The field with three components per point of three components per node.
    ///
    /// # Panics
    /// Where there are fewer values than nodes.
    pub fn vectors(&self, values: &[f64]) -> Vec<f64> {
        let at = |row: &Vec<(usize, f64)>| -> [f64; 3] {
            std::array::from_fn(|i| {
                row.iter().map(|(node, share)| share * values[3 * node + i]).sum()
            })
        };
        self.rows.iter().flat_map(at).collect()
    }
}

fn row(from: &[[f64; 3]], point: &[f64; 3]) -> Vec<(usize, f64)> {
    let apart = |node: &[f64; 3]| Vector3::from(*node) - Vector3::from(*point);
    let mut near: Vec<(f64, usize)> =
        from.iter().enumerate().map(|(node, x)| (apart(x).norm_squared(), node)).collect();
    let last = NODES.min(near.len()) - 1;
    near.select_nth_unstable_by(last, |a, b| a.0.total_cmp(&b.0));
    let radius = near[last].0.max(f64::MIN_POSITIVE);
    let mut weights = Vec::with_capacity(NODES);
    let (mut total, mut centre) = (0.0, Vector3::zeros());
    for &(squared, node) in &near[..=last] {
        let weight = 1.0 / (squared / radius + AT_NODE.powi(2)).powi(2);
        total += weight;
        centre += weight * apart(&from[node]);
        weights.push((node, weight));
    }
    centre /= total;
    let from_centre = |node: usize| apart(&from[node]) - centre;
    let spread: Matrix3<f64> = weights
        .iter()
        .map(|&(node, weight)| weight * from_centre(node) * from_centre(node).transpose())
        .sum();
    let eigen = spread.symmetric_eigen();
    let flat = FLAT * eigen.eigenvalues.max();
    let slope = |value: f64| if value > flat { 1.0 / value } else { 0.0 };
    let inverse = eigen.eigenvectors
        * Matrix3::from_diagonal(&eigen.eigenvalues.map(slope))
        * eigen.eigenvectors.transpose();
    // The point itself is the origin.
    let towards = -(inverse * centre);
    let share = |&(node, weight): &(usize, f64)| {
        (node, weight * (1.0 / total + from_centre(node).dot(&towards)))
    };
    weights.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_met_where_nodes_lie_in_a_plane_and_points_beside_it() {
        let plane: Vec<[f64; 3]> =
            (0..16).map(|i| [f64::from(i % 4), f64::from(i / 4), 0.0]).collect();
        let found = Prolongation::new(&plane, &[[1.3, 1.7, 2.0]]);
        let values: Vec<f64> = plane.iter().flat_map(|x| [1.0, x[0], 3.0 * x[1]]).collect();
        let exact = [1.0, 1.3, 5.1];
        // Rounding of a dozen terms.
        assert!(found.vectors(&values).iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12));
        // One node is everywhere.
        assert_eq!(Prolongation::new(&[[1.0; 3]], &[[2.0; 3]]).vectors(&[5.0; 3]), [5.0; 3]);
    }
}
