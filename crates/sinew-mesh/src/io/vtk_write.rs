//! Writing legacy VTK files.

use super::cursor::{Encoding, Endian};
use super::sets::fields_with_sets;
use super::vtk;
use crate::{Field, FieldValues, Mesh, MeshError};
use percent_encoding::{AsciiSet, CONTROLS, utf8_percent_encode};
use std::collections::BTreeMap;

/// Characters of names that become `%20` and the like, as in VTK itself.
const SEPARATORS: AsciiSet = CONTROLS.add(b' ').add(b'"').add(b'%');

/// Text or binary numbers in a legacy VTK file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VtkEncoding {
    /// Decimal text that reads back to the same number.
    Ascii,
    /// Big-endian binary, bit for bit.
    Binary,
}

/// The mesh as a legacy VTK file of version 5.1 (VTK 9, ParaView 5.8 and later), whose integers
/// have 64 bits on every machine. Its sets are written as fields, see the crate's page.
///
/// # Errors
/// When the mesh breaks a rule of [`Mesh::check`] or a name cannot be written.
pub fn to_vtk<const N: usize>(mesh: &Mesh<N>, encoding: VtkEncoding) -> Result<Vec<u8>, MeshError> {
    to_legacy(mesh, encoding, Shape::Grid)
}

/// Kind of VTK data set, which names the cells of a mesh.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// Cells of any kind.
    Grid,
    /// Polygons.
    Surface,
}

pub(crate) fn to_legacy<const N: usize>(
    mesh: &Mesh<N>,
    encoding: VtkEncoding,
    shape: Shape,
) -> Result<Vec<u8>, MeshError> {
    mesh.check()?;
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len());
    let (point_fields, cell_fields) = fields_with_sets(mesh)?;
    let (name, encoding) = match encoding {
        VtkEncoding::Ascii => ("ASCII", Encoding::Text),
        VtkEncoding::Binary => ("BINARY", Encoding::Binary(Endian::Big)),
    };
    let (dataset, list) = match shape {
        Shape::Grid => ("UNSTRUCTURED_GRID", "CELLS"),
        Shape::Surface => ("POLYDATA", "POLYGONS"),
    };
    let mut file = Writer { bytes: Vec::new(), encoding };
    let magic = String::from_utf8_lossy(vtk::MAGIC);
    file.text(&format!("{magic} 5.1\nsinew mesh\n{name}\nDATASET {dataset}\n"));
    file.text(&format!("POINTS {nodes} double\n"));
    file.floats(mesh.points.as_flattened(), 3);
    file.text(&format!("{list} {} {}\nOFFSETS vtktypeint64\n", cells + 1, cells * N));
    file.integers((0..=cells).map(|cell| (cell * N) as i64), 1);
    file.text("CONNECTIVITY vtktypeint64\n");
    file.integers(mesh.cells.as_flattened().iter().map(|&node| node as i64), N);
    if shape == Shape::Grid {
        file.text(&format!("CELL_TYPES {cells}\n"));
        let types = std::iter::repeat_n(i32::from(Mesh::<N>::ELEMENT.vtk_type), cells);
        file.numbers(types, 1, i32::to_string, i32::to_be_bytes);
    }
    file.fields("POINT_DATA", nodes, &point_fields);
    file.fields("CELL_DATA", cells, &cell_fields);
    Ok(file.bytes)
}

struct Writer {
    bytes: Vec<u8>,
    encoding: Encoding,
}

impl Writer {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn fields(&mut self, section: &str, rows: usize, fields: &BTreeMap<String, Field>) {
        if fields.is_empty() {
            return;
        }
        self.text(&format!("{section} {rows}\nFIELD fields {}\n", fields.len()));
        for (name, field) in fields {
            let (name, width) = (utf8_percent_encode(name, &SEPARATORS), field.components);
            match &field.values {
                FieldValues::Float(values) => {
                    self.text(&format!("{name} {width} {rows} double\n"));
                    self.floats(values, width);
                }
                FieldValues::Integer(values) => {
                    self.text(&format!("{name} {width} {rows} vtktypeint64\n"));
                    self.integers(values.iter().copied(), width);
                }
            }
        }
    }

    fn floats(&mut self, values: &[f64], per_line: usize) {
        // Debug text is the shortest that reads back to the same number.
        let text = |value: &f64| format!("{value:?}");
        self.numbers(values.iter().copied(), per_line, text, f64::to_be_bytes);
    }

    fn integers(&mut self, values: impl Iterator<Item = i64>, per_line: usize) {
        self.numbers(values, per_line, i64::to_string, i64::to_be_bytes);
    }

    fn numbers<T: Copy, const N: usize>(
        &mut self,
        values: impl Iterator<Item = T>,
        per_line: usize,
        text: impl Fn(&T) -> String,
        bytes: impl Fn(T) -> [u8; N],
    ) {
        match self.encoding {
            Encoding::Text => {
                for (index, value) in values.enumerate() {
                    self.text(&text(&value));
                    self.text(if (index + 1) % per_line == 0 { "\n" } else { " " });
                }
            }
            Encoding::Binary(_) => {
                values.for_each(|value| self.bytes.extend_from_slice(&bytes(value)));
                self.text("\n");
            }
        }
    }
}
