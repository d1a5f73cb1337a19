//! Middle nodes on edges.

use crate::topology::marked;
use crate::{
    Field, FieldValues, Mesh, QuadraticTetMesh, QuadraticTriangleMesh, TetMesh, TriangleMesh,
    boundary_facets, remove_unused_nodes,
};
use sinew_num::ascending;
use std::collections::BTreeMap;

impl TetMesh {
    /// Cells with a node in the middle of each edge; the nodes so far keep their numbers.
    ///
    /// Facet sets, cell sets and cell fields stay as they are. A middle node joins a node set with the
    /// facet set of the same name, when both have the same nodes, and otherwise when both ends of its
    /// edge belong to the set and the edge lies on the boundary, or when all corners of a cell around it
    /// belong. Real point fields are averaged on the edges (so unit vectors lose their length), integer
    /// ones take the smaller of the values at both ends, which keeps markers on what they mark.
    ///
    /// ```
    /// let beam = sinew_mesh::box_tetrahedra([10.0, 1.0, 1.0], [2, 1, 1]).quadratic();
    /// assert_eq!((beam.points.len(), beam.cells.len()), (5 * 3 * 3, 12));
    /// assert_eq!(beam.node_sets["x_min"].len(), 9);
    /// ```
    pub fn quadratic(&self) -> QuadraticTetMesh {
        with_middle_nodes(self)
    }
}

impl TriangleMesh {
    /// Cells with a node in the middle of each edge; see [`TetMesh::quadratic`].
    pub fn quadratic(&self) -> QuadraticTriangleMesh {
        with_middle_nodes(self)
    }
}

impl QuadraticTetMesh {
    /// The tetrahedra of the corners, for [`crate::quality`] and other things that know no middle
    /// nodes, which are left out with their rows in fields and sets.
    ///
    /// ```
    /// let beam = sinew_mesh::box_tetrahedra([10.0, 1.0, 1.0], [2, 1, 1]);
    /// assert_eq!(beam.quadratic().linear(), beam);
    /// ```
    pub fn linear(&self) -> TetMesh {
        let corners = self.cells.iter().map(|cell| std::array::from_fn(|k| cell[k]));
        let mut linear = self.with_other_cells(corners.collect());
        remove_unused_nodes(&mut linear);
        linear
    }
}

impl<const N: usize> Mesh<N> {
    /// Moves every node to where `place` puts it. A quadratic mesh of a simple body becomes one of its
    /// curved image this way, with all nodes in their exact place.
    ///
    /// ```
    /// // A bar bent to a quarter of a ring.
    /// let mut ring = sinew_mesh::box_tetrahedra([1.0, 1.0, 1.0], [8, 1, 1]).quadratic();
    /// ring.map_points(|[x, y, z]| {
    ///     let (sin, cos) = (x * std::f64::consts::FRAC_PI_2).sin_cos();
    ///     [(2.0 - y) * sin, (2.0 - y) * cos, -z]
    /// });
    /// sinew_mesh::repair_orientation(&mut ring);
    /// assert_eq!(ring.check(), Ok(()));
    /// let volume: f64 = (0..ring.cells.len()).map(|cell| ring.cell_volume(cell)).sum();
    /// assert!((volume - 0.75 * std::f64::consts::PI).abs() < 1e-4);
    /// ```
    pub fn map_points(&mut self, place: impl Fn([f64; 3]) -> [f64; 3]) {
        self.points.iter_mut().for_each(|point| *point = place(*point));
    }
}

fn with_middle_nodes<const N: usize, const M: usize>(mesh: &Mesh<N>) -> Mesh<M> {
    // The unique edges as `[smaller node, larger node]`.
    let ends = ascending(crate::edges(mesh).into_iter().map(|[b, a]| [a, b]));
    let middle = |&[a, b]: &[usize; 2]| {
        let (a, b) = (mesh.points[a], mesh.points[b]);
        std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
    };
    let number = |a: usize, b: usize| {
        let at = ends.partition_point(|edge| *edge < [a.min(b), a.max(b)]);
        mesh.points.len() + at
    };
    let raise = |cell: &[usize; N]| {
        std::array::from_fn(|k| match k.checked_sub(N) {
            None => cell[k],
            Some(edge) => {
                let local = Mesh::<M>::ELEMENT.edges[edge];
                number(cell[local[0]], cell[local[1]])
            }
        })
    };
    let mut raised: Mesh<M> = mesh.with_other_cells(mesh.cells.iter().map(raise).collect());
    raised.points.extend(ends.iter().map(middle));
    let average = |(name, field): (&String, &Field)| (name.clone(), averaged(field, &ends));
    raised.point_fields = mesh.point_fields.iter().map(average).collect();
    raised.node_sets = lifted_sets(mesh, &raised);
    raised
}

/// A point field with a row for each edge behind its rows.
fn averaged(field: &Field, ends: &[[usize; 2]]) -> Field {
    let (mut field, width) = (field.clone(), field.components);
    let entries =
        |[a, b]: &[usize; 2]| (a * width..(a + 1) * width).zip(b * width..(b + 1) * width);
    for (a, b) in ends.iter().flat_map(entries) {
        match &mut field.values {
            FieldValues::Float(all) => all.push(0.5 * all[a] + 0.5 * all[b]),
            FieldValues::Integer(all) => all.push(all[a].min(all[b])),
        }
    }
    field
}

fn lifted_sets<const N: usize, const M: usize>(
    mesh: &Mesh<N>,
    raised: &Mesh<M>,
) -> BTreeMap<String, Vec<usize>> {
    let boundary = raised.nodes_of_facets(&boundary_facets(raised));
    let on_boundary = marked(raised.points.len(), &boundary);
    let lift = |(name, set): (&String, &Vec<usize>)| {
        let facets = mesh.facet_sets.get(name).filter(|f| mesh.nodes_of_facets(f) == *set);
        if let Some(facets) = facets {
            return (name.clone(), raised.nodes_of_facets(facets));
        }
        let mut belongs = marked(raised.points.len(), set);
        for cell in &raised.cells {
            let whole = cell[..N].iter().all(|&node| belongs[node]);
            for edge in Mesh::<M>::ELEMENT.edges {
                let [a, b, middle] = [0, 1, 2].map(|k| cell[edge[k]]);
                belongs[middle] |= belongs[a] && belongs[b] && (whole || on_boundary[middle]);
            }
        }
        (name.clone(), (0..belongs.len()).filter(|&node| belongs[node]).collect())
    };
    mesh.node_sets.iter().map(lift).collect()
}
