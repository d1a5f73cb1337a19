//! CARP meshes, those of openCARP: text files of one name for points (`.pts`, in µm), elements (`.elem`) and fibres (`.lon`), with
//! surfaces (`.surf`) and vertices (`.vtx`) beside them (openCARP user manual, "File formats").

use super::cursor::{Cursor, number};
use super::grid::{UnstructuredGrid, cell_type};
use crate::{Field, MeshError, Problem};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Elements that are read: word, VTK type, number of nodes.
pub(super) const ELEMENTS: [(&str, u8, usize); 8] = [
    ("Tt", 10, 4),
    ("Hx", 12, 8),
    ("Tr", 5, 3),
    ("Qd", 9, 4),
    ("Ln", 3, 2),
    ("Cx", 3, 2),
    ("Pr", 13, 6),
    ("Py", 14, 5),
];

/// Cell fields of the directions of a `.lon` file, in their order.
pub(super) const DIRECTIONS: [&str; 2] = ["fibre", "sheet"];

/// Cell field of the labels.
pub(super) const REGION: &str = "region";

/// Micrometres, in which the files are, in a millimetre.
pub(super) const PER_MM: f64 = 1e3;

type Words<'w, 'a> = &'w mut dyn Iterator<Item = &'a [u8]>;

/// The path of a mesh without ending: that of its points, elements or fibres, or given so.
pub(super) fn stem(path: &Path) -> Option<PathBuf> {
    let is_there = |ending: &&str| with(path, ending).is_file();
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("pts" | "elem" | "lon") => Some(path.with_extension("")),
        _ => (!path.is_file() && ["pts", "elem"].iter().any(is_there)).then(|| path.into()),
    }
}

/// The path of one of the files of a mesh.
pub(super) fn with(stem: &Path, ending: &str) -> PathBuf {
    let mut path = stem.as_os_str().to_owned();
    path.push(format!(".{ending}"));
    path.into()
}

/// Reads all files of a mesh; the name is that of the elements, for errors about them.
pub(super) fn read(stem: &Path) -> Result<(String, UnstructuredGrid), MeshError> {
    let mut grid = UnstructuredGrid { in_micrometres: true, ..UnstructuredGrid::default() };
    let [elements, fibres] = ["elem", "lon"].map(|ending| with(stem, ending));
    in_file(&with(stem, "pts"), |cursor| self::points(cursor, &mut grid))?;
    in_file(&elements, |cursor| self::elements(cursor, &mut grid))?;
    if fibres.is_file() {
        in_file(&fibres, |cursor| self::fibres(cursor, &mut grid))?;
    }
    let is_solid = grid.types.iter().any(|&kind| cell_type(kind).1 == 3);
    for (path, name) in beside(stem, ".surf", &mut grid.left_out).into_iter().filter(|_| is_solid) {
        in_file(&path, |cursor| surfaces(cursor, &name, &mut grid))?;
    }
    for (path, name) in beside(stem, ".vtx", &mut grid.left_out) {
        in_file(&path, |cursor| vertices(cursor, &name, &mut grid))?;
    }
    // Elements of surfaces have neither label nor direction.
    let cells = grid.types.len();
    grid.cell_fields.values_mut().for_each(|field| field.resize(cells));
    Ok((elements.display().to_string(), grid))
}

fn in_file(
    path: &Path,
    read: impl FnOnce(&mut Cursor<'_>) -> Result<(), Problem>,
) -> Result<(), MeshError> {
    let (name, bytes) = super::load(path)?;
    let mut cursor = Cursor::new(&bytes);
    read(&mut cursor).map_err(|problem| MeshError::in_file(&name, cursor.fault(problem)))
}

/// Files with an ending in the mesh's folder, each with the name of its set: `base` of `base.surf` and of `heart.base.surf`.
/// Among several meshes a file belongs to the one whose name it begins with.
fn beside(stem: &Path, ending: &str, left_out: &mut Vec<String>) -> Vec<(PathBuf, String)> {
    let folder = stem.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    let meshes: Vec<&str> = names.iter().filter_map(|name| name.strip_suffix(".pts")).collect();
    let own = stem.file_name().unwrap_or_default().to_string_lossy();
    let mut found = Vec::new();
    for name in &names {
        let Some(set) = name.strip_suffix(ending) else { continue };
        let begins = |mesh: &&str| {
            let rest = name.strip_prefix(*mesh);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        let owner = meshes.iter().copied().filter(begins).max_by_key(|mesh| mesh.len());
        match owner {
            None if meshes.len() > 1 => left_out.push(format!(
                "{name}, which may be of another mesh of the folder (else call it {own}.{name}),"
            )),
            Some(mesh) if mesh != own => {}
            _ => {
                let set = set.strip_suffix(".surf").unwrap_or(set);
                let rest = set.strip_prefix(&*own).and_then(|rest| rest.strip_prefix('.'));
                found.push((folder.join(name), rest.unwrap_or(set).to_string()));
            }
        }
    }
    found
}

/// The words of the next line that is neither blank nor a comment.
fn words<'a>(cursor: &mut Cursor<'a>) -> Option<impl Iterator<Item = &'a [u8]> + use<'a>> {
    loop {
        let line = cursor.line()?;
        if !matches!(line.first(), None | Some(b'#')) {
            return Some(line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()));
        }
    }
}

