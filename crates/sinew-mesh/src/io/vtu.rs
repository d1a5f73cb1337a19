//! VTU and VTP files: VTK's XML format for unstructured grids and surfaces with text, inline base64 and appended
//! (raw or base64) arrays, plain or compressed with zlib (VTK documentation, "VTK XML formats").

use super::cursor::{Encoding, Fault, Result, number};
use super::grid::MixedMesh;
use super::number::NumberType;
use super::polydata::{CellList, LISTS, PolyData};
use super::vtk::checked_ends;
use super::vtu_data::{Layout, Source, ascii, read_array};
use crate::{Field, Place, Refusal};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::collections::BTreeMap;

/// Reads an unstructured grid or a surface of one piece.
pub(crate) fn parse(bytes: &[u8]) -> Result<MixedMesh, Fault> {
    // Appended raw data is no XML, so the XML reader sees only what stands before it.
    let tag = b"<AppendedData";
    let start = bytes.windows(tag.len()).position(|window| window == tag);
    let (head, appended) = bytes.split_at(start.unwrap_or(bytes.len()));
    let mut parser = Parser {
        xml: Reader::from_reader(head),
        item: head.len(),
        layout: Layout::default(),
        appended: None,
        section: Section::Other,
        piece: None,
        skips: false,
        grid: MixedMesh::default(),
        cells: PolyData::default(),
        lists: Default::default(),
    };
    parser.xml.config_mut().check_end_names = false;
    parser.read(appended).map_err(|problem| (Place { byte: parser.item, line: None }, problem))?;
    Ok(parser.grid)
}

#[derive(Clone, Copy, PartialEq)]
enum Section {
    Points,
    /// The only list of cells of a grid, or one of the four of a surface.
    Cells(usize),
    PointData,
    CellData,
    Other,
}

struct Parser<'a> {
    xml: Reader<&'a [u8]>,
    /// Start of the last item, which errors point to.
    item: usize,
    layout: Layout,
    /// The section of appended data, where there is one.
    appended: Option<Source<'a>>,
    section: Section,
    /// Number of points, and of cells in each list.
    piece: Option<(usize, [usize; 4])>,
    /// Whether the last piece is one without points, as processes without a share of the body write.
    skips: bool,
    grid: MixedMesh,
    cells: PolyData,
    /// Arrays of each list of cells, and where they are in the file.
    lists: [BTreeMap<String, (Vec<i64>, usize)>; 4],
}

impl<'a> Parser<'a> {
    fn read(&mut self, appended: &'a [u8]) -> Result<()> {
        self.appended = Source::appended(self.item, appended)?;
        while self.element()? {}
        self.item = self.xml.buffer_position() as usize;
        self.finish()
    }

