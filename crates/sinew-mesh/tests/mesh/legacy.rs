//! Writers of formats that the crate only reads: legacy VTK of version 5.1 (VTK 9), VTP and STL.

use percent_encoding::{AsciiSet, CONTROLS, utf8_percent_encode};
use sinew_mesh::{Field, FieldValues, Mesh, TriangleMesh, to_vtu};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Characters of names that become `%20` and the like, as in VTK itself.
const SEPARATORS: AsciiSet = CONTROLS.add(b' ').add(b'"').add(b'%');

/// Text or big-endian binary numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VtkEncoding {
    Ascii,
    Binary,
}

/// Mesh as an unstructured grid, its sets as fields.
pub(crate) fn to_vtk<const N: usize>(mesh: &Mesh<N>, encoding: VtkEncoding) -> Vec<u8> {
    let kind = i32::from(Mesh::<N>::ELEMENT.vtk_type);
    written(mesh, encoding, "UNSTRUCTURED_GRID", "CELLS", Some(kind))
}

/// Surface as polygons (POLYDATA), its sets as fields.
pub(crate) fn to_vtk_surface(mesh: &TriangleMesh, encoding: VtkEncoding) -> Vec<u8> {
    written(mesh, encoding, "POLYDATA", "POLYGONS", None)
}

/// Surface as VTP: a VTU file whose cells are named polygons.
pub(crate) fn to_vtp(mesh: &TriangleMesh) -> Vec<u8> {
    let vtu = String::from_utf8(to_vtu(mesh).unwrap()).unwrap();
    let names = [
        ("UnstructuredGrid", "PolyData"),
        ("NumberOfCells", "NumberOfPolys"),
        ("Cells>", "Polys>"),
    ];
    names.iter().fold(vtu, |text, (grid, surface)| text.replace(grid, surface)).into_bytes()
}

/// Triangles of a surface as binary STL.
pub(crate) fn to_stl(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = format!("{:<80}", "triangles").into_bytes();
    bytes.extend((mesh.cells.len() as u32).to_le_bytes());
    for cell in 0..mesh.cells.len() {
        let rows = [[0.0; 3].into()].into_iter().chain(mesh.corners(cell));
        bytes.extend(rows.flat_map(<[f64; 3]>::from).flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Triangles of a surface as STL text.
pub(crate) fn to_stl_text(mesh: &TriangleMesh) -> Vec<u8> {
    let mut text = String::from("solid sinew\n");
    for cell in 0..mesh.cells.len() {
        let corners = mesh.corners(cell);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        let [x, y, z]: [f64; 3] = normal.into();
        let _ = writeln!(text, "facet normal {x:?} {y:?} {z:?}\nouter loop");
        for [x, y, z] in corners.map(<[f64; 3]>::from) {
            let _ = writeln!(text, "vertex {x:?} {y:?} {z:?}");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid sinew\n").into_bytes()
}

fn written<const N: usize>(
    mesh: &Mesh<N>,
    encoding: VtkEncoding,
    dataset: &str,
    list: &str,
    kind: Option<i32>,
) -> Vec<u8> {
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len());
    let [point_fields, cell_fields] = fields_with_sets(mesh);
    let name = if encoding == VtkEncoding::Ascii { "ASCII" } else { "BINARY" };
    let mut file = Writer { bytes: Vec::new(), encoding };
    file.text(&format!("# vtk DataFile Version 5.1\nsinew mesh\n{name}\nDATASET {dataset}\n"));
    file.text(&format!("POINTS {nodes} double\n"));
    file.floats(mesh.points.as_flattened(), 3);
    file.text(&format!("{list} {} {}\nOFFSETS vtktypeint64\n", cells + 1, cells * N));
    file.integers((0..=cells).map(|cell| (cell * N) as i64), 1);
    file.text("CONNECTIVITY vtktypeint64\n");
    file.integers(mesh.cells.as_flattened().iter().map(|&node| node as i64), N);
    if let Some(kind) = kind {
        file.text(&format!("CELL_TYPES {cells}\n"));
        file.numbers(std::iter::repeat_n(kind, cells), 1, i32::to_string, i32::to_be_bytes);
    }
    file.fields("POINT_DATA", nodes, &point_fields);
    file.fields("CELL_DATA", cells, &cell_fields);
    file.bytes
}

/// Fields of nodes and cells, with the sets by the names that the crate gives them in VTK files.
fn fields_with_sets<const N: usize>(mesh: &Mesh<N>) -> [BTreeMap<String, Field>; 2] {
    let [mut points, mut cells] = [mesh.point_fields.clone(), mesh.cell_fields.clone()];
    let marks = |rows: usize, members: &[(usize, i64)]| {
        let mut marks = vec![0; rows];
        members.iter().for_each(|&(index, bit)| marks[index] |= bit);
        Field::labels(marks)
    };
    let plain = |set: &[usize]| set.iter().map(|&index| (index, 1)).collect::<Vec<_>>();
    for (name, set) in &mesh.node_sets {
        points.insert(format!("node_set:{name}"), marks(mesh.points.len(), &plain(set)));
    }
    for (name, set) in &mesh.cell_sets {
        cells.insert(format!("cell_set:{name}"), marks(mesh.cells.len(), &plain(set)));
    }
    for (name, set) in &mesh.facet_sets {
        let bits: Vec<_> = set.iter().map(|facet| (facet.cell, 1 << facet.opposite)).collect();
        cells.insert(format!("facet_set:{name}"), marks(mesh.cells.len(), &bits));
    }
    [points, cells]
}

struct Writer {
    bytes: Vec<u8>,
    encoding: VtkEncoding,
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
            VtkEncoding::Ascii => {
                for (index, value) in values.enumerate() {
                    self.text(&text(&value));
                    self.text(if (index + 1) % per_line == 0 { "\n" } else { " " });
                }
            }
            VtkEncoding::Binary => {
                values.for_each(|value| self.bytes.extend_from_slice(&bytes(value)));
                self.text("\n");
            }
        }
    }
}
