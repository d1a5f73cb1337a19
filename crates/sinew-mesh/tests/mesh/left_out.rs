//! Changes of readers in every format: facets of no cell, nodes at one place, nodes of no cell, names of a curve and a
//! surface, colours, marks that are not numbers.

use sinew_mesh::{
    AnyMesh, MixedMesh, ReadReport, Selection, TetMesh, box_tetrahedra, parse, parse_mesh,
    read_merged,
};
use std::fmt::Write;

/// Elements by VTK's type, nodes and the number of their group.
struct File {
    points: Vec<[f64; 3]>,
    elements: Vec<(u8, Vec<usize>, usize)>,
}

const FORMATS: [fn(&File) -> String; 4] = [File::vtk, File::vtu, File::msh, File::inp];
/// Group of the solid.
const SOLID: usize = 3;
/// Group of the surface.
const SIDE: usize = 7;

impl File {
    fn of(mesh: &TetMesh) -> Self {
        let elements = mesh.cells.iter().map(|cell| (10, cell.to_vec(), SOLID)).collect();
        Self { points: mesh.points.clone(), elements }
    }

    fn add(&mut self, kind: u8, nodes: Vec<usize>, group: usize) {
        self.elements.push((kind, nodes, group));
    }

    fn coordinates(&self) -> String {
        self.points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
    }

    fn each(&self, said: impl Fn(&(u8, Vec<usize>, usize)) -> String) -> String {
        self.elements.iter().map(|element| said(element) + "\n").collect()
    }

    fn vtk(&self) -> String {
        let (points, cells) = (self.points.len(), self.elements.len());
        let size: usize = self.elements.iter().map(|(_, nodes, _)| 1 + nodes.len()).sum();
        format!(
            "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {points} double\n{}CELLS {cells} {size}\n{}\
             CELL_TYPES {cells}\n{}CELL_DATA {cells}\nSCALARS region int 1\nLOOKUP_TABLE default\n{}",
            self.coordinates(),
            self.each(|(_, nodes, _)| format!("{} {}", nodes.len(), listed(nodes, 0, " "))),
            self.each(|(kind, ..)| kind.to_string()),
            self.each(|(.., group)| group.to_string()),
        )
    }

    fn vtu(&self) -> String {
        let mut end = 0;
        let mut ends = String::new();
        for (_, nodes, _) in &self.elements {
            end += nodes.len();
            write!(ends, "{end} ").unwrap();
        }
        let array = |name: &str, kind: &str, text: String| {
            format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{text}</DataArray>"
            )
        };
        let points = array("p", "Float64", self.coordinates());
        format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\"><Points>{}</Points>\
             <Cells>{}{}{}</Cells><CellData>{}</CellData></Piece></UnstructuredGrid></VTKFile>",
            self.points.len(),
            self.elements.len(),
            points.replace("Name", "NumberOfComponents=\"3\" Name"),
            array("connectivity", "Int64", self.each(|(_, nodes, _)| listed(nodes, 0, " "))),
            array("offsets", "Int64", ends),
            array("types", "UInt8", self.each(|(kind, ..)| kind.to_string())),
            array("region", "Int32", self.each(|(.., group)| group.to_string())),
        )
    }

    fn msh(&self) -> String {
        self.msh_named("3 3 \"solid\"\n2 7 \"side\"\n1 7 \"side\"\n")
    }

    fn msh_named(&self, names: &str) -> String {
        let count = names.lines().count();
        let points = self.points.iter().enumerate();
        let points: String =
            points.map(|(at, [x, y, z])| format!("{} {x} {y} {z}\n", at + 1)).collect();
        let mut text = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{count}\n{names}$EndPhysicalNames\n$Nodes\n{}\n{points}$EndNodes\n\
             $Elements\n{}\n",
            self.points.len(),
            self.elements.len()
        );
        for (at, (kind, nodes, group)) in self.elements.iter().enumerate() {
            let kind =
                [(3, 1), (5, 2), (10, 4), (1, 15)].iter().find(|of| of.0 == *kind).unwrap().1;
            writeln!(text, "{} {kind} 2 {group} {group} {}", at + 1, listed(nodes, 1, " "))
                .unwrap();
        }
        text + "$EndElements\n"
    }

    fn inp(&self) -> String {
        let points = self.points.iter().enumerate();
        let points: String =
            points.map(|(at, [x, y, z])| format!("{}, {x}, {y}, {z}\n", at + 1)).collect();
        let mut text = format!("*NODE\n{points}");
        for (at, (kind, nodes, group)) in self.elements.iter().enumerate() {
            let kind = [(3, "T3D2"), (5, "S3"), (10, "C3D4")].iter().find(|of| of.0 == *kind);
            let name = if *group == SIDE { "side" } else { "solid" };
            let nodes = listed(nodes, 1, ", ");
            writeln!(text, "*ELEMENT, TYPE={}, ELSET={name}\n{}, {nodes}", kind.unwrap().1, at + 1)
                .unwrap();
        }
        text
    }
}

