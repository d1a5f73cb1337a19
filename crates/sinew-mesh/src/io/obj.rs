//! Wavefront OBJ files: `v` points and `f` faces, whose corners may name texture and normal as well (Wavefront
//! Technologies, "Object Files (.obj)", Appendix B1 of the Advanced Visualizer Manual).

use super::cursor::{Cursor, Fault, Result, number};
use super::grid::MixedMesh;
use super::polydata::{Kind, add};
use crate::Problem;

/// First words of lines that an OBJ file may begin with, and no other format does.
const FIRST: [&[u8]; 11] =
    [b"v", b"vn", b"vt", b"vp", b"f", b"o", b"g", b"s", b"l", b"mtllib", b"usemtl"];

/// Whether the first line that is not a comment looks like one of an OBJ file.
pub(crate) fn looks_like_it(content: &[u8]) -> bool {
    let words = content.split(|&byte| byte == b'\n').map(|line| line.trim_ascii());
    let first = words.filter(|line| !line.is_empty() && !line.starts_with(b"#")).take(1).next();
    let word = first.and_then(|line| line.split(u8::is_ascii_whitespace).next());
    word.is_some_and(|word| FIRST.contains(&word))
}

/// Reads points, faces (as fans of triangles), lines and the names of groups.
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let mut cursor = Cursor::new(bytes);
    read(&mut cursor).map_err(|problem| cursor.fault(problem))
}

fn read(cursor: &mut Cursor<'_>) -> Result<MixedMesh> {
    let mut grid = MixedMesh::default();
    let mut group = String::new();
    (grid.points_at, grid.cells_at) = (cursor.here(), cursor.here());
    while let Some(line) = cursor.line() {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let kind = match words.next() {
            Some(b"v") => {
                let mut point = [0.0; 3];
                for x in &mut point {
                    let expected = "a coordinate";
                    *x = number(words.next().ok_or(Problem::Missing { expected })?, expected)?;
                }
                grid.points.push(point);
                continue;
            }
            Some(b"g" | b"o") => {
                let name: Vec<_> = words.map(String::from_utf8_lossy).collect();
                group = name.join(" ");
                continue;
            }
            Some(b"f") => Kind::Polygons,
            Some(b"l") => Kind::Lines,
            Some(b"p") => Kind::Vertices,
            // Normals, textures, materials and curved surfaces, which have no part in a mesh of triangles.
            _ => continue,
        };
        let nodes = words.map(|word| corner(word, grid.points.len()));
        let nodes = nodes.collect::<Result<Vec<i64>, _>>()?;
        let first = grid.types.len();
        add(&mut grid, kind, &nodes);
        if !group.is_empty() {
            let added = first..grid.types.len();
            grid.groups.entry(group.clone()).or_default().extend(added);
        }
    }
    Ok(grid)
}

/// The point that a corner such as `7`, `7/1`, `7//2` or `-1/-1/-1` names, from 0; negative ones count from the last.
fn corner(word: &[u8], points: usize) -> Result<i64> {
    let point = word.split(|&byte| byte == b'/').next().unwrap_or_default();
    let value: i64 = number(point, "the number of a point")?;
    let count = points as i64;
    match value {
        1.. => Ok(value - 1),
        _ if value < 0 && value >= -count => Ok(count + value),
        _ => {
            let what = "the number of a point (they count from 1, or back from -1)";
            Err(Problem::Range { what, value, least: -count, most: count })
        }
    }
}