    fn event(&mut self) -> Result<Event<'a>> {
        let event = self.xml.read_event();
        Ok(event.inspect_err(|_| self.item = self.xml.error_position() as usize)?)
    }

    /// Reads up to the next tag; false at the end.
    fn element(&mut self) -> Result<bool> {
        self.item = self.xml.buffer_position() as usize;
        match self.event()? {
            Event::Start(tag) => self.start(&tag, false)?,
            Event::Empty(tag) => self.start(&tag, true)?,
            Event::End(tag) if section_named(tag.name().as_ref()).is_some() => {
                self.section = Section::Other;
            }
            Event::Eof => return Ok(false),
            _ => {}
        }
        Ok(true)
    }

    fn start(&mut self, tag: &BytesStart<'a>, empty: bool) -> Result<()> {
        match tag.name().as_ref() {
            b"VTKFile" => self.file_header(tag)?,
            b"Piece" => self.piece(tag)?,
            b"DataArray" => {
                let text = if empty { Vec::new() } else { self.array_text()? };
                if self.section != Section::Other && !self.skips {
                    self.array(tag, &text)?;
                }
            }
            // Data of the whole file, such as a time, is not part of the mesh.
            name if !empty => self.section = section_named(name).unwrap_or(self.section),
            _ => {}
        }
        Ok(())
    }

    fn attribute(&self, tag: &BytesStart<'a>, name: &str) -> Result<Option<String>> {
        let found = tag.try_get_attribute(name).map_err(quick_xml::Error::from)?;
        let Some(attribute) = found else { return Ok(None) };
        let decoder = self.xml.decoder();
        let value = attribute.decoded_and_normalized_value(XmlVersion::Implicit1_0, decoder)?;
        Ok(Some(value.into_owned()))
    }

    fn number(&self, tag: &BytesStart<'a>, name: &'static str) -> Result<Option<usize>> {
        let text = self.attribute(tag, name)?;
        text.map(|text| number(text.trim().as_bytes(), name)).transpose()
    }

    fn file_header(&mut self, tag: &BytesStart<'a>) -> Result<()> {
        match self.attribute(tag, "type")?.unwrap_or_default() {
            kind if kind == "UnstructuredGrid" => {}
            kind if kind == "PolyData" => self.cells.is_surface = true,
            kind => {
                let advice = "save it as an unstructured grid (.vtu) or a surface (.vtp)";
                return Err(Refusal::unsupported("VTK XML file type", kind, advice));
            }
        }
        let big = self.attribute(tag, "byte_order")?.is_some_and(|order| order == "BigEndian");
        self.layout.encoding = if big { Encoding::Big } else { Encoding::Little };
        self.layout.wide_header = self.attribute(tag, "header_type")?.as_deref() == Some("UInt64");
        match self.attribute(tag, "compressor")?.unwrap_or_default() {
            none if none.is_empty() => {}
            zlib if zlib == "vtkZLibDataCompressor" => self.layout.zlib = true,
            other => {
                let advice = "save the file with zlib compression or none";
                return Err(Refusal::unsupported("compressor", other, advice));
            }
        }
        Ok(())
    }

    fn piece(&mut self, tag: &BytesStart<'a>) -> Result<()> {
        let points = self.number(tag, "NumberOfPoints")?;
        self.skips = points == Some(0);
        if self.skips && self.piece.is_some() {
            return Ok(());
        }
        if self.piece.is_some_and(|(points, _)| points > 0) {
            let advice = "merge the pieces into one, for example with \"Merge Blocks\"";
            return Err(Refusal::unsupported("number of pieces", "2 or more", advice));
        }
        let (counts, expected) = if self.cells.is_surface {
            let mut counts = [0; 4];
            for (count, (.., name)) in counts.iter_mut().zip(LISTS) {
                *count = self.number(tag, name)?.unwrap_or(0);
            }
            (Some(counts), "NumberOfPoints of the piece")
        } else {
            let count = self.number(tag, "NumberOfCells")?;
            (count.map(|n| [n, 0, 0, 0]), "NumberOfPoints and NumberOfCells of the piece")
        };
        self.piece = Some(points.zip(counts).ok_or_else(|| Refusal::missing(expected))?);
        Ok(())
    }

    /// The text of a DataArray without that of the information keys inside it.
    fn array_text(&mut self) -> Result<Vec<u8>> {
        let mut text = Vec::new();
        let mut depth = 0usize;
        loop {
            match self.event()? {
                Event::Text(part) if depth == 0 => text.extend_from_slice(&part),
                Event::Start(_) => depth += 1,
                Event::End(_) if depth == 0 => return Ok(text),
                Event::End(_) => depth -= 1,
                Event::Eof => return Err(Refusal::missing("the end of a DataArray")),
                _ => {}
            }
        }
    }

    fn array(&mut self, tag: &BytesStart<'a>, text: &[u8]) -> Result<()> {
        let kind_name = self.attribute(tag, "type")?.unwrap_or_default();
        let name = self.attribute(tag, "Name")?.unwrap_or_default();
        let components = self.number(tag, "NumberOfComponents")?.unwrap_or(1);
        let format = self.attribute(tag, "format")?.unwrap_or_else(|| "ascii".into());
        let offset = self.number(tag, "offset")?;
        let (points, cells) = self.piece.ok_or_else(|| Refusal::missing("a Piece element"))?;
        let all = cells.iter().fold(0, |all: usize, &count| all.saturating_add(count));
        // The length of the connectivity is known only from the offsets.
        let rows = match (self.section, name.as_str()) {
            (Section::Points | Section::PointData, _) => Some(points),
            (Section::Cells(_), "connectivity") => None,
            (Section::Cells(list), "offsets") => Some(cells[list]),
            (Section::Cells(_), "types") if !self.cells.is_surface => Some(all),
            // Faces of polyhedra; such cells are refused by their type.
            (Section::Cells(_), _) => return Ok(()),
            _ => Some(all),
        };
        let is_field = matches!(self.section, Section::PointData | Section::CellData);
        let kind = match NumberType::named(&kind_name.to_ascii_lowercase()) {
            Some(kind) => kind,
            None if is_field => {
                let [name, kind] = [&name, &kind_name].map(|text| text.escape_debug());
                self.grid.left_out.push(format!("array `{name}` of type {kind}"));
                return Ok(());
            }
            None => {
                let advice = "save the array as numbers, or without this array";
                return Err(Refusal::unsupported("array type", kind_name, advice));
            }
        };
        let expected = rows.map(|rows| rows.saturating_mul(components));
        let source = match (format.as_str(), offset, &self.appended) {
            ("ascii", ..) => None,
            ("binary", ..) => Some(Source::new(self.item, text, true, self.layout)),
            ("appended", Some(offset), Some(all)) => Some(all.starting(offset, self.layout)?),
            ("appended", ..) => {
                let expected = "an offset and an AppendedData element";
                return Err(Refusal::missing(expected));
            }
            (other, ..) => return Err(Refusal::expected("ascii, binary or appended", other)),
        };
        let values = match source {
            None => ascii(kind, text)?,
            Some(mut source) => read_array(&mut source, kind, expected)
                .inspect_err(|_| self.item = source.place())?,
        };
        let what = format_args!("numbers of array `{}`", name.escape_debug());
        Refusal::require_count(what, expected.unwrap_or(values.len()), values.len())?;
        self.put(name, Field { components, values })
    }

    /// Adds an array of the section.
    fn put(&mut self, name: String, field: Field) -> Result<()> {
        match self.section {
            Section::Points => {
                let advice = "write a single time step";
                if !self.grid.points.is_empty() {
                    return Err(Refusal::unsupported("a second array of points", name, advice));
                }
                Refusal::require_count("components of points", 3, field.components)?;
                self.grid.points = field.to_vectors().unwrap_or_default();
                self.grid.points_at = Place { byte: self.item, line: None };
            }
            Section::Cells(list) => {
                let other = || Refusal::expected("integers with one component", &name);
                let labels = field.as_labels().ok_or_else(other)?.to_vec();
                if self.lists[list].insert(name.clone(), (labels, self.item)).is_some() {
                    let advice = "write a single time step";
                    return Err(Refusal::unsupported("a second array of cells", name, advice));
                }
            }
            section => self.grid.add_field(section == Section::PointData, name, field)?,
        }
        Ok(())
    }

    /// A list of cells; `None` when it has none and no arrays.
    fn list(&mut self, list: usize, count: usize) -> Result<Option<CellList>> {
        let arrays = &mut self.lists[list];
        let (nodes, nodes_at) = arrays.remove("connectivity").unwrap_or_default();
        let Some((offsets, offsets_at)) = arrays.remove("offsets") else {
            let is_empty = count == 0 && self.cells.is_surface;
            return Refusal::require_part(is_empty, "an array named offsets").map(|()| None);
        };
        // The end of each cell, behind a 0.
        let ends = checked_ends(&[&[0], offsets.as_slice()].concat(), nodes.len());
        let ends = ends.inspect_err(|_| self.item = offsets_at)?;
        Ok(Some(CellList { ends, nodes, at: Place { byte: nodes_at, line: None } }))
    }

    fn finish(&mut self) -> Result<()> {
        let (points, counts) = self.piece.ok_or_else(|| Refusal::missing("a Piece element"))?;
        let has_points = self.grid.points.len() == points;
        Refusal::require_part(has_points, "a Points element with an array")?;
        let (types, _) = self.lists[0].remove("types").unwrap_or_default();
        self.grid.set_types(&types);
        for list in 0..if self.cells.is_surface { LISTS.len() } else { 1 } {
            self.cells.lists[list] = self.list(list, counts[list])?;
        }
        let has_types = self.cells.is_surface || self.grid.types.len() == counts[0];
        Refusal::require_part(has_types, "an array named types")?;
        std::mem::take(&mut self.cells).fill(&mut self.grid)
    }
}

fn section_named(name: &[u8]) -> Option<Section> {
    Some(match name {
        b"Points" => Section::Points,
        b"Cells" => Section::Cells(0),
        b"PointData" => Section::PointData,
        b"CellData" => Section::CellData,
        b"FieldData" => Section::Other,
        _ => Section::Cells(LISTS.iter().position(|list| list.2 == name)?),
    })
}
