//! Conversion of the cells of a file to a mesh, and its changes in words.

use super::cursor::{Fault, Result};
use super::grid::{MixedMesh, cell_type};
use super::sets::sets_from_fields;
use crate::check::{check_cell, check_fields, check_points};
use crate::mesh::are_labels;
use crate::topology::{Cells, sorted_key};
use crate::{Element, Facet, Field, Mesh, Refusal, remove_unused_nodes, repair_orientation};
use sinew_num::ascending;
use std::collections::{BTreeMap, BTreeSet};

/// Changes of a reader that made a mesh out of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadReport {
    /// Cells whose negative orientation was repaired by [`repair_orientation`](crate::repair_orientation).
    pub repaired_cells: usize,
    /// Cells of the boundary (such as triangles of a tetrahedral mesh, lines of a triangle mesh) that
    /// became members of facet sets.
    pub matched_facets: usize,
    /// Cells of the boundary's dimension that are not a facet of any cell, and were left out.
    pub unmatched_facets: usize,
    /// Facet sets that lack members of the file, because these are not facets of any cell: how many each.
    pub incomplete_sets: BTreeMap<String, usize>,
    /// Cells of still lower dimension (vertices, lines of a tetrahedral mesh), left out.
    pub dropped_cells: usize,
    /// Nodes that belong to no cell, left out with their rows of fields.
    pub unused_nodes: usize,
    /// Nodes at the place of another, within [`SELECTION_TOLERANCE`](crate::SELECTION_TOLERANCE).
    pub coincident_nodes: usize,
    /// Such nodes that became one with the other; see [`read_merged`](crate::read_merged).
    pub merged_nodes: usize,
    /// Nodes of one cell that are apart from one of another by less than 1 % of the shortest edge, and are not at its place.
    pub near_nodes: usize,
    /// Arrays and elements of the file that are nothing of a mesh, such as arrays of text.
    pub left_out: Vec<String>,
    /// Whether the file's lengths were taken for µm, the unit of CARP, and converted to mm.
    pub in_micrometres: bool,
}

impl ReadReport {
    /// Doubts about the file, a sentence each: facets of no cell, nodes at the place of others.
    pub fn warnings(&self) -> Vec<String> {
        let lacking = self.incomplete_sets.iter();
        let sets: String = lacking.map(|(name, n)| format!(", `{name}` lacks {n}")).collect();
        // Sides of elements that are none of the mesh are in sets alone.
        let most = self.incomplete_sets.values().copied().max().unwrap_or(0);
        let unmatched = format!(
            "of the boundary left out, not faces of cells{sets}; write surface and cells from one mesh"
        );
        phrases([
            (self.unmatched_facets.max(most), "element", &unmatched),
            (
                self.coincident_nodes,
                "node",
                "at the place of another: cells do not hold together there; merge = true under [mesh] joins them",
            ),
            (
                self.near_nodes,
                "node",
                "nearly at the place of another, less than 1 % of an edge apart: cells do not hold together there; if they are to, write \
                 the mesh with shared nodes",
            ),
        ])
    }

    /// Other changes, a phrase each.
    pub fn changes(&self) -> Vec<String> {
        let mut changes = phrases([
            (self.merged_nodes, "node", "merged with others at the same place"),
            (self.unused_nodes, "node", "of no cell left out"),
            (self.dropped_cells, "point, line or collapsed element", "left out"),
            (self.repaired_cells, "cell", "of negative volume renumbered"),
        ]);
        changes.extend(self.left_out.iter().map(|what| format!("{what} left out")));
        let unit = "coordinates converted to mm from µm, the unit of CARP";
        changes.extend(self.in_micrometres.then(|| unit.into()));
        changes
    }
}

/// Makes a mesh of the cells with `N` nodes.
pub(crate) fn to_mesh<const N: usize>(mut grid: MixedMesh) -> Result<(Mesh<N>, ReadReport), Fault> {
    let (parts, mut report) = examined(&mut grid, Mesh::<N>::ELEMENT)?;
    let nodes: Vec<usize> = parts.cells.iter().flat_map(|&index| grid.nodes(index)).collect();
    let pick = |(name, field): (&String, &Field)| (name.clone(), field.select(&parts.cells));
    let mut mesh = Mesh::<N> {
        points: std::mem::take(&mut grid.points),
        cells: nodes.as_chunks().0.to_vec(),
        point_fields: std::mem::take(&mut grid.point_fields),
        cell_fields: grid.cell_fields.iter().map(pick).collect(),
        ..Mesh::default()
    };
    mesh.facet_sets = facet_sets(&grid, &parts, mesh.cell_list(), &mut report);
    [mesh.cell_sets, mesh.node_sets] = sets(&grid, &parts, mesh.cell_list(), &mesh.facet_sets);
    let in_cells = |defect| (grid.cells_at, defect);
    sets_from_fields(&mut mesh).map_err(in_cells)?;
    report.unused_nodes = remove_unused_nodes(&mut mesh) - report.merged_nodes;
    report.repaired_cells = repair_orientation(&mut mesh);
    mesh.check_shapes().map_err(in_cells)?;
    Ok((mesh, report))
}

