//! Writing VTU files and PVD series.

use super::cursor::save;
use super::sets::fields_with_sets;
use crate::{Field, FieldValues, Mesh, MeshError, Refusal};
use base64::{Engine, engine::general_purpose::STANDARD};
use quick_xml::escape::escape;
use std::collections::BTreeMap;
use std::path::Path;

/// Point field of displacements, which programs are told to move the mesh by.
pub const DISPLACEMENT: &str = "displacement";

/// The mesh as a VTU file with inline base64 arrays, bit for bit. Its sets are written as
/// fields, see the crate's page. A point field [`DISPLACEMENT`] is marked as the vectors of the nodes.
///
/// # Errors
/// When the mesh breaks a rule of [`Mesh::check`] or a name cannot be written.
pub fn to_vtu<const N: usize>(mesh: &Mesh<N>) -> Result<Vec<u8>, MeshError> {
    to_xml(mesh, &[])
}

/// The mesh as a VTU file, with numbers that belong to the whole of it: VTK's field data.
pub(crate) fn to_xml<const N: usize>(
    mesh: &Mesh<N>,
    numbers: &[(String, f64)],
) -> Result<Vec<u8>, MeshError> {
    mesh.check()?;
    let (point_fields, cell_fields) = fields_with_sets(mesh)?;
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len());
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
    );
    field_data(&mut xml, numbers)?;
    xml += &format!("<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{cells}\">\n<Points>\n");
    array_of(&mut xml, "Points", &Field::vectors(&mesh.points));
    xml += "</Points>\n<Cells>\n";
    let connectivity = mesh.cells.as_flattened().iter().map(|&node| node as i64);
    array_of(&mut xml, "connectivity", &Field::labels(connectivity.collect()));
    let offsets = (1..=cells).map(|cell| (cell * N) as i64);
    array_of(&mut xml, "offsets", &Field::labels(offsets.collect()));
    array(&mut xml, "UInt8", "types", 1, &vec![Mesh::<N>::ELEMENT.vtk_type; cells]);
    xml += "</Cells>\n";
    fields(&mut xml, "PointData", &point_fields);
    fields(&mut xml, "CellData", &cell_fields);
    xml += "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    Ok(xml.into_bytes())
}

/// Writes a PVD file: a series of mesh files over time, which ParaView plays. Each entry is a time
/// and the path of a file relative to the PVD file.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let series = [(0.0, "beam_0.vtu".as_ref()), (0.5, "beam_1.vtu".as_ref())];
/// let path = folder.path().join("beam.pvd");
/// sinew_mesh::write_pvd(&path, &series)?;
/// assert!(std::fs::read_to_string(path)?.contains("timestep=\"0.5\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When a path is not Unicode or has control characters, and when the file cannot be written.
pub fn write_pvd(path: impl AsRef<Path>, series: &[(f64, &Path)]) -> Result<(), MeshError> {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
    );
    for (time, file) in series {
        let name = file.to_str().filter(|name| !name.chars().any(char::is_control));
        let lossy = || Refusal::name(&file.to_string_lossy());
        let name = escape(name.ok_or_else(lossy)?);
        xml += &format!("<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}\"/>\n");
    }
    xml += "</Collection>\n</VTKFile>\n";
    save(path.as_ref(), xml.as_bytes())
}

fn field_data(xml: &mut String, numbers: &[(String, f64)]) -> Result<(), MeshError> {
    if numbers.is_empty() {
        return Ok(());
    }
    *xml += "<FieldData>\n";
    for (name, number) in numbers {
        if name.is_empty() || name.chars().any(char::is_control) {
            return Err(Refusal::name(name).into());
        }
        let name = escape(name);
        let kind = "type=\"Float64\" NumberOfTuples=\"1\" format=\"ascii\"";
        *xml += &format!("<DataArray {kind} Name=\"{name}\">{number:?}</DataArray>\n");
    }
    *xml += "</FieldData>\n";
    Ok(())
}

fn fields(xml: &mut String, section: &str, fields: &BTreeMap<String, Field>) {
    let moved =
        section == "PointData" && fields.get(DISPLACEMENT).is_some_and(|u| u.components == 3);
    let vectors = if moved { format!(" Vectors=\"{DISPLACEMENT}\"") } else { String::new() };
    *xml += &format!("<{section}{vectors}>\n");
    fields.iter().for_each(|(name, field)| array_of(xml, name, field));
    *xml += &format!("</{section}>\n");
}

fn array_of(xml: &mut String, name: &str, field: &Field) {
    let (kind, bytes): (_, Vec<u8>) = match &field.values {
        FieldValues::Float(all) => ("Float64", all.iter().flat_map(|x| x.to_le_bytes()).collect()),
        FieldValues::Integer(all) => ("Int64", all.iter().flat_map(|x| x.to_le_bytes()).collect()),
    };
    array(xml, kind, name, field.components, &bytes);
}

/// The size of the array in bytes and the array, in one base64 text.
fn array(xml: &mut String, kind: &str, name: &str, components: usize, bytes: &[u8]) {
    let name = escape(name);
    let with_size = [(bytes.len() as u64).to_le_bytes().as_slice(), bytes].concat();
    *xml += &format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"binary\"");
    // One component is the default; programs take its mention for an array of rows.
    if components != 1 {
        *xml += &format!(" NumberOfComponents=\"{components}\"");
    }
    *xml += ">\n";
    STANDARD.encode_string(with_size, xml);
    *xml += "\n</DataArray>\n";
}
