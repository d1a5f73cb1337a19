//! Legacy VTK files, text and binary: versions 2.0 to 4.2 list the nodes of cells behind
//! their number, 5.1 has OFFSETS and CONNECTIVITY (VTK User's Guide, "VTK File Formats", and
//! "VTK XML/legacy file formats 5.1" of the VTK documentation).

use super::cursor::{Cursor, Encoding, Fault, Result, number, text_of};
use super::grid::MixedMesh;
use super::number::NumberType;
use super::polydata::{CellList, LISTS, PolyData};
use crate::{Field, FieldValues, Refusal};
use percent_encoding::percent_decode_str;

/// First bytes of every legacy VTK file.
pub(crate) const MAGIC: &[u8] = b"# vtk DataFile Version";

/// Reads an unstructured grid or a surface (POLYDATA).
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let mut reader = Reader { cursor: Cursor::new(bytes), ..Reader::default() };
    reader.read().map_err(|problem| reader.cursor.fault(problem))?;
    Ok(reader.grid)
}

#[derive(Default)]
struct Reader<'a> {
    cursor: Cursor<'a>,
    grid: MixedMesh,
    cells: PolyData,
    /// The section that attributes belong to, POINT_DATA or CELL_DATA, and the number of rows of its arrays.
    attributes_of: Option<(&'static str, usize)>,
    /// Major version of the format.
    major: u32,
}

