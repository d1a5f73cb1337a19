//! Mesh files that a reader changes: what the program says, and what it computes then.

use std::path::Path;
use std::process::Command;

/// A block of two by one by one cells of 10 mm, six tetrahedra each, as text.
fn block() -> sinew_mesh::TetMesh {
    sinew_mesh::box_tetrahedra([20.0, 10.0, 10.0], [2, 1, 1])
}

/// A legacy VTK file of tetrahedra and labelled triangles, with more text behind.
fn vtk(mesh: &sinew_mesh::TetMesh, triangles: &[([usize; 3], i32)], data: &str) -> String {
    let cells = mesh.cells.len() + triangles.len();
    let points: String = mesh.points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let tetrahedra = mesh.cells.iter().map(|[a, b, c, d]| format!("4 {a} {b} {c} {d}\n"));
    let sides = triangles.iter().map(|([a, b, c], _)| format!("3 {a} {b} {c}\n"));
    let listed: String = tetrahedra.chain(sides).collect();
    let labels = triangles.iter().map(|(_, label)| format!("{label}\n"));
    format!(
        "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n{points}CELLS {cells} {}\n{listed}\
         CELL_TYPES {cells}\n{}{}CELL_DATA {cells}\nSCALARS region int 1\nLOOKUP_TABLE default\n{}{}{data}",
        mesh.points.len(),
        5 * mesh.cells.len() + 4 * triangles.len(),
        "10\n".repeat(mesh.cells.len()),
        "5\n".repeat(triangles.len()),
        "0\n".repeat(mesh.cells.len()),
        labels.collect::<String>(),
    )
}

