//! Hand-written files: rare parts of the formats, and errors that say where, why and what to do.

use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::{Compression, write::ZlibEncoder};
use sinew_mesh::{AnyMesh, Facet, ReadReport, TetMesh, parse, parse_mesh};
use std::io::Write;

const CORNERS: &str = "0 0 0  1 0 0  0 1 0  0 0 1  1 1 1";

fn vtk(cells: &str, types: &str, data: &str) -> String {
    let count = cells.lines().count();
    let size = cells.split_whitespace().count();
    format!(
        "# vtk DataFile Version 2.0\ntest\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 int\n{CORNERS}\n\
         CELLS {count} {size}\n{cells}\nCELL_TYPES {count}\n{types}\n{data}"
    )
}

fn tets(text: &str) -> (TetMesh, ReadReport) {
    parse_mesh::<4>("test", text.as_bytes()).unwrap()
}

#[track_caller]
fn assert_refused(text: &str, parts: &[&str]) {
    let message = parse_mesh::<4>("test", text.as_bytes()).unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

#[test]
fn attributes_of_legacy_vtk() {
    let data = "POINT_DATA 5\n\
        SCALARS plain float\n1 2 3 4 5\n\
        SCALARS two int 2\nLOOKUP_TABLE mine\n0 1 2 3 4 5 6 7 8 9\n\
        LOOKUP_TABLE mine 2\n0 0 0 1 1 1 1 1\n\
        COLOR_SCALARS rgb 3\n0 0 0 .5 .5 .5 1 1 1 0 0 0 1 0 0\n\
        NORMALS n%20n double\n1 0 0 1 0 0 1 0 0 1 0 0 1 0 0\n\
        TEXTURE_COORDINATES uv 2 float\n0 1 2 3 4 5 6 7 8 9\n\
        METADATA\nINFORMATION 1\nNAME a LOCATION b\nDATA 1\n\n\
        CELL_DATA 1\nTENSORS t double\n1 2 3\n4 5 6\n7 8 9\n";
    let (mesh, _) = tets(&vtk("4 0 1 2 3", "10", data));
    let components = |name: &str| mesh.point_fields[name].components;
    assert_eq!(["plain", "two", "rgb", "n n", "uv"].map(components), [1, 2, 3, 3, 2]);
    let tensor = mesh.cell_fields["t"].to_vectors::<9>().unwrap();
    assert_eq!(tensor[0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
}

#[test]
fn other_cells_are_sorted_and_counted() {
    // A negative tetrahedron, its side, a triangle that is not a side, a line and two points.
    let cells = "4 0 2 1 3\n3 0 2 1\n3 1 2 4\n2 0 1\n2 0 3";
    let data = "CELL_DATA 5\nSCALARS part int 1\nLOOKUP_TABLE default\n5 8 8 1 1";
    let (mesh, report) = tets(&vtk(cells, "10 5 5 3 2", data));
    let expected = ReadReport {
        repaired_cells: 1,
        matched_facets: 1,
        unmatched_facets: 1,
        incomplete_sets: [("part:8".to_string(), 1)].into(),
        dropped_cells: 2,
        unused_nodes: 1,
        ..ReadReport::default()
    };
    assert_eq!(report, expected);
    assert_eq!(mesh.facet_sets["part:8"], [Facet { cell: 0, opposite: 3 }]);
    assert_eq!(mesh.cell_fields["part"].to_f64(), [5.0].as_slice());
    assert_eq!(mesh.points.len(), 4);
}

#[test]
fn triangle_files() {
    let text = vtk("3 0 2 1\n2 0 1", "5 3", "");
    let (mesh, report) = parse_mesh::<3>("test", text.as_bytes()).unwrap();
    assert_eq!((mesh.cells.len(), report.matched_facets), (1, 1));
    // Points of no cell outside of its plane do not make a surface in space of it.
    assert_eq!((mesh.cells.as_slice(), report.unused_nodes), ([[0, 1, 2]].as_slice(), 2));
    assert_eq!(mesh.facet_sets["facets"], [Facet { cell: 0, opposite: 2 }]);
    assert!(matches!(parse("test", text.as_bytes()).unwrap().0, AnyMesh::Triangles(_)));
    let solid = vtk("4 0 1 2 3", "10", "");
    let message = parse_mesh::<3>("test", solid.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("tetrahedron") && message.contains("extract"), "{message}");
}

#[test]
fn bad_cells_are_named() {
    assert_refused(&vtk("4 0 1 2 5", "10", ""), &["test, line 8", "cell 0", "node 5", "0 to 4"]);
    assert_refused(&vtk("4 0 1 2 -1", "10", ""), &["node -1"]);
    assert_refused(&vtk("4 0 1 2 1", "10", ""), &["cell 0 names node 1 twice", "tetrahedra"]);
    assert_refused(
        &vtk("4 0 1 2 3\n4 0 1 2 3", "10 9", ""),
        &["cell 1 is a quadrilateral", "split"],
    );
    assert_refused(
        &vtk("10 0 1 2 3 4 0 1 2 3 4", "24", ""),
        &["quadratic tetrahedron", "first-order"],
    );
    assert_refused(&vtk("3 0 1 2", "10", ""), &["nodes of cell 0", "expected 4", "found 3"]);
    assert_refused(&vtk("4 0 1 2 3", "300", ""), &["cell of another type"]);
    assert_refused(&vtk("2 0 1", "3", ""), &["no tetrahedra"]);
    assert_refused(&vtk("9 0 1 2 3", "10", ""), &["number of nodes of a cell is 9", "0..=4"]);
}

#[test]
fn bad_numbers_are_placed() {
    let good = vtk("4 0 1 2 3", "10", "POINT_DATA 5\nVECTORS u double\n");
    assert_refused(&good, &["values of a field: only 0 of 29 bytes", "cut off"]);
    let holed = vtk("4 0 1 2 3", "10", "").replace("5 int", "5 float").replace("1 1 1", "1 nan 1");
    assert_refused(&holed, &["line 6", "node 4 lies at", "finite"]);
    assert_refused(&good.replace("1 1 1", "1 x 1"), &["line 6", "`x`"]);
    assert_refused(
        &good.replace("POINTS 5", "POINTS 99999999999999"),
        &["coordinates: only", "left"],
    );
    assert_refused(
        &good.replace("POINT_DATA 5", "POINT_DATA 6"),
        &["rows of POINT_DATA", "expected 5"],
    );
    assert_refused(&good.replace("5 int", "5 bit"), &["`bit`", "double"]);
    assert_refused(&good.replace("VECTORS", "VEKTORS"), &["keyword", "VEKTORS", "line 12"]);
    assert_refused(&good.replace("ASCII", "ASCI"), &["line 3", "ASCII or BINARY"]);
    assert_refused(
        &good.replace("UNSTRUCTURED_GRID", "STRUCTURED_GRID"),
        &["STRUCTURED_GRID", "unstructured grid"],
    );
    assert_refused("solid ball", &["neither"]);
}

#[test]
fn a_place_is_the_line_and_the_byte_of_the_word() {
    let text = vtk("4 0 1 2 3", "10", "").replace("1 1 1", "1 x 1");
    // Blanks before the word and lines that begin with some.
    let text = text.replace("ASCII\n", "  ASCII \n").replace(" x ", "   x ");
    let place = format!("test, line 6 (byte {}): expected coordinates", text.find('x').unwrap());
    assert_refused(&text, &[&place, "`x`"]);
    // Nothing of a count that overflows is allocated.
    let most = usize::MAX.to_string();
    let text = text.replace("POINTS 5", &format!("POINTS {most}"));
    assert_refused(&text, &["test, line 5", "coordinates: only", "left"]);
}

/// A VTU file whose connectivity is the given zlib array.
fn vtu_with_connectivity(array: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkZLibDataCompressor\">\n\
         <UnstructuredGrid><Piece NumberOfPoints=\"5\" NumberOfCells=\"1\">\n\
         <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">{CORNERS}</DataArray></Points>\n\
         <Cells><DataArray type=\"UInt8\" Name=\"connectivity\" format=\"binary\">{array}</DataArray>\n\
         <DataArray type=\"Int8\" Name=\"offsets\">4</DataArray>\n\
         <DataArray type=\"Int8\" Name=\"types\">10</DataArray></Cells>\n\
         </Piece></UnstructuredGrid></VTKFile>"
    )
}

/// One zlib block with the size it declares.
fn zlib(content: &[u8], declared: u32) -> String {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(content).unwrap();
    let block = encoder.finish().unwrap();
    let header = [1, declared, 0, block.len() as u32].map(u32::to_le_bytes).concat();
    STANDARD.encode(header) + &STANDARD.encode(block)
}

#[test]
fn zlib_blocks_keep_to_their_size() {
    let (mesh, _) = tets(&vtu_with_connectivity(&zlib(&[0, 1, 2, 3], 4)));
    assert_eq!(mesh.cells, [[0, 1, 2, 3]]);
    let bomb = vec![0; 10 << 20];
    assert_refused(&vtu_with_connectivity(&zlib(&bomb, 4)), &["zlib block 0", "4 bytes"]);
    assert_refused(&vtu_with_connectivity(&zlib(&[0; 4], u32::MAX)), &["zlib block 0"]);
    assert_refused(&vtu_with_connectivity("AAAA"), &["sizes in the header"]);
    assert_refused(&vtu_with_connectivity("@@@@@@@@@@@@@@@@@@@@"), &["base64", "@@@@"]);
}

#[test]
fn broken_vtu_files() {
    let good = vtu_with_connectivity(&zlib(&[0, 1, 2, 3], 4));
    assert_refused(&good.replace("Name=\"types\"", "Name=\"kinds\""), &["an array named types"]);
    assert_refused(&good.replace(">4<", ">3<"), &["offset of a cell is 3"]);
    assert_refused(&good.replace("NumberOfPoints=\"5\"", "NumberOfPoints=\"6\""), &["18", "15"]);
    assert_refused(&good.replace("\"UnstructuredGrid\"", "\"ImageData\""), &["ImageData", ".vtu"]);
    assert_refused(&good.replace("Float32", "String"), &["String", "numbers"]);
    assert_refused(&good.replace("format=\"binary\"", "format=\"appended\""), &["AppendedData"]);
    assert_refused(&good.replace("<Piece", "<Peace"), &["a Piece element"]);
    assert_refused(&good[..good.len() / 2], &["test, byte"]);
    let two = good.replace("</Piece>", "</Piece><Piece NumberOfPoints=\"1\" NumberOfCells=\"0\"/>");
    assert_refused(&two, &["pieces", "merge"]);
    let cut = good.replace("</VTKFile>", "<AppendedData encoding=\"raw\">");
    let place = format!("test, byte {}:", cut.find("<AppendedData").unwrap());
    assert_refused(&cut, &[&place, "the underscore before appended data"]);
}

#[test]
fn broken_msh_files() {
    let good = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n9 0 0 1\n\
        $EndNodes\n$Elements\n1\n1 4 2 7 1 1 2 3 9\n$EndElements\n";
    assert_eq!(tets(good).0.cell_sets["physical_7"], [0]);
    assert_refused(&good.replace("2.2", "1.0"), &["`1.0`", "msh41"]);
    assert_refused(&good.replace("2 3 9", "2 3 8"), &["tag of a node in $Nodes", "`8`", "line 13"]);
    assert_refused(&good.replace("3 0 1 0", "2 0 1 0"), &["not used yet", "`2`"]);
    assert_refused(&good.replace("$EndNodes", "$EndNods"), &["$End"]);
    assert_refused(&good.replace("1 4 2", "1 99 2"), &["gmsh element type", "first-order"]);
    assert_refused(&good.replace("\n4\n", "\n9999999999\n"), &["the tag of a node", "$EndNodes"]);
    assert_refused(&good[..good.find("$Elements").unwrap()], &["an $Elements section"]);
}

/// The unit cube as one hexahedron with its bottom, two cells that the tests change.
fn cube(nodes: &str, more: &str, types: &str) -> String {
    let count = 1 + more.lines().count();
    let size = format!("{nodes} {more}").split_whitespace().count();
    format!(
        "# vtk DataFile Version 3.0\ncube\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n\
         0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\nCELLS {count} {size}\n{nodes}\n{more}\n\
         CELL_TYPES {count}\n{types}\n"
    )
}

#[test]
fn hexahedra_of_legacy_vtk() {
    let upright = cube("8 0 1 2 3 4 5 6 7", "4 2 1 0 3", "12 9");
    let (mesh, report) = parse_mesh::<8>("test", upright.as_bytes()).unwrap();
    assert_eq!((report.matched_facets, report.repaired_cells), (1, 0));
    assert!((mesh.cell_volume(0) - 1.0).abs() < 1e-15);
    assert_eq!(mesh.facet_sets["facets"], [Facet { cell: 0, opposite: 4 }]);
    assert!(mesh.nodes_of_facet(mesh.facet_sets["facets"][0]).eq([0, 3, 2, 1]));

    let inside_out = cube("8 4 5 6 7 0 1 2 3", "4 2 1 0 3", "12 9");
    let (repaired, report) = parse_mesh::<8>("test", inside_out.as_bytes()).unwrap();
    assert_eq!((&repaired, report.repaired_cells), (&mesh, 1));

    let twisted = cube("8 0 1 3 2 4 5 7 6", "4 2 1 0 3", "12 9");
    let message = parse_mesh::<8>("test", twisted.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("folded over") && message.contains("order of VTK"), "{message}");

    let mixed = cube("8 0 1 2 3 4 5 6 7", "4 0 1 2 4", "12 10");
    let message = parse_mesh::<8>("test", mixed.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("cell 1 is a tetrahedron, but the mesh wants hexahedra"), "{message}");
    let message = parse_mesh::<4>("test", upright.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("split such cells into simplices"), "{message}");
}

#[test]
fn quadratic_cells_of_msh() {
    // gmsh numbers the last two middle nodes the other way round than VTK.
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n\
        5 .5 0 0\n6 .5 .5 0\n7 0 .5 0\n8 0 0 .5\n9 0 .5 .5\n10 .5 0 .5\n$EndNodes\n$Elements\n2\n\
        1 9 2 5 1 1 3 2 7 6 5\n2 11 2 7 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
    let (mesh, report) = parse_mesh::<10>("test", text.as_bytes()).unwrap();
    assert_eq!(mesh.cells, [[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]);
    assert_eq!(mesh.facet_sets["physical_5"], [Facet { cell: 0, opposite: 3 }]);
    assert_eq!((report.matched_facets, report.repaired_cells), (1, 0));
    assert!((mesh.cell_volume(0) - 1.0 / 6.0).abs() < 1e-16);

    let folded = text.replace("5 .5 0 0", "5 1.5 0 0");
    let message = parse_mesh::<10>("test", folded.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("cell 0 is folded over at its node"), "{message}");

    let linear = vtk("4 0 1 2 3", "10", "");
    let message = parse_mesh::<10>("test", linear.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("make it quadratic"), "{message}");
}
