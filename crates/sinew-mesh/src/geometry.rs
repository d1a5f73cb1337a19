//! Volumes, surfaces, Jacobians, orientation, and distances that count as none.

use crate::{Element, Facet, Mesh, QuadraturePoint, TetMesh, TriangleMesh, remove_unused_nodes};
use nalgebra::Vector3;

/// Distance from a plane, a box or a sphere that still counts as on it \[relative to the diagonal of the mesh\]: files with six
/// digits round coordinates by a tenth of it.
pub const SELECTION_TOLERANCE: f64 = 1e-5;

/// Edges of the box around points \[length\]; −∞ without points.
pub fn extents(points: &[[f64; 3]]) -> [f64; 3] {
    let [low, high] = bounds(points.iter().map(|&x| x.into()));
    (high - low).into()
}

/// Lowest and highest corner of the box around points.
pub(crate) fn bounds(points: impl IntoIterator<Item = Vector3<f64>>) -> [Vector3<f64>; 2] {
    let far = Vector3::repeat(f64::INFINITY);
    points.into_iter().fold([far, -far], |[low, high], x| [low.inf(&x), high.sup(&x)])
}

/// Direction along which few nodes of a grid lie side by side.
pub(crate) const ASKEW: Vector3<f64> = Vector3::new(0.577, 0.211, 0.789);

/// Index of the first point at the place of each, within the shorter of the distances that both reach \[length\].
pub(crate) fn merged(points: &[[f64; 3]], reach: impl Fn(usize) -> f64) -> Vec<usize> {
    let place = |at: usize| Vector3::from(points[at]);
    let along: Vec<f64> = (0..points.len()).map(|at| place(at).dot(&ASKEW)).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_unstable_by(|&a, &b| along[a].total_cmp(&along[b]).then(a.cmp(&b)));
    let mut first: Vec<usize> = (0..points.len()).collect();
    for (rank, &a) in order.iter().enumerate() {
        // The direction is a little longer than 1.
        let near = |&&b: &&usize| along[b] - along[a] <= 1.01 * reach(a);
        for &b in order[rank + 1..].iter().take_while(near) {
            if (place(a) - place(b)).norm() <= reach(a).min(reach(b)) {
                let least = first[a].min(first[b]);
                (first[a], first[b]) = (least, least);
            }
        }
    }
    first
}

impl<const N: usize> Mesh<N> {
    /// The positions of a cell's nodes, its corners first.
    pub fn corners(&self, cell: usize) -> [Vector3<f64>; N] {
        self.cells[cell].map(|node| Vector3::from(self.points[node]))
    }

    /// Volume of a solid cell, negative when it is inside out (in a tetrahedron the vertices 1, 2, 3
    /// then run clockwise seen from outside), or area of a triangle, which is never negative [length
    /// unit cubed or squared]. Exact for curved cells too, but for the area of a quadratic triangle
    /// that is not plane, which comes from a rule of degree 2.
    pub fn cell_volume(&self, cell: usize) -> f64 {
        let corners = self.corners(cell);
        let [a, b, c] = [1, 2, 3 % N].map(|i| corners[i] - corners[0]);
        match N {
            4 => a.cross(&b).dot(&c) / 6.0,
            3 => a.cross(&b).norm() / 2.0,
            6 => integral(Self::QUADRATURE, |at| self.area_vector(cell, at).norm()),
            // The Jacobian of a quadratic tetrahedron is a cubic.
            _ => integral(Self::FINE_QUADRATURE, |at| self.jacobian(cell, at)),
        }
    }