/// The number on the first line.
fn header(cursor: &mut Cursor<'_>, expected: &'static str) -> Result<usize, Problem> {
    next(&mut words(cursor).ok_or(Problem::Missing { expected })?, expected)
}

fn next<T: FromStr>(words: Words<'_, '_>, expected: &'static str) -> Result<T, Problem> {
    number(words.next().ok_or(Problem::Missing { expected })?, expected)
}

/// Three finite numbers.
fn vector(words: Words<'_, '_>, expected: &'static str) -> Result<[f64; 3], Problem> {
    let mut row = [0.0f64; 3];
    for x in &mut row {
        let word = words.next().ok_or(Problem::Missing { expected })?;
        *x = number(word, expected)?;
        if !x.is_finite() {
            return Err(Problem::expected(expected, word));
        }
    }
    Ok(row)
}

/// The index of one of so many nodes.
fn node(word: &[u8], nodes: usize) -> Result<i64, Problem> {
    let value = number(word, "the index of a node, from 0")?;
    let most = nodes as i64 - 1;
    let in_range = (0..=most).contains(&value);
    in_range.then_some(value).ok_or(Problem::Range { what: "a node", value, least: 0, most })
}

/// Reads the lines up to the end, of which there must be as many as declared.
fn rows(
    cursor: &mut Cursor<'_>,
    what: &str,
    expected: usize,
    mut row: impl FnMut(Words<'_, '_>) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let mut found = 0;
    while let Some(mut words) = words(cursor) {
        row(&mut words)?;
        found += 1;
    }
    let what = what.to_string();
    if found == expected { Ok(()) } else { Err(Problem::Count { what, expected, found }) }
}

fn points(cursor: &mut Cursor<'_>, grid: &mut UnstructuredGrid) -> Result<(), Problem> {
    let count = header(cursor, "the number of points")?;
    rows(cursor, "points", count, |words| {
        grid.points.push(vector(words, "a coordinate in µm")?.map(|x| x / PER_MM));
        Ok(())
    })
}

/// A word for the type, the nodes, and the label of a region, if any.
fn elements(cursor: &mut Cursor<'_>, grid: &mut UnstructuredGrid) -> Result<(), Problem> {
    let count = header(cursor, "the number of elements")?;
    grid.cells_at = cursor.here();
    let mut labels: Vec<Option<i64>> = Vec::new();
    rows(cursor, "elements", count, |words| {
        element(words, grid)?;
        let label = words.next().map(|word| number(word, "the integer label of a region"));
        labels.push(label.transpose()?);
        Ok(())
    })?;
    if labels.iter().all(Option::is_none) {
        return Ok(());
    }
    let labels: Vec<i64> = labels.into_iter().map(Option::unwrap_or_default).collect();
    let top = grid.types.iter().map(|&kind| cell_type(kind).1).max();
    for (index, (&kind, label)) in grid.types.iter().zip(&labels).enumerate() {
        if Some(cell_type(kind).1) < top {
            grid.groups.entry(format!("{REGION}:{label}")).or_default().push(index);
        }
    }
    grid.cell_fields.insert(REGION.into(), Field::labels(labels));
    Ok(())
}

