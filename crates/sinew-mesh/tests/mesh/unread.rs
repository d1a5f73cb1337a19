//! Content of files that is nothing of a mesh, or a mesh in words of its own: it stops no reader, and what is left out is told.

use sinew_mesh::{AnyMesh, Field, ReadReport, parse};

fn read(text: impl AsRef<[u8]>) -> (AnyMesh, ReadReport) {
    parse("test", text.as_ref()).unwrap()
}

/// Two tetrahedra on one triangle, whose sides are in two groups, in MSH 2.2 with more sections.
fn msh2(nodes: &str, more: &str) -> String {
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"held\"\n3 2 \"wall\"\n$EndPhysicalNames\n{nodes}\
         $Elements\n3\n1 2 2 1 1 1 2 3\n2 4 2 2 1 1 2 3 4\n3 4 2 2 1 1 3 2 5\n$EndElements\n{more}"
    )
}

const NODES: &str = "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n";

fn view(rows: &str) -> String {
    let count = rows.lines().count();
    format!("$ElementData\n1\n\"k\"\n1\n0.0\n3\n0\n1\n{count}\n{rows}$EndElementData\n")
}

#[test]
fn views_of_gmsh_are_of_cells_and_those_of_the_boundary_are_told() {
    let (AnyMesh::Tetrahedra(mesh), report) = read(msh2(NODES, &view("2 0.5\n3 0.25\n"))) else {
        panic!("tetrahedra")
    };
    assert_eq!(*mesh.cell_fields["k"].to_f64(), [0.5, 0.25]);
    assert_eq!(report, ReadReport { matched_facets: 1, ..ReadReport::default() });
    let (mesh, report) = read(msh2(NODES, &view("1 7\n")));
    assert!(mesh.cell_fields().is_empty());
    assert_eq!(report.changes(), ["element data `k` of the boundary left out"]);
    let error = parse("test", msh2(NODES, &view("3 7\n")).as_bytes()).unwrap_err().to_string();
    assert!(error.contains("rows of `k`: expected 2 of them, found 1"), "{error}");
}

#[test]
fn parametric_nodes_of_gmsh_have_parameters_on_curves_and_surfaces_only() {
    let parametric = "$ParametricNodes\n5\n1 0 0 0 0 1\n2 1 0 0 1 4 0.5\n3 0 1 0 2 4 0.5 0.25\n4 0 0 1 3 1\n5 0 0 -1 3 1\n\
                      $EndParametricNodes\n";
    assert_eq!(read(msh2(parametric, "")).0, read(msh2(NODES, "")).0);
}

#[test]
fn parts_of_a_partitioned_mesh_are_in_the_groups_of_the_whole() {
    let file = |entities: &str| {
        format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"held\"\n3 2 \"wall\"\n$EndPhysicalNames\n{entities}\
             $Nodes\n1 5 1 5\n3 4 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 -1\n$EndNodes\n\
             $Elements\n3 3 1 3\n2 6 2 1\n1 1 2 3\n3 4 4 1\n2 1 2 3 4\n3 5 4 1\n3 1 3 2 5\n$EndElements\n"
        )
    };
    let whole = "$Entities\n0 0 1 2\n6 0 0 0 1 1 0 1 1 0\n4 0 0 0 1 1 1 1 2 0\n5 0 0 -1 1 1 0 1 2 0\n$EndEntities\n";
    // Two parts and a ghost; bounds follow the parent and the list of parts.
    let parts = "$PartitionedEntities\n2\n1\n7 1\n0 0 1 2\n6 2 1 2 1 2 0 0 0 1 1 0 1 1 0\n4 3 1 1 1 0 0 0 1 1 1 1 2 1 6\n\
                 5 3 1 1 2 0 0 -1 1 1 0 1 2 1 6\n$EndPartitionedEntities\n";
    let (mesh, report) = read(file(parts));
    assert_eq!(
        (&mesh, &report),
        (&read(file(whole)).0, &ReadReport { matched_facets: 1, ..ReadReport::default() })
    );
    let AnyMesh::Tetrahedra(mesh) = mesh else { panic!("tetrahedra") };
    assert_eq!(mesh.cell_sets["wall"], [0, 1]);
}