    /// Volume (area) of a cell over that of the reference cell near the reference point `at`, see
    /// [`crate::Element::nodes`]: the determinant of the Jacobian. Of a triangle it is measured along
    /// the normal of its corners, so a cell is folded over where it is not positive.
    ///
    /// ```
    /// let beam = sinew_mesh::box_tetrahedra([2.0, 1.0, 1.0], [1; 3]).quadratic();
    /// assert!((beam.jacobian(0, [0.1, 0.2, 0.3]) - 2.0).abs() < 1e-14);
    /// ```
    pub fn jacobian(&self, cell: usize, at: [f64; 3]) -> f64 {
        if Self::ELEMENT.dimension == 3 {
            let [a, b, c] = self.tangents(cell, at);
            return a.cross(&b).dot(&c);
        }
        let [a, b, c] = [0, 1, 2].map(|k| Vector3::from(self.points[self.cells[cell][k]]));
        let normal = (b - a).cross(&(c - a));
        // A triangle whose corners lie on a line has no normal and no area.
        normal.try_normalize(0.0).map_or(0.0, |normal| self.area_vector(cell, at).dot(&normal))
    }

    fn area_vector(&self, cell: usize, at: [f64; 3]) -> Vector3<f64> {
        let [a, b, _] = self.tangents(cell, at);
        a.cross(&b)
    }

    /// Derivatives of the position along the reference axes.
    fn tangents(&self, cell: usize, at: [f64; 3]) -> [Vector3<f64>; 3] {
        let slopes = Self::shape_derivatives(at);
        let corners = self.corners(cell);
        let mut tangents = [Vector3::zeros(); 3];
        // Differences to one node, so that nothing cancels far from the origin.
        for (corner, slope) in corners.iter().zip(&slopes).skip(1) {
            for (tangent, s) in tangents.iter_mut().zip(slope) {
                *tangent += (corner - corners[0]) * *s;
            }
        }
        tangents
    }
}

fn integral(rule: &[QuadraturePoint], value: impl Fn([f64; 3]) -> f64) -> f64 {
    rule.iter().map(|point| point.weight * value(point.at)).sum()
}

/// Makes every solid cell positive by mirroring the local order of the negative ones (tetrahedra swap
/// their vertices 1 and 2, hexahedra bottom and top), and returns how many it mirrored. Facet sets
/// keep naming the same facets.
///
/// Triangles are turned counterclockwise where the mesh lies in a plane of constant `z`; the sides of a curved surface
/// are not distinguished, so nothing changes.
pub fn repair_orientation<const N: usize>(mesh: &mut Mesh<N>) -> usize {
    let element = Mesh::<N>::ELEMENT;
    let flat = element.dimension == 2;
    if flat && !mesh.points.windows(2).all(|pair| pair[0][2] == pair[1][2]) {
        return 0;
    }
    let mut mirrored = vec![false; mesh.cells.len()];
    for cell in 0..mesh.cells.len() {
        let corners = mesh.corners(cell);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let orientation = match element.corners {
            3 => normal.z,
            4 => normal.dot(&(corners[3 % N] - corners[0])),
            _ => mesh.jacobian(cell, [0.5; 3]),
        };
        if orientation < 0.0 {
            let nodes = mesh.cells[cell];
            mesh.cells[cell] = std::array::from_fn(|k| nodes[element.mirrored[k]]);
            mirrored[cell] = true;
        }
    }
    for facet in mesh.facet_sets.values_mut().flatten().filter(|facet| mirrored[facet.cell]) {
        facet.opposite = element.mirrored_facets[facet.opposite];
    }
    mirrored.iter().filter(|&&m| m).count()
}

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
    let triangle = |at| cone(&Mesh::<6>::shape(at), &Mesh::<6>::shape_derivatives(at));
    // The lowest facet of a hexahedron, whose four nodes are the first.
    let quadrilateral = |[x, y, _]: [f64; 3]| {
        2.0 * cone(&Mesh::<8>::shape([x, y, 0.0]), &Mesh::<8>::shape_derivatives([x, y, 0.0]))
    };
    match N {
        4 => cone(&Mesh::<3>::shape([0.0; 3]), &Mesh::<3>::shape_derivatives([0.0; 3])) / 2.0,
        10 => integral(Mesh::<6>::FINE_QUADRATURE, triangle),
        _ => integral(&Mesh::<8>::QUADRATURE[..4], quadrilateral),
    }
}
