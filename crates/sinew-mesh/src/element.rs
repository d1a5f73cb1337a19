//! The kinds of cells.

use crate::reference::{self, QuadraturePoint};
use crate::{Facet, Mesh};

/// Shape of a kind of cell. Node numbers are local and in the order of VTK.
///
/// ```
/// use sinew_mesh::QuadraticTetMesh;
/// let element = QuadraticTetMesh::ELEMENT;
/// assert_eq!((element.name, element.corners, element.facets.len()), ("quadratic tetrahedron", 4, 4));
/// assert_eq!(element.facets[3], [0, 2, 1, 6, 5, 4]);
/// ```
#[derive(Debug, PartialEq)]
pub struct Element {
    /// Name of one cell.
    pub name: &'static str,
    /// Name of many.
    pub plural: &'static str,
    /// VTK's number of the type.
    pub vtk_type: u8,
    /// VTK's number of the type of its facets.
    pub facet_vtk_type: u8,
    /// 2 or 3.
    pub dimension: usize,
    /// Number of corners, which are the first nodes; the others are in the middle of edges.
    pub corners: usize,
    /// Number of corners of a facet, which are its first nodes.
    pub facet_corners: usize,
    /// Nodes of each facet, counterclockwise seen from outside: corners first, then the nodes between
    /// the first and the second, the second and the third corner and so on. An edge of a triangle
    /// runs counterclockwise and has its middle node last. Facet `k` of a simplex is opposite to
    /// corner `k`.
    pub facets: &'static [&'static [usize]],
    /// Nodes of each edge: its two ends, then its middle node if it has one.
    pub edges: &'static [&'static [usize]],
    /// Reference coordinates of the nodes: corner 0 at the origin, corners of simplices on the unit
    /// axes, hexahedra the unit cube.
    pub nodes: &'static [[f64; 3]],
    /// The rule that energies are integrated with, and one of higher degree.
    pub(crate) quadrature: [&'static [QuadraturePoint]; 2],
    /// The order in which the nodes make the mirrored cell.
    pub(crate) mirrored: &'static [usize],
    /// The facets of the cell in those of the mirrored one.
    pub(crate) mirrored_facets: &'static [usize],
}

impl Element {
    /// The element with this number of nodes: 3, 4, 6, 8 or 10.
    ///
    /// # Panics
    /// With another number; in a constant that is an error of the compiler.
    pub const fn with_nodes(nodes: usize) -> &'static Element {
        match nodes {
            3 => &TRIANGLE,
            4 => &TETRAHEDRON,
            6 => &QUADRATIC_TRIANGLE,
            8 => &HEXAHEDRON,
            10 => &QUADRATIC_TETRAHEDRON,
            _ => panic!("cells have 3, 4, 6, 8 or 10 nodes"),
        }
    }

    /// Whether the edges have middle nodes.
    pub const fn is_quadratic(&self) -> bool {
        self.nodes.len() > self.corners
    }
}

impl<const N: usize> Mesh<N> {
    /// The kind of the cells.
    pub const ELEMENT: &'static Element = Element::with_nodes(N);

    /// The nodes of a facet in the order of [`Element::facets`], for any kind of cell; of tetrahedra, `facet_nodes` gives an array.
    ///
    /// ```
    /// use sinew_mesh::{Facet, box_hexahedra};
    /// let cube = box_hexahedra([1.0; 3], [1; 3]);
    /// let top = cube.nodes_of_facet(Facet { cell: 0, opposite: 5 });
    /// assert_eq!(top.collect::<Vec<_>>(), [4, 5, 7, 6]);
    /// ```
    pub fn nodes_of_facet(&self, facet: Facet) -> impl ExactSizeIterator<Item = usize> + Clone {
        let cell = self.cells[facet.cell];
        Self::ELEMENT.facets[facet.opposite].iter().map(move |&local| cell[local])
    }
}

