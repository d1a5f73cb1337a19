//! Abaqus and CalculiX input: files of gmsh and meshio, one in the form of Abaqus/CAE, meshes of ours written by the manuals'
//! numbering, and errors with their place.

use sinew_mesh::{
    AnyMesh, Element, Mesh, ReadReport, TetMesh, boundary_facets, box_hexahedra, box_tetrahedra,
    enclosed_volume, parse, parse_mesh, read_mesh, rectangle_triangles,
};
use std::fmt::Write;
use std::path::PathBuf;

fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "../../fixtures/mesh", name].iter().collect()
}

/// Corners of the faces S1, S2 and so on, from 1 (Abaqus Analysis User's Guide, "Solid element library"; G. Dhondt, CalculiX
/// CrunchiX User's Manual, *SURFACE), and the element's name.
fn manual<const N: usize>() -> (&'static str, &'static [&'static [usize]]) {
    let tetrahedron: &[&[usize]] = &[&[1, 2, 3], &[1, 4, 2], &[2, 4, 3], &[3, 4, 1]];
    match N {
        3 => ("CPS3", &[&[1, 2], &[2, 3], &[3, 1]]),
        4 => ("C3D4", tetrahedron),
        10 => ("C3D10", tetrahedron),
        _ => (
            "C3D8",
            &[
                &[1, 2, 3, 4],
                &[5, 8, 7, 6],
                &[1, 5, 6, 2],
                &[2, 6, 7, 3],
                &[3, 7, 8, 4],
                &[4, 8, 5, 1],
            ],
        ),
    }
}

/// A file with all sets; numbers begin at 3 and go in steps of 7, and an element takes lines of four numbers.
fn to_inp<const N: usize>(mesh: &Mesh<N>) -> String {
    let number = |index: usize| 3 + 7 * index;
    let (element, faces) = manual::<N>();
    let mut text = String::from("*NODE\n");
    for (index, [x, y, z]) in mesh.points.iter().enumerate() {
        writeln!(text, "{}, {x:e}, {y:e}, {z:e}", number(index)).unwrap();
    }
    writeln!(text, "*ELEMENT, TYPE={element}").unwrap();
    for (index, cell) in mesh.cells.iter().enumerate() {
        let numbers: Vec<_> =
            std::iter::once(&index).chain(cell).map(|&n| number(n).to_string()).collect();
        text.push_str(
            &(numbers.chunks(4).map(|line| line.join(", ")).collect::<Vec<_>>().join(",\n") + "\n"),
        );
    }
    for (name, nodes) in &mesh.node_sets {
        let numbers: Vec<_> = nodes.iter().map(|&node| number(node).to_string()).collect();
        writeln!(text, "*NSET, NSET={name}\n{}", numbers.join(",\n")).unwrap();
    }
    for (name, facets) in &mesh.facet_sets {
        writeln!(text, "*SURFACE, NAME={name}, TYPE=ELEMENT").unwrap();
        for &facet in facets {
            let nodes: Vec<_> = mesh.nodes_of_facet(facet).collect();
            let corner = |&local: &usize| nodes.contains(&mesh.cells[facet.cell][local - 1]);
            let face = faces.iter().position(|face| face.iter().all(corner)).unwrap() + 1;
            writeln!(text, "{}, S{face}", number(facet.cell)).unwrap();
        }
    }
    text
}

fn assert_comes_back<const N: usize>(mesh: &Mesh<N>) {
    let (again, report) = parse_mesh::<N>("test.inp", to_inp(mesh).as_bytes()).unwrap();
    assert_eq!(&again, mesh);
    assert_eq!(report, ReadReport::default());
}

#[test]
fn meshes_come_back_with_their_sets_and_faces() {
    assert_comes_back(&box_tetrahedra([2.0, 1.0, 1.0], [3, 2, 1]));
    assert_comes_back(&box_tetrahedra([2.0, 1.0, 1.0], [2, 2, 1]).quadratic());
    assert_comes_back(&box_hexahedra([2.0, 1.0, 1.0], [3, 2, 2]));
    assert_comes_back(&rectangle_triangles([2.0, 1.0], [3, 2]));
}

/// One element of a type on so many nodes, which are those of a reference cell where there is one.
fn element(name: &str, nodes: usize) -> String {
    let mut text = String::from("*NODE\n");
    for node in 0..nodes {
        let at = match nodes {
            3 | 4 | 6 | 8 | 10 => Element::with_nodes(nodes).nodes[node],
            _ => [node, node * node, node * node * node].map(|x| x as f64),
        };
        writeln!(text, "{}, {}, {}, {}", node + 1, at[0], at[1], at[2]).unwrap();
    }
    let numbers: Vec<_> = (1..=nodes).map(|node| node.to_string()).collect();
    text + &format!("*ELEMENT, TYPE={name}\n1, {}\n", numbers.join(", "))
}

#[test]
fn types_of_elements_with_their_variants() {
    let cells = [
        ("C3D4H", 4),
        ("c3d10", 10),
        ("C3D10HS", 10),
        ("C3D10MH", 10),
        ("C3D8RH", 8),
        ("S3R", 3),
        ("STRI65", 6),
        ("M3D6", 6),
    ];
    for (name, nodes) in cells {
        let (mesh, report) = parse("test.inp", element(name, nodes).as_bytes()).unwrap();
        assert_eq!((mesh.element(), mesh.cell_count()), (Element::with_nodes(nodes), 1), "{name}");
        assert_eq!(report.repaired_cells, 0, "{name}");
    }
    for (name, nodes, shape) in
        [("C3D20R", 20, "a quadratic hexahedron"), ("S4R5", 4, "a quadrilateral")]
    {
        assert_refused(&element(name, nodes), &["cell 0 is ", shape]);
    }
    for name in ["B31", "T3D2"] {
        let text = element("C3D4", 4) + &format!("*ELEMENT, TYPE={name}\n2, 1, 2\n");
        let (mesh, report) = parse_mesh::<4>("test.inp", text.as_bytes()).unwrap();
        assert_eq!((mesh.cells.len(), report.dropped_cells), (1, 1), "{name}");
    }
    for name in ["CAX3", "COH3D8", "U1", "C3D", "C3D7", "C3D99999999999999999999"] {
        assert_refused(&element(name, 4), &["the element type", name, "use C3D4, C3D10 or C3D8"]);
    }
    assert_refused(&element("", 4), &["TYPE=… of *ELEMENT"]);
    // Faces end where the manual's do.
    for (name, nodes, face) in [("C3D10MH", 10, "S5"), ("C3D8R", 8, "S7"), ("CPS3", 3, "S4")] {
        let text = element(name, nodes) + &format!("*SURFACE, NAME=s\n1, {face}\n");
        assert_refused(&text, &["a face that the element has", face]);
    }
}

#[test]
fn faces_of_a_hexahedron_point_where_the_manual_says() {
    // A brick of 1 × 2 × 3 along x, y and z: S1 is its bottom, S2 its top, S3 the side y = 0, and on around it.
    let text = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,2,0\n4,0,2,0\n5,0,0,3\n6,1,0,3\n7,1,2,3\n8,0,2,3\n\
                *ELEMENT,TYPE=C3D8R\n1,1,2,3,4,5,6,7,8\n";
    let normals = [[0, 0, -2], [0, 0, 2], [0, -3, 0], [6, 0, 0], [0, 3, 0], [-6, 0, 0]];
    for (index, normal) in normals.into_iter().enumerate() {
        let text = format!("{text}*SURFACE,NAME=side\n1,S{}\n", index + 1);
        let (mesh, _) = parse_mesh::<8>("test", text.as_bytes()).unwrap();
        let nodes: Vec<usize> = mesh.nodes_of_facet(mesh.facet_sets["side"][0]).collect();
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| nalgebra::Vector3::from(mesh.points[nodes[k]]));
        let area = (c - a).cross(&(d - b)) / 2.0;
        assert_eq!(area, nalgebra::Vector3::from(normal.map(f64::from)), "S{}", index + 1);
    }
}

