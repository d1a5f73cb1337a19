//! A mesh whose kind of cell is decided at run time.

use crate::geometry::{ASKEW, extents};
use crate::io::{save, to_xml};
use crate::topology::Cells;
use crate::tree::SurfaceTree;
use crate::{
    Element, Facet, Field, HexMesh, MeshError, QuadraticTetMesh, QuadraticTriangleMesh, Refusal,
    Selected, Selection, TetMesh, TriangleMesh,
};
use nalgebra::Vector3;
use sinew_num::{ascending, connected_components};
use std::collections::BTreeMap;
use std::path::Path;

/// A mesh of any one kind of cell, as files hold it.
///
/// ```
/// use sinew_mesh::{AnyMesh, box_hexahedra};
///
/// let mesh = AnyMesh::from(box_hexahedra([1.0; 3], [2, 1, 1]));
/// assert_eq!((mesh.element().name, mesh.points().len(), mesh.cells().len()), ("hexahedron", 12, 16));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum AnyMesh {
    /// Linear tetrahedra.
    Tetrahedra(TetMesh),
    /// Linear triangles.
    Triangles(TriangleMesh),
    /// Quadratic tetrahedra.
    QuadraticTetrahedra(QuadraticTetMesh),
    /// Quadratic triangles.
    QuadraticTriangles(QuadraticTriangleMesh),
    /// Trilinear hexahedra.
    Hexahedra(HexMesh),
}

/// Evaluates an expression on a mesh as the type that it has, whatever its cells are.
///
/// ```
/// use sinew_mesh::{AnyMesh, box_hexahedra, with_cells};
///
/// let mesh = AnyMesh::from(box_hexahedra([1.0; 3], [2, 1, 1]));
/// assert_eq!(with_cells!(&mesh, mesh => mesh.cells[0].len()), 8);
/// ```
#[macro_export]
macro_rules! with_cells {
    ($mesh:expr, $inner:ident => $body:expr) => {
        match $mesh {
            $crate::AnyMesh::Tetrahedra($inner) => $body,
            $crate::AnyMesh::Triangles($inner) => $body,
            $crate::AnyMesh::QuadraticTetrahedra($inner) => $body,
            $crate::AnyMesh::QuadraticTriangles($inner) => $body,
            $crate::AnyMesh::Hexahedra($inner) => $body,
        }
    };
}

