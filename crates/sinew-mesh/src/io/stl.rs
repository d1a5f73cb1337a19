//! STL files: triangles without a common list of points, as text or binary (3D Systems, "StereoLithography Interface
//! Specification", 1989; binary files are little endian).

use super::cursor::{Cursor, Fault, Result, text_of, without_mark};
use super::grid::MixedMesh;
use crate::{Place, Refusal};
use std::collections::HashMap;

/// Offsets of a binary file's number of triangles and of the first one, and the bytes of each.
const COUNT: usize = 80;
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// The number of triangles that a file declares if it is binary.
fn declared(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(COUNT..HEAD)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// Whether the file is binary STL of the length that it declares.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    let length = declared(bytes).and_then(|count| count.checked_mul(TRIANGLE)?.checked_add(HEAD));
    length == Some(bytes.len())
}

/// Whether the file is STL as text: a solid with facets.
pub(crate) fn is_text(content: &[u8]) -> bool {
    let starts = content.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    starts && content.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet"))
}

/// Reads the triangles; corners at the same place become one point, and triangles that have two such corners are left
/// out and counted.
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let mut triangles = Triangles::default();
    if is_text(without_mark(bytes).trim_ascii_start()) && !is_binary(bytes) {
        let mut cursor = Cursor::new(bytes);
        text(&mut cursor, &mut triangles).map_err(|problem| cursor.fault(problem))?;
    } else {
        let place = Place { byte: COUNT, line: None };
        binary(bytes, &mut triangles).map_err(|problem| (place, problem))?;
    }
    Ok(triangles.grid)
}

fn binary(bytes: &[u8], triangles: &mut Triangles) -> Result<()> {
    let count = declared(bytes).unwrap_or(0);
    let body = bytes.get(HEAD..).unwrap_or_default();
    Refusal::require_bytes("triangles", count as u128 * TRIANGLE as u128, body.len())?;
    triangles.grid.points_at.byte = HEAD;
    triangles.grid.cells_at.byte = HEAD;
    for triangle in body.chunks_exact(TRIANGLE).take(count) {
        // Behind the normal, which follows from the corners.
        let mut numbers = triangle[12..48].as_chunks().0.iter();
        let mut number = || numbers.next().map_or(0.0, |&bytes| f32::from_le_bytes(bytes).into());
        let corners = std::array::from_fn(|_| std::array::from_fn(|_| number()));
        triangles.push(corners);
    }
    Ok(())
}

fn text(cursor: &mut Cursor<'_>, triangles: &mut Triangles) -> Result<()> {
    let (mut solids, mut name) = (0, String::new());
    triangles.grid.points_at = cursor.here();
    triangles.grid.cells_at = cursor.here();
    while let Some(word) = cursor.word() {
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => {
                name = text_of(cursor.line().unwrap_or_default());
                solids += 1;
            }
            b"facet" => {
                // Normals are written as they come, not always as numbers.
                cursor.line();
                cursor.keyword("outer")?;
                cursor.keyword("loop")?;
                let mut corners = [[0.0; 3]; 3];
                for corner in &mut corners {
                    cursor.keyword("vertex")?;
                    for x in corner {
                        *x = cursor.parse("a coordinate")?;
                    }
                }
                cursor.keyword("endloop")?;
                cursor.keyword("endfacet")?;
                triangles.push(corners);
                if !name.is_empty() {
                    let index = triangles.grid.types.len() - 1;
                    triangles.grid.groups.entry(name.clone()).or_default().push(index);
                }
            }
            b"endsolid" => drop(cursor.line()),
            _ => return Err(Refusal::expected("facet or endsolid", word)),
        }
    }
    // The name of the only one names nothing.
    if solids == 1 {
        triangles.grid.groups.clear();
    }
    Ok(())
}

#[derive(Default)]
struct Triangles {
    grid: MixedMesh,
    by_place: HashMap<[u64; 3], i64>,
}

impl Triangles {
    fn push(&mut self, corners: [[f64; 3]; 3]) {
        let nodes = corners.map(|corner| {
            // Adding zero makes one of both zeros.
            let key = corner.map(|x| (x + 0.0).to_bits());
            *self.by_place.entry(key).or_insert_with(|| {
                self.grid.points.push(corner);
                self.grid.points.len() as i64 - 1
            })
        });
        let [a, b, c] = nodes;
        // A collapsed triangle counts as a group of points, which a mesh leaves out.
        self.grid.push(if a == b || b == c || c == a { 2 } else { 5 }, &nodes);
    }
}