const TRIANGLE: Element = Element {
    name: "triangle",
    plural: "triangles",
    vtk_type: 5,
    facet_vtk_type: 3,
    dimension: 2,
    corners: 3,
    facet_corners: 2,
    facets: &[&[1, 2], &[2, 0], &[0, 1]],
    edges: &[&[0, 1], &[1, 2], &[2, 0]],
    nodes: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    quadrature: [reference::TRIANGLE_1, reference::TRIANGLE_3],
    mirrored: &[0, 2, 1],
    mirrored_facets: &[0, 2, 1],
};

/// Reference coordinates of the corners, and of the middles of the edges behind them.
const fn with_middle_nodes<const N: usize>(linear: &Element) -> [[f64; 3]; N] {
    let (mut nodes, mut k) = ([[0.0; 3]; N], 0);
    while k < N {
        let corner = k < linear.corners;
        let edge: &[usize] = if corner { &[k, k] } else { linear.edges[k - linear.corners] };
        let [a, b] = [linear.nodes[edge[0]], linear.nodes[edge[1]]];
        nodes[k] = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])];
        k += 1;
    }
    nodes
}

const QUADRATIC_TRIANGLE: Element = Element {
    name: "quadratic triangle",
    plural: "quadratic triangles",
    vtk_type: 22,
    facet_vtk_type: 21,
    facets: &[&[1, 2, 4], &[2, 0, 5], &[0, 1, 3]],
    edges: &[&[0, 1, 3], &[1, 2, 4], &[2, 0, 5]],
    nodes: &with_middle_nodes::<6>(&TRIANGLE),
    quadrature: [reference::TRIANGLE_3, reference::TRIANGLE_6],
    mirrored: &[0, 2, 1, 5, 4, 3],
    ..TRIANGLE
};

const TETRAHEDRON: Element = Element {
    name: "tetrahedron",
    plural: "tetrahedra",
    vtk_type: 10,
    facet_vtk_type: 5,
    dimension: 3,
    corners: 4,
    facet_corners: 3,
    facets: &[&[1, 2, 3], &[0, 3, 2], &[0, 1, 3], &[0, 2, 1]],
    edges: &[&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]],
    nodes: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    quadrature: [reference::TETRAHEDRON_1, reference::TETRAHEDRON_4],
    mirrored: &[0, 2, 1, 3],
    mirrored_facets: &[0, 2, 1, 3],
};

const QUADRATIC_TETRAHEDRON: Element = Element {
    name: "quadratic tetrahedron",
    plural: "quadratic tetrahedra",
    vtk_type: 24,
    facet_vtk_type: 22,
    facets: &[&[1, 2, 3, 5, 9, 8], &[0, 3, 2, 7, 9, 6], &[0, 1, 3, 4, 8, 7], &[0, 2, 1, 6, 5, 4]],
    edges: &[&[0, 1, 4], &[1, 2, 5], &[2, 0, 6], &[0, 3, 7], &[1, 3, 8], &[2, 3, 9]],
    nodes: &with_middle_nodes::<10>(&TETRAHEDRON),
    quadrature: [reference::TETRAHEDRON_4, reference::TETRAHEDRON_14],
    mirrored: &[0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
    ..TETRAHEDRON
};

const HEXAHEDRON: Element = Element {
    name: "hexahedron",
    plural: "hexahedra",
    vtk_type: 12,
    facet_vtk_type: 9,
    dimension: 3,
    corners: 8,
    facet_corners: 4,
    facets: &[
        &[0, 4, 7, 3],
        &[1, 2, 6, 5],
        &[0, 1, 5, 4],
        &[3, 7, 6, 2],
        &[0, 3, 2, 1],
        &[4, 5, 6, 7],
    ],
    edges: &[
        &[0, 1],
        &[1, 2],
        &[2, 3],
        &[3, 0],
        &[4, 5],
        &[5, 6],
        &[6, 7],
        &[7, 4],
        &[0, 4],
        &[1, 5],
        &[2, 6],
        &[3, 7],
    ],
    nodes: &[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ],
    quadrature: [reference::HEXAHEDRON_8, reference::HEXAHEDRON_8],
    mirrored: &[4, 5, 6, 7, 0, 1, 2, 3],
    mirrored_facets: &[0, 1, 2, 3, 5, 4],
};