fn listed(nodes: &[usize], first: usize, between: &str) -> String {
    nodes.iter().map(|node| (node + first).to_string()).collect::<Vec<_>>().join(between)
}

fn read(text: &str) -> (TetMesh, ReadReport) {
    parse_mesh::<4>("test", text.as_bytes()).unwrap()
}

/// The surface by its name in a format.
fn side(mesh: &TetMesh) -> &str {
    if mesh.facet_sets.contains_key("side") { "side" } else { "region:7" }
}

/// A cube with the triangles of one side, and those of the opposite side along the other diagonal.
fn flipped() -> (TetMesh, File) {
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let mut file = File::of(&mesh);
    for &facet in &mesh.facet_sets["x_max"] {
        file.add(5, mesh.nodes_of_facet(facet).collect(), SIDE);
    }
    let [a, b] = [0, 1]
        .map(|k| -> Vec<usize> { mesh.nodes_of_facet(mesh.facet_sets["x_min"][k]).collect() });
    let both: Vec<usize> = a.iter().copied().filter(|node| b.contains(node)).collect();
    let alone = |of: &[usize]| of.iter().copied().find(|node| !both.contains(node)).unwrap();
    for &corner in &both {
        file.add(5, vec![alone(&a), alone(&b), corner], SIDE);
    }
    (mesh, file)
}

#[test]
fn facets_of_no_cell_are_counted_in_their_sets() {
    let (cube, file) = flipped();
    for format in FORMATS {
        let (mesh, report) = read(&format(&file));
        assert_eq!((report.matched_facets, report.unmatched_facets), (2, 2));
        let name = side(&mesh);
        assert_eq!(mesh.facet_sets[name], cube.facet_sets["x_max"], "{name}");
        assert_eq!(report.incomplete_sets.iter().collect::<Vec<_>>(), [(&name.to_string(), &2)]);
        let said = &report.warnings()[0];
        let words = ["2 elements of the boundary", "not faces", &format!("`{name}` lacks 2")];
        words.iter().for_each(|words| assert!(said.contains(words), "{said}"));
    }
    // None at all: there is no set, and its name is said.
    let mut none = File::of(&cube);
    none.elements.extend(file.elements.into_iter().filter(|(kind, ..)| *kind == 5).skip(2));
    let (mesh, report) = read(&none.msh());
    assert!(mesh.facet_sets.is_empty() && report.incomplete_sets["side"] == 2);
    let mut mixed = MixedMesh::new(cube.points.clone());
    mixed
        .add_cells(10, 4, &cube.cells.as_flattened().iter().map(|&n| n as i64).collect::<Vec<_>>())
        .unwrap();
    let lost = mixed.add_cells(5, 3, &[1, 2, 4]).unwrap();
    mixed.name_cells("cut", lost);
    assert_eq!(mixed.into_mesh().unwrap().1.incomplete_sets["cut"], 1);
}

