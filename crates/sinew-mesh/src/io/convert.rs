//! Conversion of the cells of a file to a mesh.

use super::cursor::Fault;
use super::grid::{UnstructuredGrid, cell_type_name, vtk_type};
use super::sets::sets_from_fields;
use crate::check::{check_cell, check_field, check_points};
use crate::topology::{FacetKey, facet_key, facets, sorted_key};
use crate::{Defect, Facet, Field, Mesh, Problem, repair_orientation};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// An integer cell field with more values than this on the facets of a file is taken for
/// numbering rather than for names of facet sets.
const MOST_LABELS: usize = 64;

/// Changes of a reader that made a mesh out of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadReport {
    /// Cells whose negative orientation was repaired by [`repair_orientation`].
    pub repaired_cells: usize,
    /// Cells of the boundary (such as triangles of a tetrahedral mesh, lines of a triangle mesh) that
    /// became members of facet sets.
    pub matched_facets: usize,
    /// Cells of the boundary's dimension that are not a facet of any cell, and were left out.
    pub unmatched_facets: usize,
    /// Cells of still lower dimension (vertices, lines of a tetrahedral mesh), left out.
    pub dropped_cells: usize,
    /// Nodes that belong to no cell. They are kept; see [`crate::remove_unused_nodes`].
    pub unused_nodes: usize,
}

/// Makes a mesh of the cells with `N` nodes.
pub(crate) fn to_mesh<const N: usize>(
    grid: UnstructuredGrid,
) -> Result<(Mesh<N>, ReadReport), Fault> {
    let cells_at = grid.cells_at;
    check_grid(&grid)?;
    let sorted = sort_cells::<N>(&grid).map_err(|problem| (cells_at, problem))?;

    let mut mesh = Mesh::<N> { points: grid.points, ..Mesh::default() };
    mesh.cells = sorted.cells.iter().map(|&(_, nodes)| nodes).collect();
    mesh.point_fields = grid.point_fields;
    let rows: Vec<usize> = sorted.cells.iter().map(|&(row, _)| row).collect();
    let pick = |(name, field): (&String, &Field)| (name.clone(), field.select(&rows));
    mesh.cell_fields = grid.cell_fields.iter().map(pick).collect();

    let matched = match_facets(&mesh, &sorted.facets);
    let mut report = ReadReport {
        matched_facets: matched.len(),
        unmatched_facets: sorted.facets.len() - matched.len(),
        dropped_cells: sorted.lower.len(),
        ..ReadReport::default()
    };
    name_groups(&mut mesh, &grid.groups, &sorted, &matched);
    if !matched.is_empty() && mesh.facet_sets.is_empty() {
        name_labels(&mut mesh, &grid.cell_fields, &matched);
    }
    name_sides(&mut mesh, &grid.sides, &sorted);
    mesh.node_sets.extend(grid.node_sets);
    sets_from_fields(&mut mesh).map_err(|defect| (cells_at, defect.into()))?;
    report.repaired_cells = repair_orientation(&mut mesh);
    mesh.check_shapes().map_err(|defect| (cells_at, defect.into()))?;
    report.unused_nodes = crate::topology::unused_nodes(&mesh).len();
    Ok((mesh, report))
}

fn check_grid(grid: &UnstructuredGrid) -> Result<(), Fault> {
    let in_points = |defect: Defect| (grid.points_at, Problem::from(defect));
    let in_cells = |defect: Defect| (grid.cells_at, Problem::from(defect));
    check_points(&grid.points).map_err(in_points)?;
    for (name, field) in &grid.point_fields {
        check_field(name, field, grid.points.len()).map_err(in_points)?;
    }
    for (name, field) in &grid.cell_fields {
        check_field(name, field, grid.types.len()).map_err(in_cells)?;
    }
    Ok(())
}

/// The cells of a grid by their part in the mesh, each with its index in the grid, ascending.
struct SortedCells<const N: usize> {
    cells: Vec<(usize, [usize; N])>,
    facets: Vec<(usize, FacetKey)>,
    lower: Vec<(usize, Vec<usize>)>,
}

