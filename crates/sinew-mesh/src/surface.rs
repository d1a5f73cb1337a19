//! Surfaces of tetrahedral meshes.

use crate::geometry::{HIGH, LOW};
use crate::{Element, Facet, Mesh, TetMesh, TriangleMesh};
use nalgebra::Vector3;

/// A surface with the node numbers of its tetrahedral mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The facets as triangles in their order, counterclockwise seen from outside, with the
    /// point fields and node sets of the mesh and the cell fields of the cells behind.
    pub mesh: TriangleMesh,
    /// Node of the tetrahedral mesh for each node of the surface, ascending.
    pub nodes: Vec<usize>,
}

/// Takes facets out of a tetrahedral mesh, such as its [`crate::boundary_facets`].
///
/// ```
/// use sinew_mesh::{boundary_facets, box_tetrahedra, extract_surface};
/// let beam = box_tetrahedra([4.0, 1.0, 1.0], [4, 2, 2]);
/// let surface = extract_surface(&beam, &boundary_facets(&beam));
/// let area: f64 = (0..surface.mesh.cells.len()).map(|c| surface.mesh.cell_volume(c)).sum();
/// assert!((area - 18.0).abs() < 1e-12);
/// ```
pub fn extract_surface(mesh: &TetMesh, facets: &[Facet]) -> Surface {
    let nodes = mesh.nodes_of_facets(facets);
    let mut new_index = vec![usize::MAX; mesh.points.len()];
    nodes.iter().enumerate().for_each(|(new, &old)| new_index[old] = new);
    let owners: Vec<usize> = facets.iter().map(|facet| facet.cell).collect();
    let triangle = |&facet: &Facet| mesh.facet_nodes(facet).map(|node| new_index[node]);
    let mut surface = TriangleMesh {
        points: nodes.iter().map(|&node| mesh.points[node]).collect(),
        cells: facets.iter().map(triangle).collect(),
        ..TriangleMesh::default()
    };
    for (name, set) in &mesh.node_sets {
        let kept = set.iter().map(|&node| new_index[node]).filter(|&node| node != usize::MAX);
        surface.node_sets.insert(name.clone(), kept.collect());
    }
    for (name, field) in &mesh.point_fields {
        surface.point_fields.insert(name.clone(), field.select(&nodes));
    }
    for (name, field) in &mesh.cell_fields {
        surface.cell_fields.insert(name.clone(), field.select(&owners));
    }
    Surface { mesh: surface, nodes }
}

/// The volume that facets enclose, by the divergence theorem N = ⅓ ∮ x·n dA [length unit
/// cubed]: positive when they face away from it, as the whole boundary does, and negative when
/// they face into it, as the wall of a cavity does.
///
/// An open surface is closed by the cone from its rim to the origin; put the origin into
/// the plane of the rim (a ventricle's base) to get the volume below that plane. The volume under
/// curved facets is exact.
pub fn enclosed_volume<const N: usize>(mesh: &Mesh<N>, facets: &[Facet]) -> f64 {
    const { assert!(Element::with_nodes(N).dimension == 3, "only solids enclose a volume") };
    facets.iter().map(|&facet| cone_volume(mesh, facet)).sum()
}

/// Signed volume between a facet and the origin.
fn cone_volume<const N: usize>(mesh: &Mesh<N>, facet: Facet) -> f64 {
    let nodes = mesh.nodes_of_facet(facet).map(|node| Vector3::from(mesh.points[node]));
    let mut x = [Vector3::zeros(); 6];
    x.iter_mut().zip(nodes).for_each(|(slot, node)| *slot = node);
    let cone = |(at, [along_s, along_t]): (Vector3<f64>, [Vector3<f64>; 2])| {
        along_s.cross(&along_t).dot(&at) / 3.0
    };
    match N {
        4 => x[0].cross(&x[1]).dot(&x[2]) / 6.0,
        10 => TRIANGLE_RULE.iter().map(|&(at, w)| w * cone(curved_triangle(&x, at))).sum(),
        _ => QUADRILATERAL_RULE.iter().map(|&at| 0.25 * cone(quadrilateral(&x, at))).sum(),
    }
}

