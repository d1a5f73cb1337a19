//! Names for nodes and facets by where they are.

use crate::{Facet, Mesh, boundary_facets};

impl<const N: usize> Mesh<N> {
    /// Names the nodes at whose position \[length\] `chosen` holds, in place of a set of that name. Returns their number:
    /// none is not an error here, but one where a support or load names the set.
    ///
    /// ```
    /// let mut beam = sinew_mesh::box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 1]);
    /// assert_eq!(beam.name_nodes("middle", |[x, _, _]| x == 2.0), 4);
    /// assert_eq!(beam.name_facets("half of the top", |[x, _, z]| z == 1.0 && x <= 2.0), 4);
    /// ```
    pub fn name_nodes(&mut self, name: &str, chosen: impl Fn([f64; 3]) -> bool) -> usize {
        let nodes: Vec<_> = (0..self.points.len()).filter(|&n| chosen(self.points[n])).collect();
        let count = nodes.len();
        self.node_sets.insert(name.into(), nodes);
        count
    }

    /// Names the facets of the boundary with `chosen` at all their nodes, as [`Mesh::name_nodes`] does nodes.
    pub fn name_facets(&mut self, name: &str, chosen: impl Fn([f64; 3]) -> bool) -> usize {
        self.name_some(&boundary_facets(self), name, chosen)
    }

    fn name_some(
        &mut self,
        boundary: &[Facet],
        name: &str,
        chosen: impl Fn([f64; 3]) -> bool,
    ) -> usize {
        let on = |facet: &Facet| self.nodes_of_facet(*facet).all(|node| chosen(self.points[node]));
        let facets: Vec<_> = boundary.iter().copied().filter(on).collect();
        let count = facets.len();
        self.facet_sets.insert(name.into(), facets);
        count
    }

    /// Names the nodes of a side and the facets of the boundary on it.
    pub(crate) fn name_side(
        &mut self,
        boundary: &[Facet],
        name: &str,
        on_side: impl Fn([f64; 3]) -> bool,
    ) {
        self.name_nodes(name, &on_side);
        self.name_some(boundary, name, &on_side);
    }
}
