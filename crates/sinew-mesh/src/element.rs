//! The kinds of cells, and the reference element of each: shape functions and quadrature.

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
        self.cell_list().of_facet(facet)
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
    quadrature: [TRIANGLE_1, TRIANGLE_3],
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
    quadrature: [TRIANGLE_3, TRIANGLE_6],
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
    quadrature: [TETRAHEDRON_1, TETRAHEDRON_4],
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
    quadrature: [TETRAHEDRON_4, TETRAHEDRON_14],
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
    quadrature: [HEXAHEDRON_8, HEXAHEDRON_8],
    mirrored: &[4, 5, 6, 7, 0, 1, 2, 3],
    mirrored_facets: &[0, 1, 2, 3, 5, 4],
};

/// A quadrature point of a reference element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates, see [`Element::nodes`].
    pub at: [f64; 3],
    /// Weight; all weights of a rule add up to the measure of the reference element.
    pub weight: f64,
}

impl<const N: usize> Mesh<N> {
    /// The rule that energies are integrated with.
    ///
    /// ```
    /// use sinew_mesh::Mesh;
    /// let volume: f64 = Mesh::<10>::QUADRATURE.iter().map(|point| point.weight).sum();
    /// assert!((volume - 1.0 / 6.0).abs() < 1e-15);
    /// ```
    pub const QUADRATURE: &'static [QuadraturePoint] = Self::ELEMENT.quadrature[0];

    /// A rule of higher degree, for terms with one more factor, such as those of a pressure field.
    pub const FINE_QUADRATURE: &'static [QuadraturePoint] = Self::ELEMENT.quadrature[1];

    /// Values of the shape functions of a cell at a point of the reference element, see [`Element::nodes`].
    ///
    /// ```
    /// use sinew_mesh::Mesh;
    /// assert_eq!(Mesh::<4>::shape([0.25; 3]), [0.25; 4]);
    /// let sum: f64 = Mesh::<10>::shape([0.1, 0.2, 0.3]).iter().sum();
    /// assert!((sum - 1.0).abs() < 1e-15);
    /// ```
    pub fn shape(at: [f64; 3]) -> [f64; N] {
        let element = Self::ELEMENT;
        let l = barycentric(element, at);
        std::array::from_fn(|a| match a.checked_sub(element.corners) {
            None if N == 8 => (0..3).map(|i| factor(element, a, i, at)).product(),
            None if element.is_quadratic() => l[a] * (2.0 * l[a] - 1.0),
            None => l[a],
            Some(edge) => 4.0 * l[element.edges[edge][0]] * l[element.edges[edge][1]],
        })
    }

    /// Derivatives of the shape functions along the reference axes; those of triangles along the third are zero.
    pub fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; N] {
        let element = Self::ELEMENT;
        let l = barycentric(element, at);
        let slope = |corner: usize, axis: usize| match corner {
            _ if axis >= element.dimension => 0.0,
            0 => -1.0,
            _ => f64::from(u8::from(corner == axis + 1)),
        };
        let derivative = |a: usize, i: usize| match a.checked_sub(element.corners) {
            None if N == 8 => {
                let across =
                    factor(element, a, (i + 1) % 3, at) * factor(element, a, (i + 2) % 3, at);
                (2.0 * element.nodes[a][i] - 1.0) * across
            }
            None if element.is_quadratic() => (4.0 * l[a] - 1.0) * slope(a, i),
            None => slope(a, i),
            Some(edge) => {
                let [b, c] = [0, 1].map(|end| element.edges[edge][end]);
                4.0 * (l[b] * slope(c, i) + l[c] * slope(b, i))
            }
        };
        std::array::from_fn(|a| std::array::from_fn(|i| derivative(a, i)))
    }
}

/// Barycentric coordinates of a point of a simplex.
fn barycentric(element: &Element, at: [f64; 3]) -> [f64; 4] {
    let first = at[..element.dimension].iter().fold(1.0, |rest, x| rest - x);
    [first, at[0], at[1], at[2]]
}

/// The factor along one axis of a shape function of the hexahedron.
fn factor(element: &Element, node: usize, axis: usize, at: [f64; 3]) -> f64 {
    if element.nodes[node][axis] == 1.0 { at[axis] } else { 1.0 - at[axis] }
}