/// Position on a quadratic triangle and its derivatives along both parameters.
fn curved_triangle(x: &[Vector3<f64>; 6], [s, t]: [f64; 2]) -> (Vector3<f64>, [Vector3<f64>; 2]) {
    let r = 1.0 - s - t;
    let at = x[0] * (r * (2.0 * r - 1.0)) + x[1] * (s * (2.0 * s - 1.0));
    let at = at
        + x[2] * (t * (2.0 * t - 1.0))
        + (x[3] * (r * s) + x[4] * (s * t) + x[5] * (t * r)) * 4.0;
    let back = x[0] * (1.0 - 4.0 * r);
    let along_s = back + x[1] * (4.0 * s - 1.0) + (x[3] * (r - s) + (x[4] - x[5]) * t) * 4.0;
    let along_t = back + x[2] * (4.0 * t - 1.0) + (x[5] * (r - t) + (x[4] - x[3]) * s) * 4.0;
    (at, [along_s, along_t])
}

/// Position on a bilinear quadrilateral and its derivatives along both parameters.
fn quadrilateral(x: &[Vector3<f64>; 6], [s, t]: [f64; 2]) -> (Vector3<f64>, [Vector3<f64>; 2]) {
    let (low, high) = (x[0].lerp(&x[1], s), x[3].lerp(&x[2], s));
    let along_s = (x[1] - x[0]).lerp(&(x[2] - x[3]), t);
    (low.lerp(&high, t), [along_s, high - low])
}

const C: f64 = 0.445_948_490_915_965;
const D: f64 = 0.091_576_213_509_771;
const WEIGHT_C: f64 = 0.5 * 0.223_381_589_678_011;
const WEIGHT_D: f64 = 0.5 * 0.109_951_743_655_322;
/// Degree 4, that of the cone over a quadratic triangle (D. A. Dunavant, Int. J. Numer. Meth. Engng
/// 21, 1985).
const TRIANGLE_RULE: [([f64; 2], f64); 6] = [
    ([C, C], WEIGHT_C),
    ([1.0 - 2.0 * C, C], WEIGHT_C),
    ([C, 1.0 - 2.0 * C], WEIGHT_C),
    ([D, D], WEIGHT_D),
    ([1.0 - 2.0 * D, D], WEIGHT_D),
    ([D, 1.0 - 2.0 * D], WEIGHT_D),
];

/// Gauss' rule of degree 3 along each side; the cone is of degree 2.
const QUADRILATERAL_RULE: [[f64; 2]; 4] = [[LOW, LOW], [HIGH, LOW], [LOW, HIGH], [HIGH, HIGH]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Field, boundary_facets, box_tetrahedra};

    /// Rounding of sums of some hundred numbers near 1.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn enclosed_volume_does_not_depend_on_the_origin() {
        let mut mesh = box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]);
        let boundary = boundary_facets(&mesh);
        assert!((enclosed_volume(&mesh, &boundary) - 6.0).abs() < ROUNDING);
        mesh.points.iter_mut().for_each(|point| point[1] += 5.0);
        assert!((enclosed_volume(&mesh, &boundary) - 6.0).abs() < 10.0 * ROUNDING);
    }

    #[test]
    fn a_cavity_is_negative() {
        let mut mesh = box_tetrahedra([3.0; 3], [3; 3]);
        // The six tetrahedra of the grid cell in the middle.
        let middle = 6 * (1 + 3 + 9);
        mesh.cells.drain(middle..middle + 6);
        let inside = |facet: &Facet| {
            let nodes = mesh.facet_nodes(*facet);
            nodes.iter().all(|&node| mesh.points[node].iter().all(|x| (1.0..=2.0).contains(x)))
        };
        let wall: Vec<Facet> = boundary_facets(&mesh).into_iter().filter(inside).collect();
        assert_eq!(wall.len(), 12);
        assert!((enclosed_volume(&mesh, &wall) + 1.0).abs() < ROUNDING);
    }

    #[test]
    fn surfaces_carry_fields_and_sets() {
        let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
        mesh.point_fields.insert("index".into(), Field::labels((0..12).collect()));
        mesh.cell_fields.insert("cell".into(), Field::labels((0..12).collect()));
        let facets = mesh.facet_sets["x_max"].clone();
        let Surface { mesh: side, nodes } = extract_surface(&mesh, &facets);
        assert_eq!(nodes, mesh.node_sets["x_max"]);
        assert_eq!(side.check(), Ok(()));
        assert_eq!(side.node_sets["x_max"], [0, 1, 2, 3]);
        assert_eq!(side.node_sets["y_min"], [0, 2]);
        assert_eq!(side.point_fields["index"].to_f64(), [2.0, 5.0, 8.0, 11.0].as_slice());
        let owners: Vec<f64> = facets.iter().map(|facet| facet.cell as f64).collect();
        assert_eq!(side.cell_fields["cell"].to_f64(), owners.as_slice());
    }
}