/// Cells of the grid by their part in the mesh, and the first half of the report; nodes at the same place are merged where that is
/// wanted.
fn examined(grid: &mut MixedMesh, element: &Element) -> Result<(Parts, ReadReport), Fault> {
    grid.rename_equal_cells();
    let (points_at, cells_at) = (grid.points_at, grid.cells_at);
    let [in_points, in_cells] = [points_at, cells_at].map(|at| move |defect| (at, defect));
    check_points(&grid.points).map_err(in_points)?;
    check_fields(&grid.point_fields, grid.points.len()).map_err(in_points)?;
    check_fields(&grid.cell_fields, grid.types.len()).map_err(in_cells)?;
    let ghosts = grid.ghosts();
    let [coincident_nodes, merged_nodes, near_nodes] = grid.coincident(&ghosts);
    let hidden = ghosts.iter().filter(|&&ghost| ghost).count();
    if hidden > 0 {
        grid.left_out.push(counted(hidden, "ghost or hidden cell"));
    }
    let parts = parts(grid, &ghosts, element).map_err(in_cells)?;
    let report = ReadReport {
        dropped_cells: parts.lower.len(),
        coincident_nodes,
        merged_nodes,
        near_nodes,
        left_out: std::mem::take(&mut grid.left_out),
        in_micrometres: grid.in_micrometres,
        ..ReadReport::default()
    };
    Ok((parts, report))
}

/// Facets of the cells by name; the report counts those of the grid that are of a cell, and those that are of none.
fn facet_sets(
    grid: &MixedMesh,
    parts: &Parts,
    cells: Cells<'_>,
    report: &mut ReadReport,
) -> BTreeMap<String, Vec<Facet>> {
    let matched = match_facets(grid, parts, cells);
    report.unmatched_facets = matched.values().filter(|facet| facet.is_none()).count();
    report.matched_facets = matched.len() - report.unmatched_facets;
    let mut sets = BTreeMap::new();
    for (name, facets) in named_facets(grid, parts, &matched, &mut report.left_out) {
        let lacking = facets.iter().filter(|facet| facet.is_none()).count();
        if lacking > 0 {
            report.incomplete_sets.insert(name.clone(), lacking);
        }
        sets.insert(name, ascending(facets.into_iter().flatten()));
    }
    sets.retain(|_, facets| !facets.is_empty());
    sets
}

/// Named sets of cells and of nodes: a group becomes one or both. The nodes of a curve join those of the facets of its name.
fn sets(
    grid: &MixedMesh,
    parts: &Parts,
    cells: Cells<'_>,
    facet_sets: &BTreeMap<String, Vec<Facet>>,
) -> [BTreeMap<String, Vec<usize>>; 2] {
    let (mut of_cells, mut of_nodes) = (BTreeMap::new(), grid.node_sets.clone());
    for (name, members) in &grid.groups {
        let own = members.iter().filter_map(|index| parts.cells.binary_search(index).ok());
        of_cells.insert(name.clone(), ascending(own));
        let lower = members.iter().filter(|index| parts.lower.binary_search(index).is_ok());
        let nodes: Vec<usize> = lower.flat_map(|&index| grid.nodes(index)).collect();
        if !nodes.is_empty() && !of_nodes.contains_key(name) {
            let facets = facet_sets.get(name).into_iter().flatten();
            let nodes = nodes.into_iter().chain(cells.of_facets(facets));
            of_nodes.insert(name.clone(), ascending(nodes));
        }
    }
    of_cells.retain(|_, set| !set.is_empty());
    [of_cells, of_nodes]
}

/// Indices of the cells of a grid by their part in the mesh, ascending.
#[derive(Default)]
struct Parts {
    cells: Vec<usize>,
    facets: Vec<usize>,
    lower: Vec<usize>,
}

/// VTK types of lower dimension than the facets, which are left out of a mesh of linear or quadratic
/// cells, quadratic edges (21) among them; of poly-lines and poly-vertices no facets are made.
fn is_lower(element: &Element, kind: u8) -> bool {
    let of_solid = kind == 3 || kind == 21 && element.is_quadratic();
    matches!(kind, 1 | 2 | 4) || element.dimension == 3 && of_solid
}