#[test]
fn a_part_with_its_instance() {
    let (mesh, report) = read_mesh::<4>(fixture("abaqus_part.inp")).unwrap();
    assert_eq!((mesh.cells.len(), mesh.cells[0]), (2, [0, 1, 2, 3]));
    assert_eq!((report.matched_facets, report.unmatched_facets, report.unused_nodes), (1, 0, 0));
    // Moved by 10 along x, then turned by 90° about the axis through (10, 0, 0) along z.
    let expected =
        [[10.0, 0.0, 0.0], [10.0, 1.0, 0.0], [9.0, 0.0, 0.0], [10.0, 0.0, 1.0], [9.0, 1.0, 1.0]];
    for (x, expected) in mesh.points.as_flattened().iter().zip(expected.as_flattened()) {
        // Rounding of one rotation of numbers up to 10.
        assert!((x - expected).abs() < 1e-14, "{x} is not {expected}");
    }
    let nodes = |name: &str| mesh.node_sets[name].as_slice();
    assert_eq!(
        (nodes("All"), nodes("Block-1.Base"), nodes("Base")),
        (&[0, 1, 2, 3, 4][..], &[0, 1, 2][..], &[3][..])
    );
    // Sets within sets; a name alone is the assembly's.
    assert_eq!(
        (nodes("Union"), nodes("Inside"), nodes("Tips")),
        (&[0, 1, 2, 3, 4][..], &[1, 2, 4][..], &[3, 4][..])
    );
    assert_eq!(mesh.cell_sets["Both Cells"], [0, 1]);
    let corners = |name: &str| -> Vec<Vec<usize>> {
        let sorted = |facet| {
            let mut nodes: Vec<usize> = mesh.nodes_of_facet(facet).collect();
            nodes.sort_unstable();
            nodes
        };
        mesh.facet_sets[name].iter().map(|&facet| sorted(facet)).collect()
    };
    let mut corner = corners("Corner");
    corner.sort_unstable();
    // S1 is 1-2-3 and S2 is 1-4-2.
    assert_eq!(corner, [[0, 1, 2], [0, 1, 3]]);
    assert_eq!(corners("Far"), [[1, 2, 4]]);
    assert_eq!((corners("Membrane"), corners("Skin")), (vec![vec![1, 2, 4]], vec![vec![1, 2, 4]]));
    let mut outside = mesh.facet_sets["Outside"].clone();
    outside.sort_unstable();
    assert_eq!(outside, boundary_facets(&mesh));
}