/// The part of a cell type in a mesh.
enum Part {
    Cell,
    Facet,
    Lower,
}

/// VTK types of lower dimension than the facets, which are left out of a mesh of linear or quadratic
/// cells; of poly-lines and poly-vertices no facets are made.
fn part_of<const N: usize>(kind: u8) -> Option<Part> {
    let element = Mesh::<N>::ELEMENT;
    let is_lower = match (element.dimension, element.is_quadratic()) {
        (2, _) => matches!(kind, 1 | 2 | 4),
        (_, false) => matches!(kind, 1..=4),
        (_, true) => matches!(kind, 1..=4 | vtk_type::QUADRATIC_EDGE),
    };
    match kind {
        _ if kind == element.vtk_type => Some(Part::Cell),
        _ if kind == element.facet_vtk_type => Some(Part::Facet),
        _ => is_lower.then_some(Part::Lower),
    }
}

fn sort_cells<const N: usize>(grid: &UnstructuredGrid) -> Result<SortedCells<N>, Problem> {
    let element = Mesh::<N>::ELEMENT;
    let mut sorted = SortedCells { cells: vec![], facets: vec![], lower: vec![] };
    for (index, &kind) in grid.types.iter().enumerate() {
        let part = part_of::<N>(kind).ok_or_else(|| refused_cell::<N>(index, kind))?;
        check_nodes(grid, index, node_count(kind))?;
        let mut nodes = grid.cell(index).iter().map(|&node| node as usize);
        match part {
            Part::Cell => {
                let cell = std::array::from_fn(|_| nodes.next().unwrap_or(usize::MAX));
                sorted.cells.push((index, cell));
            }
            Part::Facet => {
                sorted.facets.push((index, sorted_key(nodes.take(element.facet_corners))));
            }
            Part::Lower => sorted.lower.push((index, nodes.collect())),
        }
    }
    if sorted.cells.is_empty() {
        return Err(Defect::NoCells { wanted: element.plural }.into());
    }
    Ok(sorted)
}

/// Number of nodes of the cell types that a mesh may have; of some it is any.
fn node_count(kind: u8) -> Option<usize> {
    match kind {
        1 => Some(1),
        3 => Some(2),
        5 | vtk_type::QUADRATIC_EDGE => Some(3),
        9 | 10 => Some(4),
        22 => Some(6),
        12 => Some(8),
        24 => Some(10),
        _ => None,
    }
}

/// Checks the nodes of a cell; one with any number of nodes may name a node again, as a closed
/// line does.
fn check_nodes(grid: &UnstructuredGrid, cell: usize, number: Option<usize>) -> Result<(), Problem> {
    let (nodes, total) = (grid.cell(cell), grid.points.len());
    let Some(expected) = number else {
        return Ok(nodes.chunks(1).try_for_each(|node| check_cell(cell, node, total))?);
    };
    if nodes.len() != expected {
        let what = format!("nodes of cell {cell}, a {}", cell_type_name(grid.types[cell]));
        return Err(Problem::Count { what, expected, found: nodes.len() });
    }
    Ok(check_cell(cell, nodes, total)?)
}

fn refused_cell<const N: usize>(cell: usize, kind: u8) -> Problem {
    let advice = match kind {
        10 if N == 3 => "read the file as a tetrahedral mesh and extract its surface",
        5 | 10 if Mesh::<N>::ELEMENT.is_quadratic() => {
            "read the file as a mesh of linear cells and make it quadratic"
        }
        22 | 24 if !Mesh::<N>::ELEMENT.is_quadratic() => {
            "read the file with `read_mesh` as a mesh of quadratic cells, or export it with linear \
             (first-order) elements"
        }
        21..=29 => "export the mesh with linear (first-order) elements",
        12 if N != 8 => {
            "read a file of hexahedra with `read_mesh` as a HexMesh, or split such cells into \
             simplices, for example with VTK's \"Triangulate\""
        }
        6..=9 | 11..=14 => {
            "split such cells into simplices, for example with VTK's \"Triangulate\""
        }
        _ => "export only the cells of one kind",
    };
    let wanted = Mesh::<N>::ELEMENT.plural;
    Problem::Cell { cell, kind: cell_type_name(kind), wanted, advice }
}

