//! gmsh MSH files, versions 2.2 and 4.1 (Gmsh reference manual, "MSH file format"). Text and binary files have the same numbers in
//! the same order.

use super::cursor::{Cursor, Encoding, Fault, Result};
use super::grid::{MixedMesh, cell_type, indices};
use super::number::NumberType::{F64, I32, U64};
use crate::{Field, FieldValues, QuadraticTetMesh, Refusal};
use std::collections::{BTreeMap, HashMap};

/// Physical groups of one entity beyond which the file is taken for damaged: each element of
/// the entity joins them all, so this bounds memory by a multiple of the file's size.
const MOST_GROUPS: i64 = 64;

/// VTK types of gmsh's element types from 0 on; 0 for those without one.
const VTK_TYPES: [u8; 20] =
    [0, 3, 5, 9, 10, 12, 13, 14, 21, 22, 28, 24, 29, 0, 0, 1, 23, 25, 26, 27];

/// Entities read so far.
#[derive(Default)]
struct Gmsh<'a> {
    cursor: Cursor<'a>,
    /// Major version of the format, 0 until it is read.
    version: u8,
    /// Encoding of the binary sections, or text.
    binary: Encoding,
    grid: MixedMesh,
    /// Names of physical groups by dimension and tag.
    names: HashMap<(i64, i64), String>,
    /// Elements of physical groups by dimension and tag.
    groups: BTreeMap<(i64, i64), Vec<usize>>,
    /// Physical tags of the model's entities by dimension and tag (version 4).
    physicals: HashMap<(i64, i64), Vec<i64>>,
    /// Index of each node tag.
    node_index: HashMap<i64, usize>,
    /// Index of each element tag.
    element_index: HashMap<i64, usize>,
    /// Index of each element by type and nodes (version 2).
    known: HashMap<(u8, Vec<i64>), usize>,
}

/// Reads the nodes, elements, physical groups and data of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let mut gmsh = Gmsh { cursor: Cursor::new(bytes), ..Gmsh::default() };
    gmsh.read().map_err(|problem| gmsh.cursor.fault(problem))?;
    gmsh.name_groups();
    Ok(gmsh.grid)
}