#[test]
fn files_of_gmsh() {
    let (linear, report) = read_mesh::<4>(fixture("gmsh_linear.inp")).unwrap();
    let (msh, _) = read_mesh::<4>(fixture("gmsh_41_ascii.msh")).unwrap();
    assert_eq!(linear.facet_sets["clamped_side"].len(), msh.facet_sets["clamped side"].len());
    assert_eq!(linear.facet_sets["clamped_side"], linear.facet_sets["PhysicalSurface5"]);
    assert_eq!(linear.cell_sets["tissue"].len(), linear.cells.len());
    assert_eq!(report.unmatched_facets, 0);
    let (quadratic, _) = read_mesh::<10>(fixture("gmsh_quadratic.inp")).unwrap();
    // Middle nodes lie in the middle of their edges, and all of the box is there.
    for cell in &quadratic.cells {
        for edge in Mesh::<10>::ELEMENT.edges {
            let [a, b, middle] =
                [0, 1, 2].map(|k| nalgebra::Vector3::from(quadratic.points[cell[edge[k]]]));
            // The file has 16 digits.
            assert!((middle - (a + b) / 2.0).norm() < 1e-14);
        }
    }
    for volume in [
        enclosed_volume(&linear, &boundary_facets(&linear)),
        enclosed_volume(&quadratic, &boundary_facets(&quadratic)),
    ] {
        assert!((volume - 2.0).abs() < 1e-13, "{volume}");
    }
    assert_eq!(quadratic.facet_sets["clamped_side"].len(), linear.facet_sets["clamped_side"].len());
}

#[test]
fn files_of_meshio() {
    let (mesh, report) = read_mesh::<4>(fixture("meshio.inp")).unwrap();
    let expected = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    assert_eq!((&mesh.points, &mesh.cells), (&expected.points, &expected.cells));
    assert_eq!((report.repaired_cells, report.matched_facets), (6, 2));
    assert_eq!(mesh.facet_sets["loaded"], expected.facet_sets["x_max"]);
    assert_eq!(
        (&mesh.node_sets["clamped"], &mesh.cell_sets["some"]),
        (&vec![0, 3, 6, 9], &vec![1, 4])
    );
}

