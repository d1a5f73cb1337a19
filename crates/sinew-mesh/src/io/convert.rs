//! From the cells of a file to a simplex mesh.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::grid::{UnstructuredGrid, cell_type_name, low_dimension, vtk_type};
use super::sets::sets_from_fields;
use crate::check::{check_cell, check_field, check_points};
use crate::topology::{facet_key, facets};
use crate::{Defect, Facet, Field, MeshError, Place, Problem, SimplexMesh, repair_orientation};

/// An integer cell field with more values than this on the facets of a file is taken for
/// numbering rather than for names of facet sets.
const MOST_LABELS: usize = 64;

/// What a reader did to make a mesh out of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadReport {
    /// Cells whose negative orientation was repaired by [`repair_orientation`].
    pub repaired_cells: usize,
    /// Cells of the boundary (triangles of a tetrahedral mesh, lines of a triangle mesh) that
    /// became members of facet sets.
    pub matched_facets: usize,
    /// Cells of the boundary's dimension that are no facet of any cell, and were left out.
    pub unmatched_facets: usize,
    /// Cells of still lower dimension (vertices, lines of a tetrahedral mesh), left out.
    pub dropped_cells: usize,
    /// Nodes that belong to no cell. They are kept; see [`crate::remove_unused_nodes`].
    pub unused_nodes: usize,
}

/// Where and why a grid is no mesh.
type Fault = (Place, Problem);

/// Makes a mesh of the cells with `V` vertices.
pub(crate) fn to_mesh<const V: usize>(
    file: &str,
    grid: UnstructuredGrid,
) -> Result<(SimplexMesh<V>, ReadReport), MeshError> {
    convert(grid).map_err(|(place, problem)| MeshError::Content {
        file: file.into(),
        place,
        problem: Box::new(problem),
    })
}

fn convert<const V: usize>(grid: UnstructuredGrid) -> Result<(SimplexMesh<V>, ReadReport), Fault> {
    let cells_at = grid.cells_at;
    check_grid(&grid)?;
    let sorted = sort_cells::<V>(&grid).map_err(|problem| (cells_at, problem))?;

    let mut mesh = SimplexMesh::<V> { points: grid.points, ..SimplexMesh::default() };
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
    sets_from_fields(&mut mesh).map_err(|defect| (cells_at, defect.into()))?;
    report.repaired_cells = repair_orientation(&mut mesh);
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
struct SortedCells<const V: usize> {
    cells: Vec<(usize, [usize; V])>,
    /// Facets, with sorted nodes and a filler as in [`facet_key`].
    facets: Vec<(usize, [usize; V])>,
    lower: Vec<(usize, Vec<usize>)>,
}

fn sort_cells<const V: usize>(grid: &UnstructuredGrid) -> Result<SortedCells<V>, Problem> {
    let mut sorted = SortedCells { cells: vec![], facets: vec![], lower: vec![] };
    for (index, &kind) in grid.types.iter().enumerate() {
        let dimension = if kind == mesh_type(V) {
            V - 1
        } else {
            let lower = low_dimension(kind).filter(|&dimension| dimension + 1 < V);
            lower.ok_or_else(|| refused_cell(index, kind, V))?
        };
        let poly = matches!(kind, 2 | 4);
        check_nodes(grid, index, (!poly).then_some(dimension + 1))?;
        let nodes = grid.cell(index).iter().map(|&node| node as usize);
        let mut simplex = [usize::MAX; V];
        simplex.iter_mut().zip(nodes.clone()).for_each(|(slot, node)| *slot = node);
        if dimension + 1 == V {
            sorted.cells.push((index, simplex));
        } else if dimension + 2 == V && !poly {
            simplex.sort_unstable();
            sorted.facets.push((index, simplex));
        } else {
            sorted.lower.push((index, nodes.collect()));
        }
    }
    if sorted.cells.is_empty() {
        return Err(Defect::NoCells { wanted: wanted_name(V) }.into());
    }
    Ok(sorted)
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

/// VTK type of the cells of a mesh.
pub(crate) fn mesh_type(vertices: usize) -> u8 {
    if vertices == 4 { vtk_type::TETRAHEDRON } else { vtk_type::TRIANGLE }
}

fn wanted_name(vertices: usize) -> &'static str {
    if vertices == 4 { "tetrahedra" } else { "triangles" }
}

fn refused_cell(cell: usize, kind: u8, vertices: usize) -> Problem {
    let advice = match kind {
        10 => "read the file as a tetrahedral mesh and extract its surface",
        21..=29 => "export the mesh with linear (first-order) elements",
        6..=9 | 11..=14 => {
            "split such cells into simplices, for example with VTK's \"Triangulate\""
        }
        _ => "export only the simplices of the mesh",
    };
    let wanted = wanted_name(vertices);
    Problem::Cell { cell, kind: cell_type_name(kind), wanted, advice }
}

/// The facet of the mesh behind each boundary cell of the grid, where there is one. Between
/// two cells the first one owns it.
fn match_facets<const V: usize>(
    mesh: &SimplexMesh<V>,
    boundary_cells: &[(usize, [usize; V])],
) -> BTreeMap<usize, Facet> {
    if boundary_cells.is_empty() {
        return BTreeMap::new();
    }
    let mut owner = HashMap::with_capacity(mesh.cells.len() * V);
    for facet in facets(mesh) {
        owner.entry(facet_key(mesh, facet)).or_insert(facet);
    }
    let find = |&(index, key): &(usize, [usize; V])| Some((index, *owner.get(&key)?));
    boundary_cells.iter().filter_map(find).collect()
}

/// Named groups become a set of cells, facets or nodes for each dimension they cover.
fn name_groups<const V: usize>(
    mesh: &mut SimplexMesh<V>,
    groups: &BTreeMap<String, Vec<usize>>,
    sorted: &SortedCells<V>,
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

/// Where no group names facets, each value of an integer cell field names the facets that have it, such as
/// `region:1`; without such a field there is one set `facets`.
fn name_labels<const V: usize>(
    mesh: &mut SimplexMesh<V>,
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

fn insert_facets<const V: usize>(mesh: &mut SimplexMesh<V>, name: &str, mut facets: Vec<Facet>) {
    facets.sort_unstable();
    facets.dedup();
    if !facets.is_empty() {
        mesh.facet_sets.insert(name.into(), facets);
    }
}