impl Gmsh<'_> {
    fn read(&mut self) -> Result<()> {
        while self.section()? {}
        Refusal::require_part(!self.grid.points.is_empty(), "a $Nodes section")?;
        Refusal::require_part(!self.grid.types.is_empty(), "an $Elements section")
    }

    /// Reads one section; false at the end of the file.
    fn section(&mut self) -> Result<bool> {
        let Some(name) = self.cursor.word() else { return Ok(false) };
        let Some(bare) = name.strip_prefix(b"$") else {
            return Err(Refusal::expected("the $Name of a section", name));
        };
        let may_come = self.version > 0 || matches!(bare, b"MeshFormat" | b"Comments");
        Refusal::require(may_come, "$MeshFormat", name)?;
        self.cursor.line();
        self.cursor.encoding = self.binary;
        match (bare, self.version) {
            (b"MeshFormat", _) => self.format()?,
            (b"PhysicalNames", _) => self.physical_names()?,
            (b"Nodes", 2) => self.nodes_2(false)?,
            (b"ParametricNodes", 2) => self.nodes_2(true)?,
            (b"Nodes", _) => self.nodes_4()?,
            (b"Elements", 2) => self.elements_2()?,
            (b"Elements", _) => self.elements_4()?,
            (b"Entities", 4) => self.entities_4(false)?,
            (b"PartitionedEntities", 4) => self.entities_4(true)?,
            (b"NodeData", _) => self.data(true)?,
            (b"ElementData", _) => self.data(false)?,
            _ => {
                self.cursor.skip_past(&[b"$End", bare].concat(), "the end of the section")?;
                return Ok(true);
            }
        }
        let end = self.cursor.text("the $End of a section")?;
        let is_own = end.strip_prefix("$End").map(str::as_bytes) == Some(bare);
        Refusal::require(is_own, "the $End of the section", end)?;
        Ok(true)
    }

    /// `version file-type data-size`, and in binary a 1 that shows the order of bytes.
    fn format(&mut self) -> Result<()> {
        let version = self.cursor.text("the version of the format")?;
        self.version = match version {
            "2.2" | "2.1" | "2" => 2,
            "4.1" => 4,
            _ => {
                let advice = "convert it with `gmsh -save -format msh41`";
                return Err(Refusal::unsupported("MSH version", version, advice));
            }
        };
        let binary: u8 = self.cursor.parse("the file type 0 or 1")?;
        let size: usize = self.cursor.parse("the data size")?;
        if size != 8 {
            let advice = "save the mesh with a 64-bit gmsh";
            return Err(Refusal::unsupported("data size", size.to_string(), advice));
        }
        self.cursor.line();
        if binary == 1 {
            self.binary = match self.cursor.take(4, "the number that shows the order of bytes")? {
                [1, 0, 0, 0] => Encoding::Little,
                [0, 0, 0, 1] => Encoding::Big,
                other => return Err(Refusal::expected("the number 1 in binary", other)),
            };
        }
        Ok(())
    }

    /// Lines of `dimension tag "name"`.
    fn physical_names(&mut self) -> Result<()> {
        let count: usize = self.cursor.parse("the number of physical names")?;
        for _ in 0..count {
            let dimension = self.cursor.parse("the dimension of a physical group")?;
            let tag = self.cursor.parse("the tag of a physical group")?;
            let name = self.cursor.text_line("the name of a physical group")?;
            self.names.insert((dimension, tag), name.trim_matches('"').to_string());
        }
        Ok(())
    }

    /// A post-processing view: name, three lists of tags, then a tag and numbers per row.
    fn data(&mut self, of_nodes: bool) -> Result<()> {
        let strings: usize = self.cursor.parse("the number of string tags")?;
        self.cursor.line();
        let mut name = None;
        for _ in 0..strings {
            let text = self.cursor.text_line("a string tag")?;
            name.get_or_insert(text.trim_matches('"').to_string());
        }
        let reals: usize = self.cursor.parse("the number of real tags")?;
        for _ in 0..reals {
            self.cursor.parse::<f64>("a real tag")?;
        }
        let integers: usize = self.cursor.parse("the number of integer tags")?;
        let tags = (0..integers).map(|_| self.cursor.parse("an integer tag"));
        let tags: Vec<usize> = tags.collect::<Result<_>>()?;
        self.cursor.line();
        let [components, rows] = [1, 2].map(|index| tags.get(index).copied().unwrap_or(0));
        self.rows(of_nodes, name.unwrap_or_else(|| "data".into()), [rows, components])
    }

    fn rows(&mut self, of_nodes: bool, name: String, [rows, components]: [usize; 2]) -> Result<()> {
        // gmsh knows scalars, vectors and tensors only, which bounds the memory of a view.
        Refusal::require_within("the number of components", components as i64, [1, 9])?;
        let total = if of_nodes { self.grid.points.len() } else { self.grid.types.len() };
        let mut values = vec![f64::NAN; total.saturating_mul(components)];
        let mut seen = vec![false; total];
        for _ in 0..rows {
            let tag = self.cursor.integer(I32, "the tag of a data row")?;
            let index = if of_nodes { &self.node_index } else { &self.element_index };
            let Some(&index) = index.get(&tag) else {
                return Err(Refusal::expected("the tag of a node or element", tag.to_string()));
            };
            let row = self.cursor.reals(F64, components, "numbers of a data row")?;
            values[index * components..][..components].copy_from_slice(&row);
            seen[index] = true;
        }
        if !of_nodes {
            // gmsh writes views of the elements that have a value, which need not be those of the boundary.
            let dimension = |&kind: &u8| cell_type(kind).1;
            let top = self.grid.types.iter().map(dimension).max();
            let mut dimensions = self.grid.types.iter().map(dimension);
            seen.retain(|_| dimensions.next() == top);
        }
        let (found, expected) = (seen.iter().filter(|&&row| row).count(), seen.len());
        if found == 0 && !of_nodes {
            let what = format!("element data `{}` of the boundary", name.escape_debug());
            self.grid.left_out.push(what);
            return Ok(());
        }
        let what = format_args!("rows of `{}`", name.escape_debug());
        Refusal::require_count(what, expected, found)?;
        let field = Field { components, values: FieldValues::Float(values) };
        self.grid.add_field(of_nodes, name, field)
    }

    /// Nodes of MSH 2.2: rows of a tag and three coordinates; parametric ones with the dimension and the tag of the node's
    /// entity, and its one or two parameters on a curve or surface.
    fn nodes_2(&mut self, parametric: bool) -> Result<()> {
        let count: usize = self.cursor.parse("the number of nodes")?;
        self.cursor.line();
        self.grid.points_at = self.cursor.here();
        for _ in 0..count {
            let tag = self.cursor.integer(I32, "the tag of a node")?;
            let point = self.cursor.reals(F64, 3, "coordinates")?;
            self.node(tag, [point[0], point[1], point[2]])?;
            if parametric {
                let entity = self.cursor.integers(I32, 2, "dimension and tag of an entity")?;
                let parameters = if let 1..=2 = entity[0] { entity[0] as usize } else { 0 };
                self.cursor.reals(F64, parameters, "parameters of a node")?;
            }
        }
        Ok(())
    }

    /// Elements of MSH 2.2 with their tags, of which the first is the physical group. An element in several
    /// groups is listed once for each.
    fn elements_2(&mut self) -> Result<()> {
        let count: usize = self.cursor.parse("the number of elements")?;
        self.cursor.line();
        self.grid.cells_at = self.cursor.here();
        self.known.clear();
        let mut read = 0;
        while read < count {
            // In text each element is a block of its own, whose tag comes first.
            let is_text = self.cursor.encoding == Encoding::Text;
            let tag = is_text.then(|| self.cursor.integer(I32, "the tag of an element"));
            let tag = tag.transpose()?;
            let kind = self.cursor.integer(I32, "the type of elements")?;
            let counted = "the number of elements in a block";
            let block = if is_text { 1 } else { self.cursor.count(I32, counted)?.max(1) };
            let tags = self.cursor.count(I32, "the number of tags")?;
            for _ in 0..block {
                self.row_2(tag, kind, tags)?;
            }
            read += block;
        }
        Ok(())
    }

    fn row_2(&mut self, tag: Option<i64>, kind: i64, tags: usize) -> Result<()> {
        let (vtk_type, length) = element_type(kind)?;
        let read = || self.cursor.integer(I32, "the tag of an element");
        let tag = tag.map_or_else(read, Ok)?;
        let tags = self.cursor.integers(I32, tags, "tags of an element")?;
        let nodes = self.cursor.integers(I32, length, "nodes of an element")?;
        let index = match self.known.get(&(vtk_type, nodes.clone())) {
            Some(&index) => index,
            None => self.element(vtk_type, &nodes)?,
        };
        self.known.insert((vtk_type, nodes), index);
        self.element_index.insert(tag, index);
        if let Some(&physical) = tags.first().filter(|&&physical| physical != 0) {
            self.join_group(cell_type(vtk_type).1, physical, index);
        }
        Ok(())
    }

    /// The points, curves, surfaces and volumes of the model with their physical groups; of a mesh in partitions those of each
    /// part.
    fn entities_4(&mut self, partitioned: bool) -> Result<()> {
        if partitioned {
            self.cursor.count(U64, "the number of partitions")?;
            let ghosts = self.cursor.count(U64, "the number of ghost entities")?;
            self.cursor.integers(I32, ghosts.saturating_mul(2), "ghost entities")?;
        }
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = self.cursor.count(U64, "the number of entities")?;
        }
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let tag = self.cursor.integer(I32, "the tag of an entity")?;
                if partitioned {
                    self.cursor.integers(I32, 2, "the entity that was divided")?;
                    let parts = self.cursor.count(U64, "the number of partitions")?;
                    self.cursor.integers(I32, parts, "tags of partitions")?;
                }
                // A point's position, or the corners of a bounding box.
                let numbers = if dimension == 0 { 3 } else { 6 };
                self.cursor.reals(F64, numbers, "the extent of an entity")?;
                let groups = self.cursor.count(U64, "the number of physical groups")?;
                let what = "the number of physical groups of an entity";
                Refusal::require_within(what, groups as i64, [0, MOST_GROUPS])?;
                let groups = self.cursor.integers(I32, groups, "tags of physical groups")?;
                if dimension > 0 {
                    let bounding = self.cursor.count(U64, "the number of bounding entities")?;
                    self.cursor.integers(I32, bounding, "tags of bounding entities")?;
                }
                self.physicals.insert((dimension as i64, tag), groups);
            }
        }
        Ok(())
    }

    /// Nodes of MSH 4.1 in blocks: tags first, then coordinates.
    fn nodes_4(&mut self) -> Result<()> {
        let blocks = self.block_count()?;
        self.grid.points_at = self.cursor.here();
        for _ in 0..blocks {
            let dimension = self.cursor.count(I32, "the dimension of an entity")?.min(3);
            self.cursor.integer(I32, "the tag of an entity")?;
            let parametric = self.cursor.integer(I32, "whether nodes are parametric")? != 0;
            let count = self.cursor.count(U64, "the number of nodes in a block")?;
            let tags = self.cursor.integers(U64, count, "tags of nodes")?;
            let width = if parametric { 3 + dimension } else { 3 };
            let numbers = self.cursor.reals(F64, count.saturating_mul(width), "coordinates")?;
            for (&tag, row) in tags.iter().zip(numbers.chunks_exact(width)) {
                self.node(tag, [row[0], row[1], row[2]])?;
            }
        }
        Ok(())
    }

    /// Elements of MSH 4.1 in blocks of one type on one entity.
    fn elements_4(&mut self) -> Result<()> {
        let blocks = self.block_count()?;
        self.grid.cells_at = self.cursor.here();
        for _ in 0..blocks {
            let dimension = self.cursor.integer(I32, "the dimension of an entity")?;
            let entity = self.cursor.integer(I32, "the tag of an entity")?;
            let kind = self.cursor.integer(I32, "the type of elements")?;
            let (vtk_type, length) = element_type(kind)?;
            let count = self.cursor.count(U64, "the number of elements in a block")?;
            let numbers = count.saturating_mul(1 + length);
            let rows = self.cursor.integers(U64, numbers, "elements")?;
            let groups = self.physicals.get(&(dimension, entity)).cloned().unwrap_or_default();
            for row in rows.chunks_exact(1 + length) {
                let index = self.element(vtk_type, &row[1..])?;
                self.element_index.insert(row[0], index);
                for &physical in &groups {
                    self.join_group(dimension, physical, index);
                }
            }
        }
        Ok(())
    }

    /// The number of blocks; the totals behind it follow from the blocks.
    fn block_count(&mut self) -> Result<usize> {
        let blocks = self.cursor.count(U64, "the number of blocks")?;
        for what in ["the total count", "the smallest tag", "the largest tag"] {
            self.cursor.count(U64, what)?;
        }
        Ok(blocks)
    }

    /// Names the groups. Numbers of groups without a name are given anew in each dimension.
    fn name_groups(&mut self) {
        let top = self.grid.types.iter().map(|&kind| cell_type(kind).1).max().unwrap_or(3);
        let groups = std::mem::take(&mut self.groups);
        let unnamed = |key: &(i64, i64)| groups.contains_key(key) && !self.names.contains_key(key);
        for (&(dimension, tag), members) in &groups {
            let mut others = (0..top).filter(|&other| other != dimension && dimension < top);
            let twice = others.any(|other| unnamed(&(other, tag)));
            let kinds = ["point_", "curve_", "surface_"].iter();
            let kind = kinds.filter(|_| twice).nth(dimension as usize).unwrap_or(&"");
            let named = self.names.get(&(dimension, tag)).cloned();
            let name = named.unwrap_or_else(|| format!("physical_{kind}{tag}"));
            self.grid.groups.entry(name).or_default().extend(members);
        }
    }

    /// Adds a node.
    fn node(&mut self, tag: i64, point: [f64; 3]) -> Result<()> {
        let before = self.node_index.insert(tag, self.grid.points.len());
        Refusal::unless_used(before, "a node tag that is not used yet", tag)?;
        self.grid.points.push(point);
        Ok(())
    }

    /// Adds an element with the tags of its nodes and returns its index.
    fn element(&mut self, kind: u8, nodes: &[i64]) -> Result<usize> {
        let index = |tag: &i64| self.node_index.get(tag);
        let mut nodes = indices(nodes, "the tag of a node in $Nodes", index)?;
        if kind == QuadraticTetMesh::ELEMENT.vtk_type {
            // gmsh numbers the middles of the edges 23 and 13 the other way round.
            nodes.swap(8, 9);
        }
        self.grid.push(kind, &nodes);
        Ok(self.grid.types.len() - 1)
    }

    /// Puts an element into a physical group.
    fn join_group(&mut self, dimension: i64, tag: i64, element: usize) {
        // A minus sign means reversed orientation, which facets do not need.
        self.groups.entry((dimension, tag.saturating_abs())).or_default().push(element);
    }
}

/// VTK type and number of nodes of a gmsh element type.
fn element_type(gmsh_type: i64) -> Result<(u8, usize)> {
    let vtk_type = usize::try_from(gmsh_type).ok().and_then(|index| VTK_TYPES.get(index).copied());
    let found = vtk_type.and_then(|vtk_type| Some((vtk_type, cell_type(vtk_type).2?)));
    found.ok_or_else(|| {
        let advice = "save the mesh with first-order elements (Mesh.ElementOrder = 1)";
        Refusal::unsupported("gmsh element type", gmsh_type.to_string(), advice)
    })
}