/// A legacy VTK file of one cell with its points and more sections, in text.
fn vtk(points: &[[f64; 3]], kind: u8, more: &str) -> String {
    let rows: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let (count, nodes) = (points.len(), (0..points.len()).map(|node| format!(" {node}")));
    format!(
        "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {count} double\n{rows}CELLS 1 {}\n{count}{}\n\
         CELL_TYPES 1\n{kind}\n{more}",
        count + 1,
        nodes.collect::<String>()
    )
}

const TETRAHEDRON: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn lagrange_cells_and_voxels_are_the_cells_that_they_equal() {
    let middle = |a: usize, b: usize| -> [f64; 3] {
        std::array::from_fn(|i| (TETRAHEDRON[a][i] + TETRAHEDRON[b][i]) / 2.0)
    };
    let edges = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)].map(|(a, b)| middle(a, b));
    let ten = [&TETRAHEDRON[..], &edges].concat();
    let six = [&TETRAHEDRON[..3], &edges[..3]].concat();
    let cube = [0, 1, 3, 2, 4, 5, 7, 6]
        .map(|corner| [0, 1, 2].map(|axis| f64::from((corner as u8) >> axis & 1)));
    let mut voxel = cube;
    voxel.chunks_exact_mut(4).for_each(|layer| layer.swap(2, 3));
    for (points, lagrange, usual) in [
        (&TETRAHEDRON[..], 71, 10),
        (&TETRAHEDRON[..3], 69, 5),
        (&ten, 71, 24),
        (&six, 69, 22),
        (&cube, 72, 12),
    ] {
        assert_eq!(read(vtk(points, lagrange, "")), read(vtk(points, usual, "")), "{lagrange}");
    }
    let (AnyMesh::Hexahedra(mesh), report) = read(vtk(&voxel, 11, "")) else { panic!("hexahedra") };
    assert_eq!((mesh.cells[0], report.repaired_cells), ([0, 1, 3, 2, 4, 5, 7, 6], 0));
    let error = parse("test", vtk(&cube[..7], 71, "").as_bytes()).unwrap_err().to_string();
    assert!(error.contains("cell 0 is a Lagrange tetrahedron"), "{error}");
}

#[test]
fn text_and_bits_beside_numbers_are_left_out() {
    let text = "FIELD FieldData 1\nwriter 1 2 string\nby%20hand\n1 2 3\nCELL_DATA 1\nFIELD f 3\nlabel 1 1 string\nleft\n\
                mark 2 1 bit\n0 1\nk 1 1 int\n4\nPOINT_DATA 4\nSCALARS on bit\nLOOKUP_TABLE default\n1 0 1 0\n";
    let (mesh, report) = read(vtk(&TETRAHEDRON, 10, text));
    assert_eq!(mesh.cell_fields()["k"], Field::labels(vec![4]));
    let left_out =
        ["label", "mark", "on"].map(|name| format!("array `{name}` of text or bits left out"));
    assert_eq!(report.changes(), left_out);

    // In binary: strings of 1 and 70 letters (lengths in one and two bytes), nine bits.
    let mut binary =
        b"# vtk DataFile Version 3.0\ntest\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
            .to_vec();
    binary.extend(TETRAHEDRON.as_flattened().iter().flat_map(|x| x.to_be_bytes()));
    binary.extend(b"\nCELLS 1 5\n");
    binary.extend([4, 0, 1, 2, 3].iter().flat_map(|x: &i32| x.to_be_bytes()));
    binary.extend(
        b"\nCELL_TYPES 1\n\0\0\0\x0a\nCELL_DATA 1\nFIELD f 3\nlabel 2 1 string\n\xc1a\x80\x46",
    );
    binary.extend([b'b'; 70]);
    binary.extend(b"\nmark 9 1 bit\n\xff\x80\nk 1 1 int\n\0\0\0\x04\n");
    let (same, report) = read(&binary);
    assert_eq!(same.cell_fields()["k"], mesh.cell_fields()["k"]);
    assert_eq!(report.changes(), left_out[..2]);
}

