//! CARP meshes, those of openCARP: text files of one name for points (`.pts`, in µm), elements (`.elem`) and fibres (`.lon`), with
//! surfaces (`.surf`) and vertices (`.vtx`) beside them (openCARP user manual, "File formats").

use super::cursor::{Cursor, Result, load, number};
use super::grid::{MixedMesh as Grid, cell_type};
use super::number::NumberType::{F64, I64};
use crate::{Field, MeshError, Place, Refusal};
use sinew_num::ascending;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Cell fields of the directions of a `.lon` file, in their order.
const DIRECTIONS: [&str; 2] = ["fibre", "sheet"];

/// Cell field of the labels.
const REGION: &str = "region";

/// Words of the elements with VTK's types of these.
const WORDS: [(&str, u8); 6] = [("Tt", 10), ("Hx", 12), ("Tr", 5), ("Qd", 9), ("Ln", 3), ("Cx", 3)];

/// Micrometres, in which the files are, in a millimetre.
const PER_MM: f64 = 1e3;

/// The path of a mesh without ending: that of its points, elements or fibres, or given so.
pub(super) fn stem(path: &Path) -> Option<PathBuf> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("pts" | "elem" | "lon") => Some(path.with_extension("")),
        _ => (!path.is_file() && with(path, "pts").is_file()).then(|| path.into()),
    }
}

/// The path of one of the files of a mesh.
fn with(stem: &Path, ending: &str) -> PathBuf {
    PathBuf::from([stem.as_os_str(), ending.as_ref()].join(".".as_ref()))
}

/// Reads all files of a mesh; the name is that of the elements, for errors about them.
pub(super) fn read(stem: &Path) -> Result<(String, Grid), MeshError> {
    let mut grid = Grid { in_micrometres: true, ..Grid::default() };
    grid.cells_at = Place { byte: 0, line: Some(1) };
    in_file(&with(stem, "pts"), |cursor| {
        for _ in 0..cursor.count(I64, "the number of points")? {
            grid.points.push(vector(cursor, "three finite coordinates")?.map(|x| x / PER_MM));
        }
        Ok(())
    })?;
    let (elements, mut labels) = (with(stem, "elem"), Vec::new());
    in_file(&elements, |cursor| {
        for _ in 0..cursor.count(I64, "the number of elements")? {
            let label = element(cursor, &mut grid)?;
            let label = (!label.is_empty()).then(|| number(label, "the integer label of a region"));
            labels.push(label.transpose()?.unwrap_or(0));
        }
        Ok(())
    })?;
    let (fibres, mut columns) = (with(stem, "lon"), [Vec::new(), Vec::new()]);
    if fibres.is_file() {
        in_file(&fibres, |cursor| {
            let axes = cursor.count(I64, "the number of directions per element")?;
            let (known, found) = ((1..=columns.len()).contains(&axes), axes.to_string());
            Refusal::require(known, "1 or 2 directions per element", found)?;
            for at in 0..axes * labels.len() {
                columns[at % axes].push(vector(cursor, "three finite components per element")?);
            }
            Ok(())
        })?;
        let none = columns[0].iter().filter(|row| **row == [0.0; 3]).count();
        if none > 0 {
            let what = format!("fibres of {none} of {} elements, which are zero,", labels.len());
            grid.left_out.push(what);
        }
    }
    let dimensions: Vec<i64> = grid.types.iter().map(|&kind| cell_type(kind).1).collect();
    let top = dimensions.iter().copied().max();
    for (index, label) in labels.iter().enumerate().filter(|(i, _)| Some(dimensions[*i]) < top) {
        grid.groups.entry(format!("{REGION}:{label}")).or_default().push(index);
    }
    for (path, name) in beside(stem, ".surf").into_iter().filter(|_| top == Some(3)) {
        let first = grid.types.len();
        in_file(&path, |cursor| {
            for _ in 0..cursor.count(I64, "the number of elements of the surface")? {
                element(cursor, &mut grid)?;
                let is_facet = matches!(grid.types.last(), Some(5 | 9));
                Refusal::require(is_facet, "a Tr or Qd of the surface", "another element")?;
            }
            Ok(())
        })?;
        grid.groups.entry(name).or_default().extend(first..grid.types.len());
    }
    for (path, name) in beside(stem, ".vtx") {
        let nodes = in_file(&path, |cursor| {
            let count = cursor.count(I64, "the number of vertices")?;
            cursor.text("`intra` or `extra`")?;
            nodes(cursor, count, grid.points.len())
        })?;
        grid.node_sets.insert(name, ascending(nodes.into_iter().map(|node| node as usize)));
    }
    // Elements of surfaces have neither label nor direction.
    let cells = grid.types.len();
    if labels.iter().any(|&label| label != 0) {
        labels.resize(cells, 0);
        grid.cell_fields.insert(REGION.into(), Field::labels(labels));
    }
    for (name, mut column) in DIRECTIONS.iter().zip(columns).filter(|(_, rows)| !rows.is_empty()) {
        column.resize(cells, [0.0; 3]);
        grid.cell_fields.insert((*name).into(), Field::vectors(&column));
    }
    Ok((elements.display().to_string(), grid))
}

