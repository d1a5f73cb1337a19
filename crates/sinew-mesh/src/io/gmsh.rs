//! gmsh MSH files: the sections that versions 2.2 and 4.1 share (Gmsh reference manual,
//! "MSH file format").

use super::cursor::{Cursor, Encoding, Endian, Fault};
use super::gmsh_model::{Gmsh, Version};
use super::grid::{MixedMesh, cell_type};
use super::number::NumberType;
use crate::{Field, FieldValues, Problem};

/// Reads the nodes, elements, physical groups and data of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let mut gmsh = Gmsh { cursor: Cursor::new(bytes), ..Gmsh::default() };
    gmsh.read().map_err(|problem| gmsh.cursor.fault(problem))?;
    gmsh.name_groups();
    Ok(gmsh.grid)
}

impl Gmsh<'_> {
    fn read(&mut self) -> Result<(), Problem> {
        while self.section()? {}
        if self.grid.points.is_empty() {
            return Err(Problem::Missing { expected: "a $Nodes section" });
        }
        if self.grid.types.is_empty() {
            return Err(Problem::Missing { expected: "an $Elements section" });
        }
        Ok(())
    }

    /// Reads one section; false at the end of the file.
    fn section(&mut self) -> Result<bool, Problem> {
        let Some(name) = self.cursor.word() else { return Ok(false) };
        let Some(bare) = name.strip_prefix(b"$") else {
            return Err(Problem::expected("the $Name of a section", name));
        };
        if self.version == Version::None && !matches!(bare, b"MeshFormat" | b"Comments") {
            return Err(Problem::expected("$MeshFormat", name));
        }
        self.cursor.line();
        self.cursor.encoding = self.binary;
        match (bare, self.version) {
            (b"MeshFormat", _) => self.format()?,
            (b"PhysicalNames", _) => self.physical_names()?,
            (b"Nodes", Version::Two) => super::gmsh2::nodes(self, false)?,
            (b"ParametricNodes", Version::Two) => super::gmsh2::nodes(self, true)?,
            (b"Nodes", _) => super::gmsh4::nodes(self)?,
            (b"Elements", Version::Two) => super::gmsh2::elements(self)?,
            (b"Elements", _) => super::gmsh4::elements(self)?,
            (b"Entities", Version::Four) => super::gmsh4::entities(self, false)?,
            (b"PartitionedEntities", Version::Four) => super::gmsh4::entities(self, true)?,
            (b"NodeData", _) => self.data(true)?,
            (b"ElementData", _) => self.data(false)?,
            _ => {
                self.cursor.skip_past(&[b"$End", bare].concat(), "the end of the section")?;
                return Ok(true);
            }
        }
        let end = self.cursor.text("the $End of a section")?;
        if end.strip_prefix("$End").map(str::as_bytes) != Some(bare) {
            return Err(Problem::expected("the $End of the section", end));
        }
        Ok(true)
    }

    /// `version file-type data-size`, and in binary a 1 that shows the order of bytes.
    fn format(&mut self) -> Result<(), Problem> {
        let version = self.cursor.text("the version of the format")?;
        self.version = match version {
            "2.2" | "2.1" | "2" => Version::Two,
            "4.1" => Version::Four,
            _ => {
                let advice = "convert it with `gmsh -save -format msh41`";
                return Err(Problem::unsupported("MSH version", version, advice));
            }
        };
        let binary: u8 = self.cursor.parse("the file type 0 or 1")?;
        let size: usize = self.cursor.parse("the data size")?;
        if size != 8 {
            let advice = "save the mesh with a 64-bit gmsh";
            return Err(Problem::unsupported("data size", size.to_string(), advice));
        }
        self.cursor.line();
        if binary == 1 {
            self.binary = match self.cursor.take(4, "the number that shows the order of bytes")? {
                [1, 0, 0, 0] => Encoding::Binary(Endian::Little),
                [0, 0, 0, 1] => Encoding::Binary(Endian::Big),
                other => return Err(Problem::expected("the number 1 in binary", other)),
            };
        }
        Ok(())
    }

    /// Lines of `dimension tag "name"`.
    fn physical_names(&mut self) -> Result<(), Problem> {
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
    fn data(&mut self, of_nodes: bool) -> Result<(), Problem> {
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
        let mut tags = [0usize; 3];
        for index in 0..integers {
            let tag = self.cursor.parse("an integer tag")?;
            if let Some(slot) = tags.get_mut(index) {
                *slot = tag;
            }
        }
        self.cursor.line();
        let [_, components, rows] = tags;
        self.rows(of_nodes, name.unwrap_or_else(|| "data".into()), [rows, components])
    }

    fn rows(&mut self, of_nodes: bool, name: String, size: [usize; 2]) -> Result<(), Problem> {
        let [rows, components] = size;
        // gmsh knows scalars, vectors and tensors only, which bounds the memory of a view.
        Problem::require_within("the number of components", components as i64, 1..=9)?;
        let total = if of_nodes { self.grid.points.len() } else { self.grid.types.len() };
        let mut values = vec![f64::NAN; total.saturating_mul(components)];
        let mut seen = vec![false; total];
        for _ in 0..rows {
            let tag = self.cursor.integer(NumberType::I32, "the tag of a data row")?;
            let index = if of_nodes { &self.node_index } else { &self.element_index };
            let Some(&index) = index.get(&tag) else {
                return Err(Problem::expected("the tag of a node or element", tag.to_string()));
            };
            let row = self.cursor.reals(NumberType::F64, components, "numbers of a data row")?;
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
        let what = || format!("rows of `{}`", name.escape_debug());
        Problem::require_count(what, expected, found)?;
        let field = Field { components, values: FieldValues::Float(values) };
        self.grid.fields(of_nodes).insert(name, field);
        Ok(())
    }
}