#[test]
fn arrays_of_another_type_in_xml_are_left_out() {
    let file = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\"><Points>\
                <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Cells>\
                <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\
                <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray>\
                <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells><CellData>\
                <DataArray type=\"String\" Name=\"label\" format=\"ascii\">97 0</DataArray>\
                <DataArray type=\"Int32\" Name=\"k\" format=\"ascii\">4</DataArray></CellData></Piece></UnstructuredGrid></VTKFile>";
    let (mesh, report) = read(file);
    assert_eq!(mesh.cell_fields()["k"], Field::labels(vec![4]));
    assert_eq!(report.changes(), ["array `label` of type String left out"]);
    let error = parse("test", file.replace("UInt8", "String").as_bytes()).unwrap_err().to_string();
    assert!(error.contains("array type `String`"), "{error}");
}

const PART: &str = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=wall\n8, 1, 2, 3, 4\n\
                    *NSET, NSET=held\n1, 2\n";

#[test]
fn a_mesh_may_stand_in_its_instance() {
    let sets = "*NSET, NSET=top, INSTANCE=I\n4\n*END ASSEMBLY\n";
    let in_part = format!(
        "*PART, NAME=P\n{PART}*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n0, 0, 5\n*END INSTANCE\n{sets}"
    );
    let in_instance = format!(
        "*PART, NAME=P\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n0, 0, 5\n{PART}*END INSTANCE\n{sets}"
    );
    assert_eq!(read(&in_part), read(in_instance));
    let (mesh, _) = read(in_part);
    assert_eq!((mesh.points()[0], &mesh.node_sets()["top"]), ([0.0, 0.0, 5.0], &vec![3]));
}

#[test]
fn nodes_and_elements_of_the_assembly_and_what_is_no_cell_are_left_out() {
    let own = "*NODE, NSET=points\n1, 9, 9, 9\n*ELEMENT, TYPE=MASS, ELSET=heavy\n1, 1\n*ELEMENT, TYPE=CONN3D2\n2, I.1, 1\n\
               *NSET, NSET=RP\n1\n*NSET, NSET=both\nRP, I.held\n*ELSET, ELSET=m, GENERATE\n1, 1, 1\n";
    let file = |own: &str| {
        format!(
            "*PART, NAME=P\n{PART}*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n{own}*END ASSEMBLY\n"
        )
    };
    let (mesh, report) = read(file(own));
    // Their first node has the number of the part's.
    let sets = mesh.node_sets();
    assert_eq!(
        (sets["both"].as_slice(), sets["held"].as_slice()),
        ([0, 1].as_slice(), [0, 1].as_slice())
    );
    assert!(sets["RP"].is_empty() && sets["points"].is_empty());
    let told = [
        "1 node of the assembly left out",
        "1 element of the assembly left out",
        "1 element of the assembly left out",
    ];
    assert_eq!(report.changes(), told);
    // Masses and springs of a flat file.
    let (flat, report) = read(format!(
        "{PART}*ELEMENT, TYPE=MASS, ELSET=m\n9, 4\n*ELEMENT, TYPE=SPRINGA\n10, 1, 4\n"
    ));
    assert_eq!((flat.cell_count(), flat.points().len()), (1, 4));
    assert_eq!(report.changes(), ["2 point, line or collapsed elements left out"]);
}

#[test]
fn formats_that_are_not_read_are_named_with_the_way_out() {
    let xml = "<?xml version=\"1.0\"?>\n";
    for (text, format) in [
        (format!("{xml}<Xdmf Version=\"3.0\"></Xdmf>"), "XDMF"),
        ("<Xdmf></Xdmf>".into(), "XDMF"),
        (format!("{xml}<febio_spec version=\"4.0\"></febio_spec>"), "FEBio"),
        ("NRRD0004\ntype: short\n".into(), "image"),
        ("FORMAT\ntype: ensight gold\nGEOMETRY\n".into(), "EnSight"),
        ("$NOD\n1\n1 0 0 0\n$ENDNOD\n".into(), "gmsh MSH 1"),
        (format!("{xml}<dolfin></dolfin>"), "DOLFIN XML"),
        ("$ Nastran\nGRID    1       0       0.0     0.0     0.0\n".into(), "Nastran"),
        ("SOL 101\nCEND\nBEGIN BULK\n".into(), "Nastran"),
        ("$# LS-DYNA\n*KEYWORD\n*NODE\n".into(), "LS-DYNA"),
        ("*KEYWORD\n*NODE\n".into(), "LS-DYNA"),
        ("MeshVersionFormatted 2\nDimension 3\n".into(), "MEDIT"),
        ("ply\nformat ascii 1.0\n".into(), "PLY"),
        ("mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0\n".into(), "OBJ"),
        ("# wavefront obj file written by the visualization toolkit\n\nv 0 0 0\n".into(), "OBJ"),
        ("mesh3d\ndimension\n3\nvolumeelements\n0\n".into(), "Netgen"),
    ] {
        let error = parse("test", text.as_bytes()).unwrap_err().to_string();
        let start = format!("test, byte 0: the format `{format}");
        assert!(error.starts_with(&start) && error.contains("cannot be read; "), "{error}");
    }
    let error = parse("test", b"<?xml version=\"1.0\"?>\n<GIFTI></GIFTI>").unwrap_err().to_string();
    assert!(error.starts_with("test, byte 0: this is neither legacy VTK, VTU"), "{error}");
}

