//! Surfaces of tetrahedral meshes.

use crate::{Element, Facet, Mesh, QuadraturePoint, TetMesh, TriangleMesh, remove_unused_nodes};
use nalgebra::Vector3;

/// Takes facets out of a tetrahedral mesh, such as its [`crate::boundary_facets`]: triangles in their order, counterclockwise seen from
/// outside, with the point fields and node sets of the mesh and the cell fields of the cells behind. Their nodes in the mesh, ascending,
/// are those of [`Mesh::nodes_of_facets`].
///
/// ```
/// use sinew_mesh::{boundary_facets, box_tetrahedra, extract_surface};
/// let beam = box_tetrahedra([4.0, 1.0, 1.0], [4, 2, 2]);
/// let surface = extract_surface(&beam, &boundary_facets(&beam));
/// let area: f64 = (0..surface.cells.len()).map(|c| surface.cell_volume(c)).sum();
/// assert!((area - 18.0).abs() < 1e-12);
/// ```
pub fn extract_surface(mesh: &TetMesh, facets: &[Facet]) -> TriangleMesh {
    let owners: Vec<usize> = facets.iter().map(|facet| facet.cell).collect();
    let triangles = facets.iter().map(|&facet| mesh.facet_nodes(facet));
    let mut surface = mesh.with_other_cells(triangles.collect());
    surface.facet_sets.clear();
    surface.cell_sets.clear();
    surface.cell_fields.values_mut().for_each(|field| *field = field.select(&owners));
    remove_unused_nodes(&mut surface);
    surface
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
    let cone = |shape: &[f64], slopes: &[[f64; 3]]| {
        let at: Vector3<f64> = nodes.clone().zip(shape).map(|(x, n)| x * *n).sum();
        let along = |axis: usize| -> Vector3<f64> {
            nodes.clone().zip(slopes).map(|(x, slope)| x * slope[axis]).sum()
        };
        along(0).cross(&along(1)).dot(&at) / 3.0
    };
    let triangle = |&QuadraturePoint { at, weight }: &QuadraturePoint| {
        weight * cone(&Mesh::<6>::shape(at), &Mesh::<6>::shape_derivatives(at))
    };
    // The lowest facet of a hexahedron, whose four nodes are the first.
    let quadrilateral = |&QuadraturePoint { at: [x, y, _], weight }: &QuadraturePoint| {
        let at = [x, y, 0.0];
        2.0 * weight * cone(&Mesh::<8>::shape(at), &Mesh::<8>::shape_derivatives(at))
    };
    match N {
        4 => cone(&Mesh::<3>::shape([0.0; 3]), &Mesh::<3>::shape_derivatives([0.0; 3])) / 2.0,
        10 => Mesh::<6>::FINE_QUADRATURE.iter().map(triangle).sum(),
        _ => Mesh::<8>::QUADRATURE[..4].iter().map(quadrilateral).sum(),
    }
}
