//! Edges and facets, and names for nodes and facets by where they are.

use crate::{Element, Facet, Mesh, TetMesh};
use sinew_num::ascending;
use std::collections::HashMap;

/// The unique undirected edges as `[larger node, smaller node]`, ascending: the order
/// `[sender, receiver]` of the thesis' graphs. An edge with a middle node counts as its two halves.
pub fn edges<const N: usize>(mesh: &Mesh<N>) -> Vec<[usize; 2]> {
    mesh.cell_list().edges()
}

/// The facets that belong to one cell only, ascending by cell.
pub fn boundary_facets<const N: usize>(mesh: &Mesh<N>) -> Vec<Facet> {
    mesh.cell_list().boundary()
}

/// Facets whose two cells lie on the same side of them: cells that are listed twice or folded over a neighbour, which runs around
/// their common facet in the opposite sense.
///
/// ```
/// use sinew_mesh::{TetMesh, folded_facets};
///
/// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.2, 0.2, 2.0]];
/// let folded = TetMesh::new(points, vec![[0, 1, 2, 3], [0, 1, 2, 4]])?;
/// let [[first, second]] = folded_facets(&folded)[..] else { panic!("one fold") };
/// assert_eq!([first.cell, second.cell], [0, 1]);
/// # Ok::<(), sinew_mesh::Refusal>(())
/// ```
pub fn folded_facets<const N: usize>(mesh: &Mesh<N>) -> Vec<[Facet; 2]> {
    mesh.cell_list().folded()
}

/// The cells of a mesh as one type for all kinds, so that what reads them is compiled once.
#[derive(Clone, Copy)]
pub(crate) struct Cells<'m> {
    pub element: &'static Element,
    /// Nodes of the cells, one cell after the other.
    pub nodes: &'m [usize],
}

impl<'m> Cells<'m> {
    pub(crate) fn edges(self) -> Vec<[usize; 2]> {
        let mut edges = Vec::with_capacity(2 * self.nodes.len());
        for cell in self.nodes.chunks_exact(self.element.nodes.len()) {
            for edge in self.element.edges {
                let [a, b] = [cell[edge[0]], cell[edge[1]]];
                match edge.get(2).map(|&local| cell[local]) {
                    Some(middle) => edges.extend([[a, middle], [middle, b]]),
                    None => edges.push([a, b]),
                }
            }
        }
        edges.iter_mut().for_each(|edge| edge.sort_unstable_by(|a, b| b.cmp(a)));
        ascending(edges)
    }

    /// Every facet of every cell, inner ones twice.
    pub(crate) fn facets(self) -> impl DoubleEndedIterator<Item = Facet> {
        let (cells, number) =
            (self.nodes.len() / self.element.nodes.len(), self.element.facets.len());
        (0..cells * number).map(move |at| Facet { cell: at / number, opposite: at % number })
    }

    /// Nodes of a facet in the order of [`Element::facets`].
    pub(crate) fn of_facet(self, facet: Facet) -> impl ExactSizeIterator<Item = usize> + Clone {
        let cell = &self.nodes[facet.cell * self.element.nodes.len()..];
        self.element.facets[facet.opposite].iter().map(|&local| cell[local])
    }

    /// Nodes of facets, ascending.
    pub(crate) fn of_facets<'f>(self, facets: impl IntoIterator<Item = &'f Facet>) -> Vec<usize> {
        ascending(facets.into_iter().flat_map(|&facet| self.of_facet(facet)))
    }

    pub(crate) fn key(self, facet: Facet) -> FacetKey {
        sorted_key(self.of_facet(facet).take(self.element.facet_corners))
    }

    /// Some facets by their corners; of the two sides of an inner one the first.
    pub(crate) fn by_key(self, some: impl Fn(&Facet) -> bool) -> HashMap<FacetKey, Facet> {
        self.facets().filter(some).rev().map(|facet| (self.key(facet), facet)).collect()
    }

    /// Pairs of facets that their cells run around in the same sense.
    fn folded(self) -> Vec<[Facet; 2]> {
        let corners = self.element.facet_corners;
        let side = |facet: Facet| {
            let mut side = [usize::MAX; 4];
            side.iter_mut().zip(self.of_facet(facet).take(corners)).for_each(|(at, n)| *at = n);
            // The same sense from the smallest node on; the ends of an edge are in order as they are.
            if corners > 2 {
                let smallest = (0..corners).min_by_key(|&corner| side[corner]).unwrap_or(0);
                side[..corners].rotate_left(smallest);
            }
            side
        };
        let mut folded = Vec::new();
        self.for_sides(side, |sides| {
            let pairs = sides.windows(2).filter(|pair| pair[0].0 == pair[1].0);
            folded.extend(pairs.map(|pair| [pair[0].1, pair[1].1]));
        });
        folded
    }

    /// The facets that belong to one cell only, ascending by cell.
    pub(crate) fn boundary(self) -> Vec<Facet> {
        let mut boundary = Vec::new();
        self.for_sides(
            |facet| self.key(facet),
            |sides| {
                let alone = sides.chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() == 1);
                boundary.extend(alone.map(|sides| sides[0].1));
            },
        );
        boundary.sort_unstable();
        boundary
    }

    /// Calls `each` with all facets whose keys begin with the same node, in the order of their keys: counted by this node, then sorted among few.
    fn for_sides(
        self,
        key: impl Fn(Facet) -> FacetKey,
        mut each: impl FnMut(&[(FacetKey, Facet)]),
    ) {
        let nodes = self.nodes.iter().max().map_or(0, |last| last + 1);
        let mut starts = vec![0; nodes + 1];
        self.facets().for_each(|facet| starts[key(facet)[0] + 1] += 1);
        (0..nodes).for_each(|node| starts[node + 1] += starts[node]);
        let mut facets = vec![Facet { cell: 0, opposite: 0 }; starts[nodes]];
        let mut next = starts.clone();
        for facet in self.facets() {
            let slot = &mut next[key(facet)[0]];
            facets[*slot] = facet;
            *slot += 1;
        }
        let mut sides = Vec::new();
        for ends in starts.windows(2) {
            sides.clear();
            sides.extend(facets[ends[0]..ends[1]].iter().map(|&facet| (key(facet), facet)));
            sides.sort_unstable();
            each(&sides);
        }
    }
}