/// The facet of the mesh behind each boundary cell of the grid, where there is one. Between
/// two cells the first one owns it.
fn match_facets<const N: usize>(
    mesh: &Mesh<N>,
    boundary_cells: &[(usize, FacetKey)],
) -> BTreeMap<usize, Facet> {
    if boundary_cells.is_empty() {
        return BTreeMap::new();
    }
    let mut owner = HashMap::with_capacity(mesh.cells.len() * Mesh::<N>::ELEMENT.facets.len());
    for facet in facets(mesh) {
        owner.entry(facet_key(mesh, facet)).or_insert(facet);
    }
    let find = |&(index, key): &(usize, FacetKey)| Some((index, *owner.get(&key)?));
    boundary_cells.iter().filter_map(find).collect()
}

/// Named groups become a set of cells, facets or nodes for each dimension they cover.
fn name_groups<const N: usize>(
    mesh: &mut Mesh<N>,
    groups: &BTreeMap<String, Vec<usize>>,
    sorted: &SortedCells<N>,
    matched: &BTreeMap<usize, Facet>,
) {
    let cell_at = |index: &usize| sorted.cells.binary_search_by_key(index, |cell| cell.0).ok();
    let lower_at = |index: &usize| sorted.lower.binary_search_by_key(index, |cell| cell.0).ok();
    for (name, members) in groups {
        let members: BTreeSet<usize> = members.iter().copied().collect();
        let cells: Vec<usize> = members.iter().filter_map(cell_at).collect();
        let facets = members.iter().filter_map(|index| matched.get(index)).copied().collect();
        let lower = members.iter().filter_map(lower_at);
        let nodes: BTreeSet<usize> = lower.flat_map(|at| &sorted.lower[at].1).copied().collect();
        if !cells.is_empty() {
            mesh.cell_sets.insert(name.clone(), cells);
        }
        insert_facets(mesh, name, facets);
        if !nodes.is_empty() {
            mesh.node_sets.insert(name.clone(), nodes.into_iter().collect());
        }
    }
}

/// Named sides of cells join the facets of that name.
fn name_sides<const N: usize>(
    mesh: &mut Mesh<N>,
    sides: &BTreeMap<String, Vec<(usize, usize)>>,
    sorted: &SortedCells<N>,
) {
    let cell_at = |index: usize| sorted.cells.binary_search_by_key(&index, |cell| cell.0).ok();
    for (name, sides) in sides {
        let mut facets = mesh.facet_sets.remove(name).unwrap_or_default();
        let of = |&(index, opposite)| Some(Facet { cell: cell_at(index)?, opposite });
        facets.extend(sides.iter().filter_map(of));
        insert_facets(mesh, name, facets);
    }
}

/// Facet sets without groups: each value of an integer cell field names the facets that have it, such as
/// `region:1`; without such a field there is one set `facets`.
fn name_labels<const N: usize>(
    mesh: &mut Mesh<N>,
    fields: &BTreeMap<String, Field>,
    matched: &BTreeMap<usize, Facet>,
) {
    for (name, field) in fields {
        let Some(labels) = field.as_labels() else { continue };
        let mut by_label = BTreeMap::<i64, Vec<Facet>>::new();
        for (&index, &facet) in matched {
            by_label.entry(labels[index]).or_default().push(facet);
        }
        if by_label.len() <= MOST_LABELS {
            for (label, facets) in by_label {
                insert_facets(mesh, &format!("{name}:{label}"), facets);
            }
        }
    }
    if mesh.facet_sets.is_empty() {
        insert_facets(mesh, "facets", matched.values().copied().collect());
    }
}

fn insert_facets<const N: usize>(mesh: &mut Mesh<N>, name: &str, mut facets: Vec<Facet>) {
    facets.sort_unstable();
    facets.dedup();
    if !facets.is_empty() {
        mesh.facet_sets.insert(name.into(), facets);
    }
}