/// Files with an ending in the mesh's folder, each with the name of its set: `base` of `heart.base.surf` and, where no other mesh is
/// there, of `base.surf`.
fn beside(stem: &Path, ending: &str) -> Vec<(PathBuf, String)> {
    let folder = stem.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names: BTreeSet<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    let stems: Vec<&str> = names.iter().filter_map(|name| name.strip_suffix(".pts")).collect();
    let is_only = stems.len() == 1;
    let mesh = stem.file_name().unwrap_or_default().to_string_lossy();
    // Files of `heart.lv` are not those of `heart`.
    let is_of_another = |name: &str| {
        let of = |other: &&str| other.len() > mesh.len() && name.starts_with(&format!("{other}."));
        stems.iter().any(of)
    };
    let set_of = |name: &String| {
        let set = name.strip_suffix(ending).filter(|_| !is_of_another(name))?;
        let set = set.strip_suffix(".surf").unwrap_or(set);
        let rest = set.strip_prefix(&*mesh).and_then(|rest| rest.strip_prefix('.'));
        let set = rest.or((is_only || set == mesh).then_some(set))?;
        Some((folder.join(name), set.to_string()))
    };
    names.iter().filter_map(set_of).collect()
}

/// Reads a file to its end.
fn in_file<T>(
    path: &Path,
    read: impl FnOnce(&mut Cursor<'_>) -> Result<T>,
) -> Result<T, MeshError> {
    let (name, bytes) = load(path)?;
    let mut cursor = Cursor::new(&bytes);
    let content = read(&mut cursor).and_then(|content| match cursor.word() {
        Some(more) => Err(Refusal::expected("no more rows than the first line says", more)),
        None => Ok(content),
    });
    content.map_err(|problem| MeshError::in_file(&name, cursor.fault(problem)))
}

fn vector(cursor: &mut Cursor<'_>, what: &'static str) -> Result<[f64; 3]> {
    let row = cursor.reals(F64, 3, what)?;
    let is_finite = row.iter().all(|x| x.is_finite());
    let problem = || Refusal::expected(what, format!("{row:?}"));
    is_finite.then(|| [row[0], row[1], row[2]]).ok_or_else(problem)
}

/// Indices of nodes that there are.
fn nodes(cursor: &mut Cursor<'_>, count: usize, of: usize) -> Result<Vec<i64>> {
    let (nodes, most) = (cursor.integers(I64, count, "a node")?, of as i64 - 1);
    nodes.iter().try_for_each(|&node| Refusal::require_within("a node", node, [0, most]))?;
    Ok(nodes)
}

/// Adds an element by the word of its type and its nodes, and returns the word behind them on the line, if any.
fn element<'a>(cursor: &mut Cursor<'a>, grid: &mut Grid) -> Result<&'a [u8]> {
    let word = cursor.text("an element")?;
    let found = WORDS.iter().find(|(known, _)| *known == word);
    let advice = "give Tt, Hx, Tr, Qd or Ln with its nodes; split others into tetrahedra";
    let unknown = || Refusal::unsupported("the element type", word, advice);
    let kind = found.ok_or_else(unknown)?.1;
    let mut nodes = nodes(cursor, cell_type(kind).2.unwrap_or(0), grid.points.len())?;
    if kind == 12 {
        // CARP goes round the upper side the other way.
        nodes.swap(5, 7);
    }
    grid.push(kind, &nodes);
    let rest = cursor.line().unwrap_or_default();
    Ok(rest.split(u8::is_ascii_whitespace).next().unwrap_or_default())
}