const CORNER: &str = "*NODE, NSET=all\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=one\n1, 1, 2, 3, 4\n";

fn corner_with(more: &str) -> TetMesh {
    parse_mesh::<4>("test", format!("{CORNER}{more}").as_bytes()).unwrap().0
}

#[test]
fn sets_in_all_their_forms() {
    let mesh = corner_with(
        "*nset , nset=Odd, generate\n1, 99, 2\n*NSET,NSET=odd\n2\n*NSET, NSET=Both\n ODD , 4\n*NSET,NSET=empty\n",
    );
    assert_eq!(
        (&mesh.node_sets["Odd"], &mesh.node_sets["Both"]),
        (&vec![0, 1, 2], &vec![0, 1, 2, 3])
    );
    assert_eq!((&mesh.node_sets["all"], &mesh.node_sets["empty"]), (&vec![0, 1, 2, 3], &vec![]));
    // Comments and empty lines may stand anywhere, and a keyword may go on behind a comma at the end of its line.
    let mesh = corner_with(
        "** a comment\n*Nset ,  nset = \"My, Set\",\n internal , GENERATE\n1, 9,2\n** x\n\n*node output\nU\n",
    );
    assert_eq!(mesh.node_sets["My, Set"], [0, 2]);
    // Capitals matter in quotation marks only.
    let mesh = corner_with(
        "*NSET, NSET=\"Base\"\n1\n*NSET, NSET=\"BASE\"\n2\n*NSET, NSET=Top\n3\n*NSET, NSET=TOP\n4\n",
    );
    let sets: Vec<_> = ["Base", "BASE", "Top"].map(|name| mesh.node_sets[name].clone()).into();
    assert_eq!((sets, mesh.node_sets.len()), (vec![vec![0], vec![1], vec![2, 3]], 4));
    // Keywords may stand in any order, a set before the nodes too.
    let text = format!("*NSET, NSET=base\n1, 2\n{CORNER}");
    assert_eq!(parse_mesh::<4>("test", text.as_bytes()).unwrap().0.node_sets["base"], [0, 1]);
    // An element set and a surface of the same name are two things.
    let mesh = corner_with(
        "*ELEMENT,TYPE=S3,ELSET=skin\n2, 1,2,3\n*SURFACE,NAME=SKIN\n1, S2\n*SURFACE,NAME=skin\n1,S3\n",
    );
    let sides =
        |name: &str| mesh.facet_sets[name].iter().map(|facet| facet.opposite).collect::<Vec<_>>();
    assert_eq!((sides("skin"), sides("SKIN"), sides("elset:skin")), (vec![0], vec![2], vec![3]));
}

#[test]
fn a_comma_at_the_end_of_a_keyword_does_not_swallow_data() {
    let text = CORNER.replace("*NODE, NSET=all\n1, 0, 0, 0\n", "*NODE,\n1, 0., 1.D-1, 2\n");
    let (mesh, _) = parse_mesh::<4>("test", text.as_bytes()).unwrap();
    assert_eq!((mesh.points.len(), mesh.points[0]), (4, [0.0, 0.1, 2.0]));
}

#[test]
fn plane_bodies_and_surfaces() {
    let nodes = "*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n";
    let plane = format!(
        "{nodes}*ELEMENT,TYPE=CPE3H\n1,1,2,3\n*SURFACE,NAME=slope\n1,S2\n*SURFACE,NAME=rim\n1\n"
    );
    let AnyMesh::Triangles(mesh) = parse("test", plane.as_bytes()).unwrap().0 else {
        panic!("triangles")
    };
    assert_eq!((mesh.facet_sets["slope"][0].opposite, mesh.facet_sets["rim"].len()), (0, 3));
    let shell = format!("{nodes}*ELEMENT,TYPE=S3R,ELSET=e\n1,1,2,3\n*SURFACE,NAME=inner\ne,SNEG\n");
    let AnyMesh::Triangles(mesh) = parse("test", shell.as_bytes()).unwrap().0 else {
        panic!("triangles")
    };
    assert_eq!((&mesh.cell_sets["inner"], &mesh.cell_sets["e"]), (&vec![0], &vec![0]));
}