impl AnyMesh {
    fn cell_list(&self) -> Cells<'_> {
        with_cells!(self, mesh => mesh.cell_list())
    }

    /// Shape of a cell.
    pub fn element(&self) -> &'static Element {
        self.cell_list().element
    }

    /// Node positions [length unit of the scene].
    pub fn points(&self) -> &[[f64; 3]] {
        with_cells!(self, mesh => &mesh.points)
    }

    /// Nodes of the cells, one cell after the other.
    pub fn cells(&self) -> &[usize] {
        self.cell_list().nodes
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        with_cells!(self, mesh => mesh.cells.len())
    }

    /// Named sets of nodes, ascending.
    pub fn node_sets(&self) -> &BTreeMap<String, Vec<usize>> {
        with_cells!(self, mesh => &mesh.node_sets)
    }

    /// Named sets of nodes, to add to.
    pub fn node_sets_mut(&mut self) -> &mut BTreeMap<String, Vec<usize>> {
        with_cells!(self, mesh => &mut mesh.node_sets)
    }

    /// Named sets of facets.
    pub fn facet_sets(&self) -> &BTreeMap<String, Vec<Facet>> {
        with_cells!(self, mesh => &mesh.facet_sets)
    }

    /// Named sets of facets, to add to.
    pub fn facet_sets_mut(&mut self) -> &mut BTreeMap<String, Vec<Facet>> {
        with_cells!(self, mesh => &mut mesh.facet_sets)
    }

    /// The cells of a named set or of a label, see [`Mesh::cells_of`](crate::Mesh::cells_of).
    pub fn cells_of(&self, name: &str) -> Option<Vec<usize>> {
        with_cells!(self, mesh => mesh.cells_of(name))
    }

    /// Names that [`AnyMesh::cells_of`] knows.
    pub fn names_of_cells(&self) -> Vec<String> {
        with_cells!(self, mesh => mesh.names_of_cells())
    }

    /// Cuts all but named cells away, see [`Mesh::keep`](crate::Mesh::keep).
    ///
    /// # Errors
    /// As [`Mesh::keep`](crate::Mesh::keep).
    pub fn keep<S: AsRef<str>>(&mut self, names: &[S]) -> Result<(), Refusal> {
        with_cells!(self, mesh => mesh.keep(names))
    }

    /// Names what a selection chooses, see [`Mesh::select`](crate::Mesh::select).
    ///
    /// # Errors
    /// As [`Mesh::select`](crate::Mesh::select).
    pub fn select(&mut self, name: &str, choice: &Selection) -> Result<Selected, Refusal> {
        with_cells!(self, mesh => mesh.select(name, choice))
    }

    /// The nodes at which a scalar point field is not zero, see [`Mesh::nodes_where_nonzero`](crate::Mesh::nodes_where_nonzero).
    ///
    /// # Errors
    /// As [`Mesh::nodes_where_nonzero`](crate::Mesh::nodes_where_nonzero).
    pub fn nodes_where_nonzero(&self, field: &str) -> Result<Vec<usize>, Refusal> {
        with_cells!(self, mesh => mesh.nodes_where_nonzero(field))
    }

    /// Named fields with one row per node.
    pub fn point_fields(&self) -> &BTreeMap<String, Field> {
        with_cells!(self, mesh => &mesh.point_fields)
    }

    /// Named fields with one row per node, to add to.
    pub fn point_fields_mut(&mut self) -> &mut BTreeMap<String, Field> {
        with_cells!(self, mesh => &mut mesh.point_fields)
    }

    /// Named fields with one row per cell.
    pub fn cell_fields(&self) -> &BTreeMap<String, Field> {
        with_cells!(self, mesh => &mesh.cell_fields)
    }

    /// Named fields with one row per cell, to add to.
    pub fn cell_fields_mut(&mut self) -> &mut BTreeMap<String, Field> {
        with_cells!(self, mesh => &mut mesh.cell_fields)
    }

    /// Whether the mesh is sound, see [`Mesh::check`](crate::Mesh::check).
    ///
    /// # Errors
    /// The first defect.
    pub fn check(&self) -> Result<(), Refusal> {
        with_cells!(self, mesh => mesh.check())
    }

    /// The unique undirected edges, see [`crate::edges`].
    pub fn edges(&self) -> Vec<[usize; 2]> {
        self.cell_list().edges()
    }

    /// The facets that belong to one cell only, see [`crate::boundary_facets`].
    pub fn boundary_facets(&self) -> Vec<Facet> {
        self.cell_list().boundary()
    }

    /// Nodes of a facet, counterclockwise seen from outside.
    pub fn nodes_of_facet(&self, facet: Facet) -> Vec<usize> {
        self.cell_list().of_facet(facet).collect()
    }

    /// Triangles between neighbouring nodes of the boundary's facets, counterclockwise seen from outside, and the cell of each; none of
    /// a body in two dimensions.
    pub fn boundary_triangles(&self) -> (Vec<[usize; 3]>, Vec<usize>) {
        if self.element().dimension == 2 { Default::default() } else { self.split_facets() }
    }

    /// [`AnyMesh::boundary_triangles`]; sides of a plane body have no thickness.
    fn split_facets(&self) -> (Vec<[usize; 3]>, Vec<usize>) {
        let split: &[[usize; 3]] = match (self.element().dimension, self.element().nodes.len()) {
            (2, 3) => &[[0, 1, 1]],
            (2, _) => &[[0, 2, 2], [2, 1, 1]],
            (_, 8) => &[[0, 1, 2], [0, 2, 3]],
            (_, 10) => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
            _ => &[[0, 1, 2]],
        };
        let facets = self.boundary_facets().into_iter().flat_map(|facet| {
            let nodes = self.nodes_of_facet(facet);
            split.iter().map(move |corners| (corners.map(|k| nodes[k]), facet.cell))
        });
        facets.unzip()
    }

    /// Nodes of the surface that lie on a cell without belonging to it, away from the corners of its facet, each with the first such cell: hanging nodes of a mesh
    /// that does not conform, or parts that touch. Such parts move independently of each other. So do quadratic cells with an edge of two middle nodes.
    ///
    /// ```
    /// use sinew_mesh::{AnyMesh, TetMesh};
    ///
    /// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
    /// let mesh: AnyMesh = TetMesh::new(points, vec![[0, 1, 2, 3], [1, 5, 4, 6]])?.into();
    /// assert_eq!(mesh.hanging_nodes(), [[4, 0]]); // in the middle of an edge
    /// # Ok::<(), sinew_mesh::Refusal>(())
    /// ```
    pub fn hanging_nodes(&self) -> Vec<[usize; 2]> {
        /// Distance from the facet \[relative to its longest edge\]: files hold three digits at least.
        const NEAR: f64 = 1e-3;
        let (triangles, cells) = self.split_facets();
        let place = |node: usize| Vector3::from(self.points()[node]);
        let tree = SurfaceTree::of(triangles.iter().map(|nodes| nodes.map(place)).collect());
        let size = self.element().nodes.len();
        let hangs = |node: usize| {
            let below = tree.below(place(node), NEAR).into_iter().map(|triangle| cells[triangle]);
            let others = below.filter(|&cell| !self.cells()[size * cell..][..size].contains(&node));
            others.min().map(|cell| [node, cell])
        };
        let nodes = ascending(triangles.as_flattened().iter().copied());
        let edges = self.cells().chunks_exact(size).enumerate().flat_map(|(cell, nodes)| {
            let quadratic = self.element().edges.iter().filter(|edge| edge.len() > 2);
            quadratic.map(move |edge| {
                let [a, b, middle] = [0, 1, 2].map(|k| nodes[edge[k]]);
                ([a.min(b), a.max(b)], middle, cell)
            })
        });
        let mut edges = ascending(edges);
        edges.dedup_by_key(|(ends, middle, _)| (*ends, *middle));
        let twice = edges.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let twice = twice.map(|pair| [pair[1].1, pair[0].2]);
        let mut hanging = ascending(twice.chain(nodes.into_iter().filter_map(hangs)));
        hanging.dedup_by_key(|[node, _]| *node);
        hanging
    }

    /// The boundary of a solid as triangles ([`AnyMesh::boundary_triangles`]), with the cell of each. The sides of a plane body become walls, two triangles each. Heights differ,
    /// so that walls at one place cross each other.
    pub fn boundary_surface(&self) -> (TriangleMesh, Vec<usize>) {
        let (mut points, (mut cells, mut owners)) =
            (self.points().to_vec(), self.boundary_triangles());
        if self.element().dimension == 2 {
            let (step, height) = (points.len(), 2.0 * extents(&points).iter().sum::<f64>());
            points.extend_from_within(..);
            for (node, point) in points.iter_mut().enumerate() {
                let part = 1.0 + 0.1 * (0.618 * node as f64).fract();
                point[2] += if node < step { -height } else { height * part };
            }
            for side in self.boundary_facets() {
                let [a, b] = [0, 1].map(|end| self.nodes_of_facet(side)[end]);
                cells.extend([[a, b, b + step], [a, b + step, a + step]]);
                owners.extend([side.cell; 2]);
            }
        }
        (TriangleMesh { points, cells, ..TriangleMesh::default() }, owners)
    }

    /// A cell of each part, joined by common nodes, of a solid or plane body that lies inside an odd number of others. Only one of two parts at one place is real.
    ///
    /// ```
    /// use sinew_mesh::{AnyMesh, TetMesh, box_tetrahedra};
    ///
    /// let TetMesh { mut points, mut cells, .. } = box_tetrahedra([9.0; 3], [3; 3]);
    /// let step = points.len();
    /// points.extend(box_tetrahedra([1.0; 3], [1; 3]).points.iter().map(|x| x.map(|x| x + 4.2)));
    /// cells.extend(box_tetrahedra([1.0; 3], [1; 3]).cells.iter().map(|cell| cell.map(|node| node + step)));
    /// assert_eq!(AnyMesh::from(TetMesh::new(points, cells)?).enclosed_parts(), [6 * 27]);
    /// # Ok::<(), sinew_mesh::Refusal>(())
    /// ```
    pub fn enclosed_parts(&self) -> Vec<usize> {
        let of_cells = || self.cells().chunks_exact(self.element().nodes.len());
        let parts = connected_components(self.points().len(), of_cells());
        if parts.len() < 2 {
            return Vec::new();
        }
        let tree = SurfaceTree::new(&self.boundary_surface().0);
        let mut is_least = vec![false; self.points().len()];
        parts.iter().for_each(|nodes| is_least[nodes[0]] = true);
        // A ray leaves the part's own surface once more than it enters it, all others as often unless it begins inside.
        let encloses = |nodes: &[usize]| {
            let corners = nodes[..self.element().corners].iter();
            let sum: Vector3<f64> = corners.map(|&node| Vector3::from(self.points()[node])).sum();
            tree.hits(sum / self.element().corners as f64, ASKEW).len().is_multiple_of(2)
        };
        let firsts = of_cells()
            .enumerate()
            .filter(|(_, nodes)| nodes.iter().any(|&node| std::mem::take(&mut is_least[node])));
        firsts.filter(|(_, nodes)| encloses(nodes)).map(|(cell, _)| cell).collect()
    }

    /// Moves every node.
    pub fn map_points(&mut self, place: impl Fn([f64; 3]) -> [f64; 3]) {
        with_cells!(self, mesh => mesh.points.iter_mut().for_each(|x| *x = place(*x)));
    }

    /// Puts the nodes at other places, one row per node.
    ///
    /// # Panics
    /// If there are not as many places as nodes.
    pub fn place_points(&mut self, places: &[[f64; 3]]) {
        with_cells!(self, mesh => mesh.points.copy_from_slice(places));
    }

    /// Writes a VTU file, see [`crate::to_vtu`].
    ///
    /// # Errors
    /// As [`crate::to_vtu`], and when the file cannot be written.
    pub fn write_vtu(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        self.write_vtu_with(path, &[])
    }

    /// [`AnyMesh::write_vtu`] with numbers that belong to the whole mesh, by name, such as parameters.
    ///
    /// # Errors
    /// As [`AnyMesh::write_vtu`].
    pub fn write_vtu_with(
        &self,
        path: impl AsRef<Path>,
        numbers: &[(String, f64)],
    ) -> Result<(), MeshError> {
        save(path.as_ref(), &with_cells!(self, mesh => to_xml(mesh, numbers))?)
    }
}

macro_rules! from {
    ($($mesh:ty => $variant:ident),*) => {
        $(impl From<$mesh> for AnyMesh {
            fn from(mesh: $mesh) -> Self {
                Self::$variant(mesh)
            }
        })*
    };
}
from!(
    TetMesh => Tetrahedra, TriangleMesh => Triangles, QuadraticTetMesh => QuadraticTetrahedra,
    QuadraticTriangleMesh => QuadraticTriangles, HexMesh => Hexahedra
);