/// Adds an element of a line, and returns its dimension.
fn element(words: Words<'_, '_>, grid: &mut UnstructuredGrid) -> Result<i64, Problem> {
    let expected = "an element: its type and nodes";
    let word = words.next().ok_or(Problem::Missing { expected })?;
    let Some(&(_, kind, count)) = ELEMENTS.iter().find(|(name, ..)| name.as_bytes() == word) else {
        let (what, value) = ("the element type", String::from_utf8_lossy(word).into_owned());
        let advice = "write elements of CARP as Tt, Hx, Tr, Qd or Ln with their nodes";
        return Err(Problem::Unsupported { what, value, advice });
    };
    let mut nodes = [0; 8];
    for slot in &mut nodes[..count] {
        let word = words.next().ok_or(Problem::Missing { expected: "a node of the element" })?;
        *slot = node(word, grid.points.len())?;
    }
    if kind == 12 {
        // CARP goes round the upper side the other way.
        nodes.swap(5, 7);
    }
    grid.push(kind, &nodes[..count]);
    Ok(cell_type(kind).1)
}

/// The number of directions, then one or two for each element; older files begin with the directions.
fn fibres(cursor: &mut Cursor<'_>, grid: &mut UnstructuredGrid) -> Result<(), Problem> {
    let what = "the number of directions per element";
    let start = cursor.position();
    let columns = words(cursor).map(Iterator::count);
    cursor.rewind(start);
    let axes = match columns {
        Some(columns @ (3 | 6)) => columns / 3,
        _ => header(cursor, what)?,
    };
    if !(1..=DIRECTIONS.len()).contains(&axes) {
        let value = axes.try_into().unwrap_or(i64::MAX);
        return Err(Problem::Range { what, value, least: 1, most: DIRECTIONS.len() as i64 });
    }
    let mut columns = vec![Vec::new(); axes];
    rows(cursor, "rows of directions", grid.types.len(), |words| {
        for column in &mut columns {
            column.push(vector(words, "a component of a direction")?);
        }
        Ok(())
    })?;
    let zeros = columns[0].iter().filter(|row| **row == [0.0; 3]).count();
    if zeros > 0 {
        grid.notes.push(format!("{zeros} of {} elements without fibre", columns[0].len()));
    }
    for (name, column) in DIRECTIONS.iter().zip(columns) {
        grid.cell_fields.insert((*name).into(), Field::vectors(&column));
    }
    Ok(())
}

/// One or more surfaces: the number of elements with or without a name, then the elements.
fn surfaces(
    cursor: &mut Cursor<'_>,
    file: &str,
    grid: &mut UnstructuredGrid,
) -> Result<(), Problem> {
    let mut found: Vec<(String, Vec<usize>)> = Vec::new();
    while let Some(mut header) = words(cursor) {
        let count: usize = next(&mut header, "the number of elements of a surface")?;
        let label = header.next().map(|word| String::from_utf8_lossy(word).into_owned());
        let first = grid.types.len();
        for _ in 0..count {
            let expected = "an element of the surface";
            let mut words = words(cursor).ok_or(Problem::Missing { expected })?;
            if element(&mut words, grid)? != 2 {
                return Err(Problem::expected("a Tr or Qd of the surface", "another element"));
            }
        }
        found.push((
            label.unwrap_or_else(|| found.len().to_string()),
            (first..grid.types.len()).collect(),
        ));
    }
    let is_one = found.len() == 1;
    for (label, members) in found {
        let name = if is_one { file.to_string() } else { format!("{file}:{label}") };
        grid.groups.entry(name).or_default().extend(members);
    }
    Ok(())
}

/// The number of vertices, a line `intra` or `extra`, and the vertices.
fn vertices(
    cursor: &mut Cursor<'_>,
    name: &str,
    grid: &mut UnstructuredGrid,
) -> Result<(), Problem> {
    let count = header(cursor, "the number of vertices")?;
    let set = grid.node_sets.entry(name.into()).or_default();
    let start = cursor.position();
    let domain = words(cursor).and_then(|mut words| words.next());
    if !matches!(domain, Some(b"intra" | b"extra")) {
        cursor.rewind(start);
    }
    rows(cursor, "vertices", count, |words| {
        let word = words.next().ok_or(Problem::Missing { expected: "a vertex" })?;
        set.push(node(word, grid.points.len())? as usize);
        Ok(())
    })?;
    set.sort_unstable();
    set.dedup();
    Ok(())
}