#[track_caller]
fn assert_refused(text: &str, parts: &[&str]) {
    let message = parse_mesh::<4>("test.inp", text.as_bytes()).unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

#[test]
fn what_cannot_be_read_says_where_and_what_to_do() {
    let with = |more: &str| format!("{CORNER}{more}");
    assert_refused(
        &with("*INCLUDE, INPUT=nodes.inp\n"),
        &["test.inp, line 8", "*INCLUDE", "with all its nodes"],
    );
    assert_refused(&with("*NSET, NSET=a\n1, 9\n"), &["line 9", "`9`", "that the file has"]);
    assert_refused(&with("*NSET, NSET=a\nbase\n"), &["line 9", "`base`", "further up"]);
    assert_refused(&with("*NSET\n1\n"), &["line 8", "NSET=…"]);
    assert_refused(&with("*NSET, NSET=a, GENERATE\n5, 1\n"), &["line 9", "ascends", "5, 1, 1"]);
    assert_refused(&with("*SURFACE, NAME=s\none, S5\n"), &["line 9", "face", "`S5`"]);
    assert_refused(
        &with("*SURFACE, NAME=s, COMBINE=UNION\na, b\n"),
        &["line 8", "COMBINE of *SURFACE"],
    );
    assert_refused(
        &with("*SURFACE, NAME=s, TYPE=CUTTING SURFACE\n"),
        &["line 8", "CUTTING SURFACE", "TYPE=NODE"],
    );
    assert_refused(&with("*ELEMENT, TYPE=CAX4\n"), &["line 8", "`CAX4`", "C3D4"]);
    assert_refused(&with("*ELEMENT, TYPE=C3D10\n2, 1, 2, 3, 4\n"), &["line 9", "other nodes"]);
    assert_refused(
        &with("*ELEMENT, TYPE=C3D4\n2, 1, 2, 3, 4, 5\n"),
        &["nodes of element 2, a C3D4", "expected 4", "found 5"],
    );
    assert_refused(&with("*ELEMENT, TYPE=C3D4\n2, 1, 2, 3, 7\n"), &["line 9", "`7`"]);
    assert_refused(&with("*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n"), &["not used yet", "`1`"]);
    assert_refused(&with("*NODE\n1, 0, 0, 0\n"), &["not used yet"]);
    assert_refused(&with("*NODE, SYSTEM=C\n5, 0, 0, 0\n"), &["Cartesian"]);
    assert_refused(&with("*NODE\n5, 0, x, 0\n"), &["line 9", "a coordinate", "`x`"]);
    assert_refused(
        "*PART, NAME=a\n*END PART\n*PART, NAME=b\n*END PART\n",
        &["line 3", "second", "*PART", "flat file"],
    );
    // Nodes of the assembly are none of the mesh.
    assert_refused("*ASSEMBLY\n*NODE\n1, 0, 0, 0\n", &["*NODE with its nodes"]);
    assert_refused("*HEADING\n", &["*NODE"]);
    assert_refused("** nothing\n1, 2\n", &["line 2", "a keyword such as *NODE"]);
    assert_refused("*NODE\n1, 0, 0, 0\n", &["no tetrahedra"]);
}

#[test]
fn names_in_latin_1_stay_apart() {
    let latin = |text: String| text.chars().map(|letter| letter as u8).collect::<Vec<u8>>();
    let text = format!("{CORNER}*NSET, NSET=Lamé\n1\n*NSET, NSET=Lamè\n2\n");
    let mesh = parse_mesh::<4>("test", &latin(text)).unwrap().0;
    assert_eq!((&mesh.node_sets["Lamé"][..], &mesh.node_sets["Lamè"][..]), (&[0][..], &[1][..]));
    let gmsh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n0 1 \"Lamé\"\n$EndPhysicalNames\n\
        $Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
        $Elements\n2\n1 15 2 1 1 2\n2 4 2 2 2 1 2 3 4\n$EndElements\n";
    let mesh = parse_mesh::<4>("test", &latin(gmsh.into())).unwrap().0;
    assert_eq!(mesh.node_sets["Lamé"], [1]);
}