#[test]
fn of_several_time_steps_none_is_taken() {
    let twice = msh2(NODES, &(view("2 0.5\n3 0.25\n") + &view("2 5\n3 2\n")));
    let refused = |text: &str| parse("test", text.as_bytes()).unwrap_err().to_string();
    let said = refused(&twice);
    assert!(
        said.contains("a second array of the name `k`") && said.contains("time step"),
        "{said}"
    );

    let array = |name: &str, kind: &str, width: usize, text: &str| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\">{text}</DataArray>"
        )
    };
    let points = array("Points", "Float64", 3, "0 0 0 1 0 0 0 1 0 0 0 1");
    let nodes = array("connectivity", "Int64", 1, "0 1 2 3");
    let cells =
        nodes.clone() + &array("offsets", "Int64", 1, "4") + &array("types", "UInt8", 1, "10");
    let field = array("k", "Float64", 1, "0.5");
    let file = |parts: [&str; 3], pieces: [&str; 2]| {
        format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{}<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points>{}</Points>\
             <Cells>{}</Cells><CellData>{}</CellData></Piece>{}</UnstructuredGrid></VTKFile>",
            pieces[0], parts[0], parts[1], parts[2], pieces[1]
        )
    };
    let (whole, _) = read(file([&points, &cells, &field], [""; 2]));
    // VTK writes an array that is active as scalars and as vectors twice.
    assert_eq!(read(file([&points, &cells, &(field.clone() + &field)], [""; 2])).0, whole);
    for (twice, said) in [
        ([&(points.clone() + &points), &cells, &field], "a second array of points"),
        ([&points, &(cells.clone() + &nodes), &field], "a second array of cells"),
        (
            [&points, &cells, &(field.clone() + &field.replace("0.5", "0.7"))],
            "a second array of the name `k`",
        ),
    ] {
        let refused = refused(&file(twice.map(String::as_str), [""; 2]));
        assert!(refused.contains(said) && refused.contains("time step"), "{refused}");
    }
    // A process without a share of the body writes an empty piece.
    let none = array("Points", "Float64", 3, "");
    let empty =
        format!("<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"><Points>{none}</Points></Piece>");
    for pieces in [[&*empty, ""], ["", &*empty]] {
        assert_eq!(read(file([&points, &cells, &field], pieces)).0, whole);
    }
}

#[test]
fn keywords_that_join_parts_of_a_body_are_refused() {
    let nodes = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n";
    for keyword in
        ["*Tie, name=glue\na, b\n", "*MPC\nTIE, 1, 2\n", "*EQUATION\n2\n1, 1, 1.0, 2, 1, -1.0\n"]
    {
        let error = parse("test", format!("{nodes}{keyword}").as_bytes()).unwrap_err().to_string();
        let name = keyword[..4].to_uppercase();
        assert!(error.contains(&name) && error.contains("shared nodes"), "{error}");
    }
    read(nodes);
}

#[test]
fn what_came_in_the_place_of_a_mesh_is_named() {
    for (content, name) in [
        (&b"\x1f\x8b\x08\0\0\0\0\0"[..], "archive or compressed file"),
        (b"PK\x03\x04rest", "archive or compressed file"),
        (b"<!DOCTYPE html><html><body>404</body></html>", "HTML"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n", "pointer of Git LFS"),
    ] {
        let error = parse("test", content).unwrap_err().to_string();
        assert!(error.contains(&format!("the format `{name}` cannot be read")), "{error}");
    }
}