impl Reader<'_> {
    fn read(&mut self) -> Result<()> {
        self.header()?;
        while self.section()? {}
        std::mem::take(&mut self.cells).fill(&mut self.grid)?;
        Refusal::require_part(!self.grid.points.is_empty(), "a POINTS section")?;
        let (expected, found) = (self.grid.ends.len(), self.grid.types.len());
        Refusal::require_count("CELL_TYPES", expected, found)
    }

    fn header(&mut self) -> Result<()> {
        let version = self.cursor.text_line("# vtk DataFile Version x.y")?;
        let number = version.rsplit(' ').next().and_then(|v| v.split('.').next()?.parse().ok());
        let wrong = || Refusal::expected("# vtk DataFile Version x.y", version);
        self.major = number.ok_or_else(wrong)?;
        self.cursor.line();
        let encoding = self.cursor.text("ASCII or BINARY")?;
        let encoding = match encoding.to_ascii_uppercase().as_str() {
            "ASCII" => Encoding::Text,
            // Legacy VTK is big endian on every machine.
            "BINARY" => Encoding::Big,
            _ => return Err(Refusal::expected("ASCII or BINARY", encoding)),
        };
        self.cursor.keyword("DATASET")?;
        let dataset = self.cursor.text("a dataset type")?;
        match dataset.to_ascii_uppercase().as_str() {
            "UNSTRUCTURED_GRID" => {}
            "POLYDATA" => self.cells.is_surface = true,
            _ => {
                let advice = "save it as an unstructured grid, or a surface as poly data";
                return Err(Refusal::unsupported("dataset type", dataset, advice));
            }
        }
        self.cursor.encoding = encoding;
        Ok(())
    }

    /// Reads one section; false at the end of the file.
    fn section(&mut self) -> Result<bool> {
        let Some(word) = self.cursor.word() else { return Ok(false) };
        match word.to_ascii_uppercase().as_slice() {
            b"POINTS" => self.points()?,
            b"CELL_TYPES" => self.cell_types()?,
            b"POINT_DATA" => self.attributes("POINT_DATA", self.grid.points.len())?,
            b"CELL_DATA" => self.attributes("CELL_DATA", self.cells.cell_count())?,
            b"METADATA" => self.metadata(),
            b"FIELD" => self.field_arrays()?,
            b"LOOKUP_TABLE" => self.lookup_table()?,
            b"CELLS" if !self.cells.is_surface => self.list(0)?,
            keyword => {
                let list = LISTS.iter().position(|list| self.cells.is_surface && list.1 == keyword);
                let components = self.attributes_of.and_then(|_| attribute_components(keyword));
                match (list, components) {
                    (Some(list), _) => self.list(list)?,
                    (_, Some(components)) => self.attribute(keyword, components)?,
                    _ => return Err(Refusal::expected("the keyword of a section", word)),
                }
            }
        }
        Ok(true)
    }

    /// Requires the declared number of rows of POINT_DATA or CELL_DATA to be the true one.
    fn attributes(&mut self, section: &'static str, expected: usize) -> Result<()> {
        let found = self.cursor.parse("the number of rows")?;
        Refusal::require_count(format_args!("rows of {section}"), expected, found)?;
        self.attributes_of = Some((section, expected));
        Ok(())
    }

    fn points(&mut self) -> Result<()> {
        let count: usize = self.cursor.parse("the number of points")?;
        let kind = number_type(self.cursor.text("a number type")?)?;
        // Here and below: binary numbers begin directly behind the line break.
        self.cursor.line();
        self.grid.points_at = self.cursor.here();
        let coordinates = self.cursor.reals(kind, count.saturating_mul(3), "coordinates")?;
        self.grid.points = coordinates.as_chunks().0.to_vec();
        Ok(())
    }

    fn list(&mut self, list: usize) -> Result<()> {
        let has_offsets = self.major >= 5;
        let cells =
            if has_offsets { self.cells_with_offsets()? } else { self.cells_with_counts()? };
        self.cells.lists[list] = Some(cells);
        Ok(())
    }

    /// `CELLS n size`, then each cell as its number of nodes and the nodes.
    fn cells_with_counts(&mut self) -> Result<CellList> {
        let count: usize = self.cursor.parse("the number of cells")?;
        let size: usize = self.cursor.parse("the size of the cell list")?;
        self.cursor.line();
        let at = self.cursor.here();
        let list = self.cursor.integers(NumberType::I32, size, "the cell list")?;
        let (mut ends, mut nodes) = (Vec::new(), Vec::with_capacity(list.len()));
        let mut rest = list.as_slice();
        while let [length, tail @ ..] = rest {
            let bounds = [0, tail.len() as i64];
            Refusal::require_within("the number of nodes of a cell", *length, bounds)?;
            let (cell, others) = tail.split_at(*length as usize);
            nodes.extend_from_slice(cell);
            ends.push(nodes.len());
            rest = others;
        }
        Refusal::require_count("cells in the cell list", count, ends.len())?;
        Ok(CellList { ends, nodes, at })
    }

    /// `CELLS n m`, then arrays of `n` offsets and `m` nodes.
    fn cells_with_offsets(&mut self) -> Result<CellList> {
        let offsets: usize = self.cursor.parse("the number of offsets")?;
        let nodes: usize = self.cursor.parse("the length of the connectivity")?;
        self.cursor.keyword("OFFSETS")?;
        let kind = number_type(self.cursor.text("a number type")?)?;
        self.cursor.line();
        let offsets = self.cursor.integers(kind, offsets, "offsets of cells")?;
        let ends = checked_ends(&offsets, nodes)?;
        self.cursor.keyword("CONNECTIVITY")?;
        let kind = number_type(self.cursor.text("a number type")?)?;
        self.cursor.line();
        let at = self.cursor.here();
        let nodes = self.cursor.integers(kind, nodes, "nodes of cells")?;
        Ok(CellList { ends, nodes, at })
    }

    fn cell_types(&mut self) -> Result<()> {
        let count: usize = self.cursor.parse("the number of cell types")?;
        self.cursor.line();
        let types = self.cursor.integers(NumberType::I32, count, "cell types")?;
        self.grid.set_types(&types);
        Ok(())
    }

    /// SCALARS, VECTORS and their like.
    fn attribute(&mut self, keyword: &[u8], mut components: usize) -> Result<()> {
        let name = decoded(self.cursor.text("the name of the attribute")?);
        if matches!(keyword, b"COLOR_SCALARS" | b"TEXTURE_COORDINATES") {
            components = self.cursor.parse("the number of components")?;
        }
        let kind =
            if keyword == b"COLOR_SCALARS" { Values::Colours } else { self.type_of_values()? };
        let on_line = self.cursor.line().unwrap_or_default();
        if keyword == b"SCALARS" {
            if !on_line.is_empty() {
                components = number(on_line, "the number of components")?;
            }
            // A line `LOOKUP_TABLE name` follows, which some programs leave out.
            let before = self.cursor.position;
            let line = self.cursor.line().unwrap_or_default();
            if !line.to_ascii_uppercase().starts_with(b"LOOKUP_TABLE") {
                self.cursor.position = before;
            }
        }
        self.array(name, components, kind)
    }

    fn array(&mut self, name: String, components: usize, kind: Values) -> Result<()> {
        let Some((section, rows)) = self.attributes_of else { return Ok(()) };
        let count = rows.saturating_mul(components);
        let values = match self.values(kind, count)? {
            None => {
                self.grid.left_out.push(format!("array `{}` of text or bits", name.escape_debug()));
                return Ok(());
            }
            Some(FieldValues::Float(shares)) if kind == Values::Colours => characters(&shares)?,
            Some(values) => values,
        };
        self.grid.add_field(section == "POINT_DATA", name, Field { components, values })
    }

    /// `FIELD name n`, then `n` arrays. Those outside POINT_DATA and CELL_DATA, such as a
    /// time, describe the whole data set and are left out.
    fn field_arrays(&mut self) -> Result<()> {
        self.cursor.text("the name of the field data")?;
        let arrays: usize = self.cursor.parse("the number of arrays")?;
        for _ in 0..arrays {
            let mut name = self.cursor.text("the name of an array")?;
            if name.eq_ignore_ascii_case("METADATA") {
                self.metadata();
                name = self.cursor.text("the name of an array")?;
            }
            let name = decoded(name);
            let components = self.cursor.parse("the number of components")?;
            let rows: usize = self.cursor.parse("the number of rows")?;
            let kind = self.type_of_values()?;
            self.cursor.line();
            let Some((_, expected)) = self.attributes_of else {
                self.values(kind, rows.saturating_mul(components))?;
                continue;
            };
            let what = format_args!("rows of array `{}`", name.escape_debug());
            Refusal::require_count(what, expected, rows)?;
            self.array(name, components, kind)?;
        }
        Ok(())
    }

    /// `LOOKUP_TABLE name size`, then `size` colours, which are not part of a mesh.
    fn lookup_table(&mut self) -> Result<()> {
        self.cursor.text("the name of the lookup table")?;
        let size: usize = self.cursor.parse("the size of the lookup table")?;
        self.cursor.line();
        self.values(Values::Colours, size.saturating_mul(4)).map(drop)
    }

    /// Values of an array; none of text and bits, which are passed over.
    fn values(&mut self, kind: Values, count: usize) -> Result<Option<FieldValues>> {
        const WHAT: &str = "values of a field";
        let binary = self.cursor.encoding != Encoding::Text;
        let of_colours = if binary { NumberType::U8 } else { NumberType::F64 };
        match kind {
            Values::Numbers(kind) => return self.cursor.numbers(kind, count, WHAT).map(Some),
            Values::Colours => return self.cursor.numbers(of_colours, count, WHAT).map(Some),
            Values::Bits if binary => drop(self.cursor.take(count.div_ceil(8), WHAT)?),
            Values::Bits => drop(self.cursor.numbers(NumberType::U8, count, WHAT)?),
            Values::Text if binary => {
                for _ in 0..count {
                    // The first two bits say how many bytes the length takes: 8, 4, 2 or 1.
                    let first = self.cursor.take(1, WHAT)?[0];
                    let more = self.cursor.take((8 >> (first >> 6)) - 1, WHAT)?;
                    let start = usize::from(first & 0x3f);
                    let length = more.iter().fold(start, |length, &byte| {
                        length.saturating_mul(256).saturating_add(byte.into())
                    });
                    self.cursor.take(length, WHAT)?;
                }
            }
            Values::Text => {
                for _ in 0..count {
                    self.cursor.line().ok_or_else(|| Refusal::missing(WHAT))?;
                }
            }
        }
        Ok(None)
    }

    /// METADATA describes the array before it and ends with an empty line.
    fn metadata(&mut self) {
        self.cursor.line();
        while self.cursor.line().is_some_and(|line| !line.is_empty()) {}
    }

    fn type_of_values(&mut self) -> Result<Values> {
        let name = self.cursor.text("a number type")?;
        Ok(match name.to_ascii_lowercase().as_str() {
            "string" | "utf8_string" => Values::Text,
            "bit" => Values::Bits,
            _ => Values::Numbers(number_type(name)?),
        })
    }
}