fn parts(grid: &MixedMesh, ghosts: &[bool], element: &Element) -> Result<Parts> {
    let mut parts = Parts::default();
    for (index, &kind) in grid.types.iter().enumerate().filter(|(index, _)| !ghosts[*index]) {
        let part = match kind {
            _ if kind == element.vtk_type => &mut parts.cells,
            _ if kind == element.facet_vtk_type => &mut parts.facets,
            _ if is_lower(element, kind) => &mut parts.lower,
            _ => return Err(refused_cell(element, index, kind)),
        };
        check_nodes(grid, index, cell_type(kind).2)?;
        part.push(index);
    }
    if parts.cells.is_empty() {
        return Err(Refusal::no_cells(element));
    }
    Ok(parts)
}

/// Checks the nodes of a cell; one with any number of nodes may name a node again, as a closed
/// line does.
fn check_nodes(grid: &MixedMesh, cell: usize, number: Option<usize>) -> Result<()> {
    let (nodes, total) = (grid.cell(cell), grid.points.len());
    let Some(expected) = number else {
        return nodes.chunks(1).try_for_each(|node| check_cell(cell, node, total));
    };
    let what = format_args!("nodes of cell {cell}, a {}", cell_type(grid.types[cell]).0);
    Refusal::require_count(what, expected, nodes.len())?;
    check_cell(cell, nodes, total)
}

fn refused_cell(element: &Element, cell: usize, kind: u8) -> Refusal {
    let quadratic = element.is_quadratic();
    let split = "split such cells into simplices, for example with VTK's \"Triangulate\"";
    let advice = match kind {
        10 if element.vtk_type == 5 => "extract the surface of the tetrahedra",
        5 | 10 if quadratic => {
            "export cells of one order; read linear ones as such and make it quadratic (formulation = \"quadratic\")"
        }
        21..=29 | 68..=72 => "export the mesh with linear (first-order) elements",
        6..=9 | 11..=14 => split,
        _ => "export only the cells of one kind",
    };
    let (kind, wanted) = (cell_type(kind).0, element.plural);
    Refusal(format!("cell {cell} is a {kind}, but the mesh wants {wanted}; {advice}"))
}

/// Facets of the boundary cells of a grid by their index; `None` where they are of no cell.
type Facets = BTreeMap<usize, Option<Facet>>;

/// The facet of the mesh behind each boundary cell of the grid. Between two cells the first one owns it.
fn match_facets(grid: &MixedMesh, parts: &Parts, cells: Cells<'_>) -> Facets {
    if parts.facets.is_empty() {
        return Facets::new();
    }
    let owner = cells.by_key(|_| true);
    let key = |index| sorted_key(grid.nodes(index).take(cells.element.facet_corners));
    parts.facets.iter().map(|&index| (index, owner.get(&key(index)).copied())).collect()
}

/// Facets by the names of groups and sides. Without groups each value of an integer cell field names those that have it, such
/// as `region:1`; without such a field all are `facets`; whole numbers of real fields name some too.
fn named_facets(
    grid: &MixedMesh,
    parts: &Parts,
    matched: &Facets,
    left_out: &mut Vec<String>,
) -> BTreeMap<String, Vec<Option<Facet>>> {
    let mut named = BTreeMap::<String, Vec<_>>::new();
    for (name, members) in &grid.groups {
        for facet in members.iter().filter_map(|index| matched.get(index)) {
            named.entry(name.clone()).or_default().push(*facet);
        }
    }
    if named.is_empty() && !matched.is_empty() {
        let mut all = true;
        for (name, field) in &grid.cell_fields {
            let Some(labels) = field.to_labels() else { continue };
            let own: BTreeSet<i64> = matched.keys().map(|&index| labels[index]).collect();
            if !are_labels(own.len(), matched.len()) {
                let what = "facet sets by the field";
                left_out.push(format!("{what} `{name}`, a numbering of {} values,", own.len()));
                continue;
            }
            all &= field.as_labels().is_none();
            for (&index, facet) in matched {
                named.entry(format!("{name}:{}", labels[index])).or_default().push(*facet);
            }
        }
        if all {
            named.insert("facets".into(), matched.values().copied().collect());
        }
    }
    for (name, sides) in &grid.sides {
        let cell = |index: &usize| parts.cells.binary_search(index).ok();
        let of = |&(index, opposite)| Some(Facet { cell: cell(&index)?, opposite });
        named.entry(name.clone()).or_default().extend(sides.iter().map(of));
    }
    named
}

/// Words for those counts that are not zero.
fn phrases<const N: usize>(counts: [(usize, &str, &str); N]) -> Vec<String> {
    let some = counts.into_iter().filter(|(count, ..)| *count > 0);
    some.map(|(count, what, how)| format!("{} {how}", counted(count, what))).collect()
}

pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
