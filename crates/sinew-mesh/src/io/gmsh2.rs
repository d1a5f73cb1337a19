//! Nodes and elements of MSH 2.2.

use super::cursor::Encoding;
use super::gmsh_model::{Gmsh, element_type};
use super::grid::cell_type;
use super::number::NumberType::{F64, I32};
use crate::Problem;

/// Rows of a tag and three coordinates; parametric ones with the dimension and the tag of the node's entity, and its one or
/// two parameters on a curve or surface.
pub(super) fn nodes(gmsh: &mut Gmsh<'_>, parametric: bool) -> Result<(), Problem> {
    let count: usize = gmsh.cursor.parse("the number of nodes")?;
    gmsh.cursor.line();
    gmsh.grid.points_at = gmsh.cursor.here();
    for _ in 0..count {
        let tag = gmsh.cursor.integer(I32, "the tag of a node")?;
        let point = gmsh.cursor.reals(F64, 3, "coordinates")?;
        gmsh.node(tag, [point[0], point[1], point[2]])?;
        if parametric {
            let entity = gmsh.cursor.integers(I32, 2, "dimension and tag of an entity")?;
            let parameters = if let dimension @ 1..=2 = entity[0] { dimension as usize } else { 0 };
            gmsh.cursor.reals(F64, parameters, "parameters of a node")?;
        }
    }
    Ok(())
}

/// Elements with their tags, of which the first is the physical group. An element in several
/// groups is listed once for each.
pub(super) fn elements(gmsh: &mut Gmsh<'_>) -> Result<(), Problem> {
    let count: usize = gmsh.cursor.parse("the number of elements")?;
    gmsh.cursor.line();
    gmsh.grid.cells_at = gmsh.cursor.here();
    gmsh.known.clear();
    let mut read = 0;
    while read < count {
        if gmsh.cursor.encoding == Encoding::Text {
            let element = gmsh.cursor.integer(I32, "the tag of an element")?;
            let kind = gmsh.cursor.integer(I32, "the type of an element")?;
            let tags = gmsh.cursor.count(I32, "the number of tags")?;
            row(gmsh, Some(element), kind, tags)?;
            read += 1;
        } else {
            let kind = gmsh.cursor.integer(I32, "the type of a block of elements")?;
            let block = gmsh.cursor.count(I32, "the number of elements in a block")?.max(1);
            let tags = gmsh.cursor.count(I32, "the number of tags")?;
            for _ in 0..block {
                row(gmsh, None, kind, tags)?;
            }
            read += block;
        }
    }
    Ok(())
}

fn row(gmsh: &mut Gmsh<'_>, tag: Option<i64>, kind: i64, tags: usize) -> Result<(), Problem> {
    let (vtk_type, length) = element_type(kind)?;
    let tag = match tag {
        Some(tag) => tag,
        None => gmsh.cursor.integer(I32, "the tag of an element")?,
    };
    let tags = gmsh.cursor.integers(I32, tags, "tags of an element")?;
    let nodes = gmsh.cursor.integers(I32, length, "nodes of an element")?;
    let index = match gmsh.known.get(&(vtk_type, nodes.clone())) {
        Some(&index) => index,
        None => gmsh.element(vtk_type, &nodes)?,
    };
    gmsh.known.insert((vtk_type, nodes), index);
    gmsh.element_index.insert(tag, index);
    if let Some(&physical) = tags.first().filter(|&&physical| physical != 0) {
        gmsh.join_group(cell_type(vtk_type).1, physical, index);
    }
    Ok(())
}