const CASE: &str = r#"
law = "neo-hookean"
loads = [{ traction = [0.05, 0.0, -0.02], facets = "region:2" }]
supports = [{ clamped = "left" }]
mesh.file = "block.vtk"
parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
select.left.plane = { point = [0.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
"#;

/// Exit code, the line of the displacement, and all that is said.
fn solved(folder: &Path, case: &str, mesh: &str) -> (Option<i32>, String, String) {
    std::fs::write(folder.join("case.toml"), case).unwrap();
    std::fs::write(folder.join("block.vtk"), mesh).unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_sinew"))
        .args(["solve", "case.toml", "--theta", "mu=10,lambda=12"])
        .current_dir(folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&[done.stdout, done.stderr].concat()).into_owned();
    let line = text.lines().find(|line| line.contains("displacement mean")).unwrap_or_default();
    (done.status.code(), line.to_string(), text)
}

fn right(mesh: &sinew_mesh::TetMesh) -> Vec<([usize; 3], i32)> {
    mesh.facet_sets["x_max"].iter().map(|&facet| (mesh.facet_nodes(facet), 2)).collect()
}

#[test]
fn changes_of_a_file_are_said_and_do_not_change_the_answer() {
    let (folder, mesh) = (tempfile::tempdir().unwrap(), block());
    let sides = right(&mesh);
    let solve = |case: &str, mesh: &str| solved(folder.path(), case, mesh);
    let (code, expected, said) = solve(CASE, &vtk(&mesh, &sides, ""));
    assert!(code == Some(0) && !expected.is_empty(), "{said}");
    assert!(!said.contains("block.vtk"), "{said}");

    // A node of no cell on the plane of the support, and one a kilometre away.
    let mut loose = mesh.clone();
    loose.points.extend([[0.0, 3.0, 3.0], [1e6, 0.0, 0.0]]);
    let (code, line, said) = solve(CASE, &vtk(&loose, &sides, ""));
    assert_eq!((code, &line), (Some(0), &expected), "{said}");
    assert!(said.contains("block.vtk: 2 nodes of no cell left out"), "{said}");

    // Cells that do not share their nodes.
    let mut apart = mesh.clone();
    apart.points.extend(&mesh.points);
    let half = mesh.cells.len() / 2;
    apart.cells[half..].iter_mut().flatten().for_each(|node| *node += mesh.points.len());
    let moved: Vec<_> =
        sides.iter().map(|(n, label)| (n.map(|node| node + mesh.points.len()), *label)).collect();
    let text = vtk(&apart, &moved, "");
    let (_, line, said) = solve(CASE, &text);
    assert_ne!(line, expected);
    assert!(said.contains("warning: block.vtk: 4 nodes at the place of another"), "{said}");
    assert!(said.contains("merge = true under [mesh]"), "{said}");
    let (code, line, said) = solve(&format!("{CASE}mesh.merge = true\n"), &text);
    assert_eq!((code, &line), (Some(0), &expected), "{said}");
    assert!(said.contains("block.vtk: 4 nodes merged"), "{said}");
    let made = CASE.replace(
        "file = \"block.vtk\"",
        "box = { extent = [20, 10, 10], cells = [2, 1, 1] }\nmesh.merge = true",
    );
    let (code, _, said) = solve(&made, &text);
    assert!(code == Some(2) && said.contains("mesh.merge: nodes of a file are merged"), "{said}");
}

#[test]
fn loads_on_facets_of_no_cell_are_told_with_their_number() {
    let (folder, mesh) = (tempfile::tempdir().unwrap(), block());
    let solve = |sides: &[_]| solved(folder.path(), CASE, &vtk(&mesh, sides, ""));
    let all = right(&mesh);
    let [a, b] = [all[0].0, all[1].0];
    let alone = |of: [usize; 3], other: [usize; 3]| of.into_iter().find(|n| !other.contains(n));
    let ends = [alone(a, b).unwrap(), alone(b, a).unwrap()];
    let flipped = a.into_iter().filter(|node| b.contains(node)).map(|n| ([ends[0], ends[1], n], 2));
    let flipped: Vec<_> = flipped.collect();
    let (code, _, said) = solve(&[all[0], flipped[0]]);
    let told = "warning: block.vtk: 1 element of the boundary left out, not faces of cells, `region:2` lacks 1";
    assert!(code == Some(0) && said.contains(told), "{said}");
    // With none left there is no set; what was left out is said all the same.
    let (code, _, said) = solve(&flipped);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("2 elements of the boundary left out"), "{said}");
}

#[test]
fn marks_of_supports_are_numbers_and_mark_their_nodes_alone() {
    let (folder, mesh) = (tempfile::tempdir().unwrap(), block());
    let sides = right(&mesh);
    let field = |off: &str| {
        let marks = mesh.points.iter().map(|x| if x[0] == 0.0 { "1.0 " } else { off });
        let marks: String = marks.collect();
        format!("POINT_DATA 12\nSCALARS held double\nLOOKUP_TABLE default\n{marks}\n")
    };
    let solve = |case: &str, data: &str| solved(folder.path(), case, &vtk(&mesh, &sides, data));
    let marked = CASE.replace("clamped = \"left\"", "clamped = \"held\"");
    let marked = marked.replace("select.left", "select.unread");
    let marked: String =
        marked.lines().filter(|l| !l.contains("unread")).map(|l| format!("{l}\n")).collect();
    let (_, expected, _) = solve(CASE, "");
    assert_eq!(solve(&marked, &field("0.0 ")).1, expected);
    let (code, _, said) = solve(&marked, &field("nan "));
    assert!(code == Some(2) && said.contains("`held` is NaN at node 1"), "{said}");
    // In quadratic cells a node in the middle of an edge is held where both of its ends are.
    let quadratic = |case: &str| format!("formulation = \"quadratic\"\n{case}");
    let (_, expected, _) = solve(&quadratic(CASE), "");
    assert_eq!(solve(&quadratic(&marked), &field("0.0 ")).1, expected);
}

#[test]
fn colours_in_text_are_factors_from_0_to_255() {
    let (folder, mesh) = (tempfile::tempdir().unwrap(), block());
    let sides = right(&mesh);
    let case = format!("stiffness = {{ field = \"k\" }}\n{CASE}");
    let solve = |case: &str, data: &str| solved(folder.path(), case, &vtk(&mesh, &sides, data));
    let (_, expected, _) = solve(CASE, "");
    let count = mesh.cells.len() + sides.len();
    let shares = "0.00392157 ".repeat(count);
    assert_eq!(solve(&case, &format!("COLOR_SCALARS k 1\n{shares}\n")).1, expected);
    let ones = "1 ".repeat(count);
    assert_eq!(
        solve(&case, &format!("SCALARS k unsigned_char 1\nLOOKUP_TABLE default\n{ones}\n")).1,
        expected
    );
}

#[test]
fn a_name_of_sets_of_several_kinds_is_refused_where_they_differ() {
    let (folder, mesh) = (tempfile::tempdir().unwrap(), block());
    let sides = right(&mesh);
    // The cells of the label 0 are named by their field, the nodes by another.
    let marks: String =
        mesh.points.iter().map(|x| format!("{}\n", i32::from(x[0] == 0.0))).collect();
    let data = format!(
        "SCALARS cell_set:held int\nLOOKUP_TABLE default\n{}POINT_DATA {}\nSCALARS node_set:held int\nLOOKUP_TABLE default\n{marks}",
        "1\n".repeat(mesh.cells.len() + sides.len()),
        mesh.points.len()
    );
    let case = CASE.replace("clamped = \"left\"", "clamped = \"held\"");
    let case =
        case.lines().filter(|line| !line.starts_with("select")).collect::<Vec<_>>().join("\n");
    let (code, _, said) = solved(folder.path(), &case, &vtk(&mesh, &sides, &data));
    assert!(code == Some(2) || code == Some(1), "{said}");
    assert!(said.contains("`held` is a set of 4 nodes and one of 12 cells elsewhere"), "{said}");
}

#[test]
fn parts_that_touch_or_overlap_without_common_nodes_are_told() {
    const HELD: &str = r#"
law = "neo-hookean"
loads = [{ body_force = [0.0, 0.0, -0.01] }]
supports = [{ clamped = "ends" }]
mesh.file = "block.vtk"
parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
[select.ends]
any = [{ plane = { point = [0, 0, 0], normal = [1, 0, 0] } }, { nearest = [40, 0, 0] }, { nearest = [40, 10, 0] }, { nearest = [40, 0, 10] }, { box = { min = [8, 3, 3], max = [9, 9, 9] } }]
"#;
    let folder = tempfile::tempdir().unwrap();
    let said = |by: [f64; 3], size: f64| {
        let (mut mesh, mut other) =
            (block(), sinew_mesh::box_tetrahedra([20.0, 10.0, 10.0], [4, 2, 2]));
        let step = mesh.points.len();
        other.points.iter_mut().for_each(|x| (0..3).for_each(|i| x[i] = size * x[i] + by[i]));
        mesh.points.append(&mut other.points);
        mesh.cells.extend(other.cells.iter().map(|cell| cell.map(|node| node + step)));
        let (code, _, text) = solved(folder.path(), HELD, &vtk(&mesh, &[], ""));
        assert_eq!(code, Some(0), "{text}");
        text
    };
    let touching = said([20.0, 0.0, 0.0], 1.0);
    assert!(touching.contains("5 of its nodes lie on cells"), "{touching}");
    assert!(!touching.contains("passes through itself"), "{touching}");
    let overlapping = said([13.0, 1.0, 2.0], 1.0);
    assert!(overlapping.contains("passes through itself"), "{overlapping}");
    let apart = said([30.0, 0.0, 0.0], 1.0);
    assert!(!apart.contains("lie on cells") && !apart.contains("passes through"), "{apart}");
    assert!(!apart.contains("lie inside others"), "{apart}");
    let inside = said([8.1, 3.2, 3.3], 0.2);
    assert!(inside.contains("parts of it lie inside others"), "{inside}");
}