/// Two cubes side by side with nodes of their own, of which a rounding error parts the second; triangles of both on one side.
fn unmerged() -> (TetMesh, File) {
    let both = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    let cube = box_tetrahedra([1.0; 3], [1; 3]);
    let mut file = File::of(&cube);
    let second = cube.points.iter().map(|[x, y, z]| [x + 1.0, y + 1e-7, *z]);
    file.points.extend(second);
    let moved: Vec<_> = cube.cells.iter().map(|cell| cell.map(|node| node + 8)).collect();
    moved.iter().for_each(|cell| file.add(10, cell.to_vec(), SOLID));
    for &facet in &cube.facet_sets["x_max"] {
        file.add(5, cube.nodes_of_facet(facet).map(|node| node + 8).collect(), SIDE);
    }
    (both, file)
}

#[test]
fn nodes_at_one_place_are_told_and_merged() {
    let (both, file) = unmerged();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test");
    for format in FORMATS {
        let text = format(&file);
        let (mesh, report) = read(&text);
        assert_eq!((mesh.points.len(), report.coincident_nodes, report.merged_nodes), (16, 4, 0));
        let said = &report.warnings()[0];
        assert!(
            said.contains("4 nodes at the place of another") && said.contains("merge"),
            "{said}"
        );
        std::fs::write(&path, &text).unwrap();
        let (AnyMesh::Tetrahedra(mesh), report) = read_merged(&path).unwrap() else { panic!() };
        assert_eq!((report.coincident_nodes, report.merged_nodes, report.unused_nodes), (0, 4, 0));
        assert_eq!((mesh.points.len(), mesh.check()), (12, Ok(())));
        let boundary = sinew_mesh::boundary_facets(&mesh).len();
        assert_eq!(boundary, sinew_mesh::boundary_facets(&both).len());
        assert_eq!((mesh.facet_sets[side(&mesh)].len(), report.warnings().len()), (2, 0));
    }
}

