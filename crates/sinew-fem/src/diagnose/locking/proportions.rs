//! Slenderness of a body, and fineness of its mesh.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use sinew_energy::Body;

/// Proportions of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportions {
    /// Largest extent over thickness.
    pub slenderness: f64,
    /// Thickness over the mean size of the elements.
    pub elements_through_thickness: f64,
    /// Thickness over the mean length of the elements' longest edges.
    pub lengthwise: f64,
}

impl Proportions {
    /// `None` where the body has no size.
    pub(crate) fn of(potential: &Body) -> Option<Self> {
        let element = potential.element();
        let [longest, least] = principal_extents(&potential.positions, element.dimension)?;
        let volume: f64 = potential.volumes.iter().sum();
        // A strip's area is its length times half its edges, a rod's volume its length times a quarter of its
        // sides; a plate's is twice that, and bounded by its least extent.
        let sides = if element.dimension == 2 { 2.0 } else { 4.0 };
        let thickness = f64::min(least, sides * volume / surface(potential));
        let cells_of_box = match element.corners {
            3 => 2.0,
            4 => 6.0,
            _ => 1.0,
        };
        let box_volume = volume * cells_of_box / potential.cell_count() as f64;
        let size = box_volume.powf(1.0 / element.dimension as f64);
        (thickness > 0.0 && size > 0.0 && size.is_finite()).then_some(Self {
            slenderness: longest / thickness,
            elements_through_thickness: thickness / size,
            lengthwise: thickness / mean_longest_edge(potential),
        })
    }
}

/// Mean over the cells of the largest distance of neighbouring corners, diagonals of hexahedra left out \[length\].
fn mean_longest_edge(potential: &Body) -> f64 {
    let corners = potential.element().corners;
    let longest = |nodes: &[usize]| {
        let edges = (0..corners).flat_map(|i| (0..i).map(move |j| [i, j]));
        let edges = edges.filter(|edge| corners != 8 || HEXAHEDRON.contains(edge));
        let length = |[i, j]: [usize; 2]| {
            let [a, b] = [i, j].map(|corner| Vector3::from(potential.positions[nodes[corner]]));
            (a - b).norm()
        };
        edges.map(length).fold(0.0, f64::max)
    };
    potential.cell_nodes().map(longest).sum::<f64>() / potential.cell_count() as f64
}

/// Edges of a hexahedron, the larger corner first.
const HEXAHEDRON: [[usize; 2]; 12] = [
    [1, 0],
    [2, 1],
    [3, 2],
    [3, 0],
    [5, 4],
    [6, 5],
    [7, 6],
    [7, 4],
    [4, 0],
    [5, 1],
    [6, 2],
    [7, 3],
];

/// Area of the surface at rest, length of the edges in two dimensions.
fn surface(potential: &Body) -> f64 {
    let mesh = &potential.mesh;
    let size = |facet| {
        let nodes = mesh.nodes_of_facet(facet).into_iter();
        let corners = nodes.map(|node| Vector3::from(potential.positions[node]));
        match corners.collect::<Vec<_>>()[..] {
            [a, b] => (b - a).norm(),
            [a, b, c] => 0.5 * (b - a).cross(&(c - a)).norm(),
            // A quadrilateral by its diagonals.
            [a, b, c, d] => 0.5 * (c - a).cross(&(d - b)).norm(),
            _ => 0.0,
        }
    };
    mesh.boundary_facets().into_iter().map(size).sum()
}

/// Largest and least extent of points along the principal axes of their scatter, without the third axis in
/// two dimensions.
fn principal_extents(points: &[[f64; 3]], dimension: usize) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let centre = points.iter().fold(Vector3::zeros(), |sum, &p| sum + Vector3::from(p)) / count;
    let arms = || points.iter().map(|&p| Vector3::from(p) - centre);
    let scatter = arms().fold(Matrix3::zeros(), |sum, arm| sum + arm * arm.transpose());
    let axes = SymmetricEigen::new(scatter).eigenvectors;
    let mut extents = [0, 1, 2].map(|axis| {
        let along = || arms().map(|arm| arm.dot(&axes.column(axis)));
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    });
    extents.sort_by(|a, b| b.total_cmp(a));
    let (longest, least) = (extents[0], extents[dimension - 1]);
    (longest.is_finite() && least > 0.0).then_some([longest, least])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_are_along_the_principal_axes() {
        // A plate of 4 × 2 × 1, turned about the third axis by 30°.
        let (s, c) = 30f64.to_radians().sin_cos();
        let plate = sinew_mesh::box_hexahedra([4.0, 2.0, 1.0], [1; 3]);
        let turned: Vec<_> =
            plate.points.iter().map(|[x, y, z]| [c * x - s * y, s * x + c * y, *z]).collect();
        let [longest, least] = principal_extents(&turned, 3).unwrap();
        assert!((longest - 4.0).abs() < 1e-12 && (least - 1.0).abs() < 1e-12);
        let [_, least] = principal_extents(&turned[..4], 2).unwrap();
        assert!((least - 2.0).abs() < 1e-12, "{least}");
        assert_eq!(principal_extents(&[], 3), None);
    }
}