/// The corners of a facet ascending, then a filler: equal for the two sides of an inner facet.
pub(crate) type FacetKey = [usize; 4];

pub(crate) fn sorted_key(corners: impl Iterator<Item = usize>) -> FacetKey {
    let mut key = [usize::MAX; 4];
    key.iter_mut().zip(corners).for_each(|(slot, node)| *slot = node);
    key.sort_unstable();
    key
}

/// Whether each of so many is a member.
pub(crate) fn marked(length: usize, members: &[usize]) -> Vec<bool> {
    let mut marks = vec![false; length];
    members.iter().for_each(|&node| marks[node] = true);
    marks
}

/// Removes the nodes that belong to no cell, with their rows in fields and sets, and returns
/// how many there were. A solver would find no stiffness at such nodes.
pub fn remove_unused_nodes<const N: usize>(mesh: &mut Mesh<N>) -> usize {
    let used = marked(mesh.points.len(), mesh.cells.as_flattened());
    let is_used = |node: &usize| used[*node];
    let kept: Vec<usize> = (0..used.len()).filter(is_used).collect();
    if kept.len() == used.len() {
        return 0;
    }
    let mut new_index = vec![usize::MAX; used.len()];
    kept.iter().enumerate().for_each(|(new, &old)| new_index[old] = new);
    mesh.points = kept.iter().map(|&old| mesh.points[old]).collect();
    mesh.cells.as_flattened_mut().iter_mut().for_each(|node| *node = new_index[*node]);
    for field in mesh.point_fields.values_mut() {
        *field = field.select(&kept);
    }
    for set in mesh.node_sets.values_mut() {
        set.retain(is_used);
        set.iter_mut().for_each(|node| *node = new_index[*node]);
    }
    used.len() - kept.len()
}

impl<const N: usize> Mesh<N> {
    pub(crate) fn cell_list(&self) -> Cells<'_> {
        Cells { element: Self::ELEMENT, nodes: self.cells.as_flattened() }
    }

    /// Names the nodes at whose position \[length\] `chosen` holds, in place of a set of that name. Returns their number:
    /// none is not an error here, but one where a support or load names the set.
    ///
    /// ```
    /// let mut beam = sinew_mesh::box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 1]);
    /// assert_eq!(beam.name_nodes("middle", |[x, _, _]| x == 2.0), 4);
    /// assert_eq!(beam.name_facets("half of the top", |[x, _, z]| z == 1.0 && x <= 2.0), 4);
    /// ```
    pub fn name_nodes(&mut self, name: &str, chosen: impl Fn([f64; 3]) -> bool) -> usize {
        let nodes = (0..self.points.len()).filter(|&n| chosen(self.points[n])).collect();
        self.node_sets.insert(name.into(), nodes);
        self.node_sets[name].len()
    }

    /// Names the facets of the boundary with `chosen` at all their nodes, as [`Mesh::name_nodes`] does nodes.
    pub fn name_facets(&mut self, name: &str, chosen: impl Fn([f64; 3]) -> bool) -> usize {
        self.name_some(&boundary_facets(self), name, &chosen);
        self.facet_sets[name].len()
    }

    fn name_some(&mut self, boundary: &[Facet], name: &str, at: &dyn Fn([f64; 3]) -> bool) {
        let on = |facet: &Facet| self.nodes_of_facet(*facet).all(|node| at(self.points[node]));
        let facets = boundary.iter().copied().filter(on).collect();
        self.facet_sets.insert(name.into(), facets);
    }

    /// Names the nodes of a side and the facets of the boundary on it.
    pub(crate) fn name_side(&mut self, all: &[Facet], name: &str, at: impl Fn([f64; 3]) -> bool) {
        self.name_nodes(name, &at);
        self.name_some(all, name, &at);
    }

    /// The nodes of a set of facets, ascending.
    pub fn nodes_of_facets(&self, facets: &[Facet]) -> Vec<usize> {
        self.cell_list().of_facets(facets)
    }

    /// Other cells of the same nodes, with the sets and fields of this mesh.
    pub(crate) fn with_other_cells<const M: usize>(&self, cells: Vec<[usize; M]>) -> Mesh<M> {
        Mesh {
            points: self.points.clone(),
            cells,
            node_sets: self.node_sets.clone(),
            facet_sets: self.facet_sets.clone(),
            cell_sets: self.cell_sets.clone(),
            point_fields: self.point_fields.clone(),
            cell_fields: self.cell_fields.clone(),
        }
    }
}

impl TetMesh {
    /// The nodes of a facet, counterclockwise seen from outside its (positive) cell.
    pub fn facet_nodes(&self, facet: Facet) -> [usize; 3] {
        let local = Self::ELEMENT.facets[facet.opposite];
        std::array::from_fn(|k| self.cells[facet.cell][local[k]])
    }
}