#[test]
fn surfaces_with_nodes_of_their_own_find_their_cells() {
    // As programs write that put a volume and its surface into one file.
    let mesh = box_tetrahedra([1.0; 3], [2; 3]);
    let mut file = File::of(&mesh);
    for &facet in &mesh.facet_sets["z_max"] {
        let first = file.points.len();
        file.points.extend(mesh.nodes_of_facet(facet).map(|node| mesh.points[node]));
        file.add(5, vec![first, first + 1, first + 2], SIDE);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test");
    for format in FORMATS {
        let text = format(&file);
        let (apart, report) = read(&text);
        assert_eq!((report.unmatched_facets, report.unused_nodes), (8, 24));
        assert!(apart.facet_sets.is_empty() && report.warnings().len() == 2, "{report:?}");
        std::fs::write(&path, &text).unwrap();
        let (AnyMesh::Tetrahedra(merged), report) = read_merged(&path).unwrap() else { panic!() };
        assert_eq!((report.unmatched_facets, report.merged_nodes), (0, 24));
        assert_eq!(merged.facet_sets[side(&merged)], mesh.facet_sets["z_max"]);
        assert_eq!(merged.points, mesh.points);
    }
}

#[test]
fn marks_and_sets_of_a_copy_stay() {
    let (_, file) = unmerged();
    // Marked at the second copy of the nodes alone: node 8 is the corner of the second cube.
    let marks: Vec<_> = (0..16).map(|node| if node >= 8 { "2.5" } else { "0" }).collect();
    let sets: Vec<_> = (0..16).map(|node| if node == 8 { "1" } else { "0" }).collect();
    let fields = format!(
        "POINT_DATA 16\nSCALARS mark double\nLOOKUP_TABLE default\n{}\nSCALARS node_set:tip int\nLOOKUP_TABLE default\n{}\n",
        marks.join(" "),
        sets.join(" ")
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.vtk");
    std::fs::write(&path, file.vtk() + &fields).unwrap();
    let (mesh, _) = read_merged(&path).unwrap();
    let at = |nodes: &[usize]| nodes.iter().map(|&node| mesh.points()[node][0]).collect::<Vec<_>>();
    assert_eq!(at(&mesh.node_sets()["tip"]), [1.0]);
    let marked = mesh.nodes_where_nonzero("mark").unwrap();
    assert_eq!(marked.len(), 8);
    assert!(at(&marked).iter().all(|x| *x >= 1.0));
    let mut mixed = MixedMesh::new(file.points.clone());
    for (kind, nodes, _) in &file.elements {
        let nodes: Vec<i64> = nodes.iter().map(|&node| node as i64).collect();
        mixed.add_cells(*kind, nodes.len(), &nodes).unwrap();
    }
    mixed.name_nodes("both", [1, 8]);
    mixed.merge = true;
    let (mesh, report) = mixed.into_mesh().unwrap();
    assert_eq!((mesh.node_sets()["both"].len(), report.merged_nodes), (1, 4));
}

#[test]
fn nodes_of_no_cell_are_left_out_and_do_not_widen_selections() {
    let mesh = box_tetrahedra([20.0, 10.0, 10.0], [2, 2, 2]);
    let mut file = File::of(&mesh);
    // Reference points, one a kilometre away, before and behind the others.
    file.points.push([1e6, 0.0, 0.0]);
    file.points.insert(0, [0.0, 0.0, 5.0]);
    file.elements.iter_mut().for_each(|(_, nodes, _)| nodes.iter_mut().for_each(|n| *n += 1));
    for format in FORMATS {
        let (mut read, report) = read(&format(&file));
        assert_eq!((report.unused_nodes, report.warnings().len()), (2, 0));
        assert_eq!(report.changes(), ["2 nodes of no cell left out"]);
        assert_eq!((&read.points, &read.cells), (&mesh.points, &mesh.cells));
        let x = [1.0, 0.0, 0.0];
        assert!(read.select("off", &Selection::plane([0.01, 0.0, 0.0], x)).is_err());
        assert_eq!(read.select("on", &Selection::plane([0.0; 3], x)).unwrap().nodes, 9);
    }
    // Nor in a mesh in memory that has kept such a node.
    let mut kept = mesh.clone();
    kept.points.push([1e6, 0.0, 0.0]);
    assert!(kept.select("off", &Selection::plane([0.01, 0.0, 0.0], [1.0, 0.0, 0.0])).is_err());
}

#[test]
fn a_curve_joins_the_surface_of_its_name() {
    let mesh = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    let mut file = File::of(&mesh);
    for &facet in &mesh.facet_sets["x_min"] {
        file.add(5, mesh.nodes_of_facet(facet).collect(), SIDE);
    }
    let ends = mesh.node_sets["x_max"][..2].to_vec();
    file.add(3, ends.clone(), SIDE);
    let nodes = [mesh.node_sets["x_min"].clone(), ends].concat();
    let sorted = |mut nodes: Vec<usize>| {
        nodes.sort_unstable();
        nodes
    };
    for format in [File::msh, File::inp] {
        let (read, _) = read(&format(&file));
        assert_eq!(read.node_sets["side"], sorted(nodes.clone()));
        assert_eq!(read.facet_sets["side"], mesh.facet_sets["x_min"]);
    }
    // Points and edges of a plate.
    let corners = "1 0 0 0\n2 1 0 0\n3 0 1 0\n";
    let plate = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n0 1 \"held\"\n1 1 \"held\"\n$EndPhysicalNames\n$Nodes\n3\n{corners}\
         $EndNodes\n$Elements\n3\n1 2 2 9 9 1 2 3\n2 1 2 1 1 1 2\n3 15 2 1 1 3\n$EndElements\n"
    );
    let (read, _) = parse_mesh::<3>("test", plate.as_bytes()).unwrap();
    assert_eq!((&read.node_sets["held"], read.facet_sets["held"].len()), (&vec![0, 1, 2], 1));
}

#[test]
fn groups_without_a_name_are_numbered_in_each_dimension() {
    let mesh = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    let mut file = File::of(&mesh);
    for &facet in &mesh.facet_sets["x_min"] {
        file.add(5, mesh.nodes_of_facet(facet).collect(), SIDE);
    }
    let (alone, _) = read(&file.msh_named("3 3 \"solid\"\n"));
    assert_eq!(alone.facet_sets["physical_7"], mesh.facet_sets["x_min"]);
    file.add(3, mesh.node_sets["x_max"][..2].to_vec(), SIDE);
    let (both, _) = read(&file.msh_named("3 3 \"solid\"\n"));
    assert_eq!(both.facet_sets["physical_surface_7"], mesh.facet_sets["x_min"]);
    assert_eq!(both.node_sets["physical_curve_7"], mesh.node_sets["x_max"][..2]);
    assert!(!both.facet_sets.contains_key("physical_7"));
}

#[test]
fn colours_in_text_are_those_in_binary() {
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let text = File::of(&mesh).vtk();
    let values = [0u8, 1, 2, 127, 254, 255];
    let shares: Vec<_> = values.iter().map(|v| format!("{:.6}", f64::from(*v) / 255.0)).collect();
    let (read, _) =
        self::read(&(text.clone() + &format!("COLOR_SCALARS k 1\n{}\n", shares.join(" "))));
    assert_eq!(read.cell_fields["k"].to_f64(), values.map(f64::from).as_slice());
    let beyond = text + "COLOR_SCALARS k 1\n0 1 2 127 254 255\n";
    let error = parse("test", beyond.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("colour from 0 to 1") && error.contains('2'), "{error}");
}

#[test]
fn marks_that_are_not_numbers_are_refused() {
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let text = File::of(&mesh).vtk()
        + "POINT_DATA 8\nSCALARS held double\nLOOKUP_TABLE default\n1 1 nan 0 0 0 0 0\n";
    let (read, _) = read(&text);
    let error = read.nodes_where_nonzero("held").unwrap_err().to_string();
    assert!(error.contains("`held` is NaN at node 2"), "{error}");
    let marks = "<PointData><DataArray type=\"Float32\" Name=\"held\" format=\"ascii\">0 inf 0 0 0 0 0 0</DataArray></PointData><CellData>";
    let (read, _) = self::read(&File::of(&mesh).vtu().replace("<CellData>", marks));
    let error = read.nodes_where_nonzero("held").unwrap_err().to_string();
    assert!(error.contains("`held` is inf at node 1"), "{error}");
}

#[test]
fn arrays_without_a_name_are_left_out() {
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let ones = "<CellData><DataArray type=\"Float64\" format=\"ascii\">1 1 1 1 1 1</DataArray>";
    let (read, report) = read(&File::of(&mesh).vtu().replace("<CellData>", ones));
    assert_eq!(report.changes(), ["array of the name `` left out"]);
    assert!(!read.cell_fields.contains_key("") && sinew_mesh::to_vtu(&read).is_ok());
}

#[test]
fn nodes_that_nearly_meet_are_told() {
    let (_, mut file) = unmerged();
    // Half a percent of an edge, far beyond the digits of a file, but for one node.
    file.points[9..].iter_mut().for_each(|[x, ..]| *x += 0.005);
    for format in FORMATS {
        let (mesh, report) = read(&format(&file));
        assert_eq!((mesh.points.len(), report.coincident_nodes, report.near_nodes), (16, 1, 3));
        let said = report.warnings();
        assert!(said[1].contains("3 nodes nearly at the place of another"), "{said:?}");
    }
    // The corners of a flat cell are near each other, and hold together.
    let mut flat = box_tetrahedra([1.0, 1.0, 1.0], [1; 3]);
    flat.points[1] = [0.004, 0.0, 0.0];
    let (_, report) = read(&File::of(&flat).vtk());
    assert_eq!((report.near_nodes, report.warnings().len()), (0, 0));
}

#[test]
fn ghosts_and_hidden_cells_are_none() {
    let cube = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    // A duplicate, a hidden cell, and one whose bit is of points alone.
    let bits: String = (0..12).map(|cell| format!("{}\n", [1, 32, 2, 0][cell.min(3)])).collect();
    let text = File::of(&cube).vtk();
    let (mesh, report) =
        read(&format!("{text}SCALARS vtkGhostType unsigned_char\nLOOKUP_TABLE default\n{bits}"));
    assert_eq!(mesh.cells, cube.cells[2..]);
    assert!(report.changes().contains(&"2 ghost or hidden cells left out".into()), "{report:?}");
}