fn number_type(name: &str) -> Result<NumberType> {
    NumberType::named(&name.to_ascii_lowercase().replace("vtktype", "")).ok_or_else(|| {
        let advice = "save the array with a type from char to double, or without this array";
        Refusal::unsupported("number type", name, advice)
    })
}

/// Values of an array in the file; no field of a mesh is of text or bits.
#[derive(Clone, Copy, PartialEq)]
enum Values {
    Numbers(NumberType),
    Colours,
    Text,
    Bits,
}

/// Unsigned characters, whose shares of 255 stand in text.
fn characters(shares: &[f64]) -> Result<FieldValues> {
    if let Some(share) = shares.iter().find(|share| !(0.0..=1.0).contains(*share)) {
        return Err(Refusal::expected("a colour from 0 to 1", share.to_string()));
    }
    let of_255 = shares.iter().map(|share| (255.0 * share).round() as i64);
    Ok(FieldValues::Integer(of_255.collect()))
}

/// Components of the attributes that may follow POINT_DATA and CELL_DATA.
fn attribute_components(keyword: &[u8]) -> Option<usize> {
    match keyword {
        b"SCALARS" | b"COLOR_SCALARS" | b"TEXTURE_COORDINATES" => Some(1),
        b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => Some(1),
        b"VECTORS" | b"NORMALS" => Some(3),
        b"TENSORS6" => Some(6),
        b"TENSORS" => Some(9),
        _ => None,
    }
}

/// Offsets ascend from 0 to the length of the connectivity.
pub(crate) fn checked_ends(offsets: &[i64], nodes: usize) -> Result<Vec<usize>> {
    let most = nodes as i64;
    let within = |offset: Option<&i64>, bounds| {
        Refusal::require_within("an offset of a cell", offset.copied().unwrap_or(-1), bounds)
    };
    within(offsets.first(), [0, 0])?;
    within(offsets.last(), [most, most])?;
    offsets.windows(2).try_for_each(|pair| within(Some(&pair[1]), [pair[0], most]))?;
    Ok(offsets.iter().skip(1).map(|&offset| offset as usize).collect())
}

/// Name of a field, whose blanks and the like stand as `%20` in files.
fn decoded(name: &str) -> String {
    text_of(&percent_decode_str(name).collect::<Vec<u8>>())
}
