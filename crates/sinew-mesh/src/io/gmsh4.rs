//! Entities, nodes and elements of MSH 4.1. Text and binary files have the same numbers in
//! the same order.

use super::gmsh_model::{Gmsh, element_type};
use super::number::NumberType::{F64, I32, U64};
use crate::Problem;

/// Physical groups of one entity beyond which the file is taken for damaged: each element of
/// the entity joins them all, so this bounds memory by a multiple of the file's size.
const MOST_GROUPS: i64 = 64;

/// The points, curves, surfaces and volumes of the model with their physical groups; of a mesh in partitions those of each
/// part.
pub(super) fn entities(gmsh: &mut Gmsh<'_>, partitioned: bool) -> Result<(), Problem> {
    if partitioned {
        gmsh.cursor.count(U64, "the number of partitions")?;
        let ghosts = gmsh.cursor.count(U64, "the number of ghost entities")?;
        gmsh.cursor.integers(I32, ghosts.saturating_mul(2), "ghost entities")?;
    }
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = gmsh.cursor.count(U64, "the number of entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = gmsh.cursor.integer(I32, "the tag of an entity")?;
            if partitioned {
                gmsh.cursor.integers(I32, 2, "the entity that was divided")?;
                let parts = gmsh.cursor.count(U64, "the number of partitions")?;
                gmsh.cursor.integers(I32, parts, "tags of partitions")?;
            }
            // A point's position, or the corners of a bounding box.
            let numbers = if dimension == 0 { 3 } else { 6 };
            gmsh.cursor.reals(F64, numbers, "the extent of an entity")?;
            let groups = gmsh.cursor.count(U64, "the number of physical groups")?;
            let what = "the number of physical groups of an entity";
            Problem::require_within(what, groups as i64, 0..=MOST_GROUPS)?;
            let groups = gmsh.cursor.integers(I32, groups, "tags of physical groups")?;
            if dimension > 0 {
                let bounding = gmsh.cursor.count(U64, "the number of bounding entities")?;
                gmsh.cursor.integers(I32, bounding, "tags of bounding entities")?;
            }
            gmsh.physicals.insert((dimension as i64, tag), groups);
        }
    }
    Ok(())
}

/// Blocks of nodes: tags first, then coordinates.
pub(super) fn nodes(gmsh: &mut Gmsh<'_>) -> Result<(), Problem> {
    let blocks = block_count(gmsh)?;
    gmsh.grid.points_at = gmsh.cursor.here();
    for _ in 0..blocks {
        let dimension = gmsh.cursor.count(I32, "the dimension of an entity")?.min(3);
        gmsh.cursor.integer(I32, "the tag of an entity")?;
        let parametric = gmsh.cursor.integer(I32, "whether nodes are parametric")? != 0;
        let count = gmsh.cursor.count(U64, "the number of nodes in a block")?;
        let tags = gmsh.cursor.integers(U64, count, "tags of nodes")?;
        let width = if parametric { 3 + dimension } else { 3 };
        let numbers = gmsh.cursor.reals(F64, count.saturating_mul(width), "coordinates")?;
        for (&tag, row) in tags.iter().zip(numbers.chunks_exact(width)) {
            gmsh.node(tag, [row[0], row[1], row[2]])?;
        }
    }
    Ok(())
}

/// Blocks of elements of one type on one entity.
pub(super) fn elements(gmsh: &mut Gmsh<'_>) -> Result<(), Problem> {
    let blocks = block_count(gmsh)?;
    gmsh.grid.cells_at = gmsh.cursor.here();
    for _ in 0..blocks {
        let dimension = gmsh.cursor.integer(I32, "the dimension of an entity")?;
        let entity = gmsh.cursor.integer(I32, "the tag of an entity")?;
        let kind = gmsh.cursor.integer(I32, "the type of elements")?;
        let (vtk_type, length) = element_type(kind)?;
        let count = gmsh.cursor.count(U64, "the number of elements in a block")?;
        let numbers = count.saturating_mul(1 + length);
        let rows = gmsh.cursor.integers(U64, numbers, "elements")?;
        let groups = gmsh.physicals.get(&(dimension, entity)).cloned().unwrap_or_default();
        for row in rows.chunks_exact(1 + length) {
            let index = gmsh.element(vtk_type, &row[1..])?;
            gmsh.element_index.insert(row[0], index);
            for &physical in &groups {
                gmsh.join_group(dimension, physical, index);
            }
        }
    }
    Ok(())
}

/// The number of blocks; the totals behind it follow from the blocks.
fn block_count(gmsh: &mut Gmsh<'_>) -> Result<usize, Problem> {
    let blocks = gmsh.cursor.count(U64, "the number of blocks")?;
    for what in ["the total count", "the smallest tag", "the largest tag"] {
        gmsh.cursor.count(U64, what)?;
    }
    Ok(blocks)
}