const fn point(at: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { at, weight }
}

/// Degree 1.
const TRIANGLE_1: &[QuadraturePoint] = &[point([1.0 / 3.0, 1.0 / 3.0, 0.0], 0.5)];

const A: f64 = 1.0 / 6.0;
const B: f64 = 2.0 / 3.0;
/// Degree 2.
const TRIANGLE_3: &[QuadraturePoint] =
    &[point([A, A, 0.0], A), point([B, A, 0.0], A), point([A, B, 0.0], A)];

const C: f64 = 0.445_948_490_915_965;
const D: f64 = 0.091_576_213_509_771;
const WEIGHT_C: f64 = 0.5 * 0.223_381_589_678_011;
const WEIGHT_D: f64 = 0.5 * 0.109_951_743_655_322;
/// Degree 4 (D. A. Dunavant, Int. J. Numer. Meth. Engng 21, 1985).
const TRIANGLE_6: &[QuadraturePoint] = &[
    point([C, C, 0.0], WEIGHT_C),
    point([1.0 - 2.0 * C, C, 0.0], WEIGHT_C),
    point([C, 1.0 - 2.0 * C, 0.0], WEIGHT_C),
    point([D, D, 0.0], WEIGHT_D),
    point([1.0 - 2.0 * D, D, 0.0], WEIGHT_D),
    point([D, 1.0 - 2.0 * D, 0.0], WEIGHT_D),
];

/// Degree 1.
const TETRAHEDRON_1: &[QuadraturePoint] = &[point([0.25; 3], 1.0 / 6.0)];

const E: f64 = 0.138_196_601_125_010_5;
const F: f64 = 0.585_410_196_624_968_5;
/// Degree 2.
const TETRAHEDRON_4: &[QuadraturePoint] = &[
    point([E, E, E], 1.0 / 24.0),
    point([F, E, E], 1.0 / 24.0),
    point([E, F, E], 1.0 / 24.0),
    point([E, E, F], 1.0 / 24.0),
];

const G: f64 = 0.310_885_919_263_300_6;
const H: f64 = 0.092_735_250_310_891_22;
const I: f64 = 0.045_503_704_125_649_65;
const J: f64 = 0.5 - I;
const WEIGHT_G: f64 = 0.112_687_925_718_015_85 / 6.0;
const WEIGHT_H: f64 = 0.073_493_043_116_361_95 / 6.0;
const WEIGHT_I: f64 = 0.042_546_020_777_081_47 / 6.0;
/// Degree 5, all weights positive (N. J. Walkington, "Quadrature on simplices of arbitrary dimension", 2000).
const TETRAHEDRON_14: &[QuadraturePoint] = &[
    point([G, G, G], WEIGHT_G),
    point([1.0 - 3.0 * G, G, G], WEIGHT_G),
    point([G, 1.0 - 3.0 * G, G], WEIGHT_G),
    point([G, G, 1.0 - 3.0 * G], WEIGHT_G),
    point([H, H, H], WEIGHT_H),
    point([1.0 - 3.0 * H, H, H], WEIGHT_H),
    point([H, 1.0 - 3.0 * H, H], WEIGHT_H),
    point([H, H, 1.0 - 3.0 * H], WEIGHT_H),
    point([I, I, J], WEIGHT_I),
    point([I, J, I], WEIGHT_I),
    point([J, I, I], WEIGHT_I),
    point([I, J, J], WEIGHT_I),
    point([J, I, J], WEIGHT_I),
    point([J, J, I], WEIGHT_I),
];

const LOW: f64 = 0.211_324_865_405_187_1;
const HIGH: f64 = 1.0 - LOW;
/// Gauss' rule of degree 3 along each axis.
const HEXAHEDRON_8: &[QuadraturePoint] = &[
    point([LOW, LOW, LOW], 0.125),
    point([HIGH, LOW, LOW], 0.125),
    point([HIGH, HIGH, LOW], 0.125),
    point([LOW, HIGH, LOW], 0.125),
    point([LOW, LOW, HIGH], 0.125),
    point([HIGH, LOW, HIGH], 0.125),
    point([HIGH, HIGH, HIGH], 0.125),
    point([LOW, HIGH, HIGH], 0.125),
];
