//! CARP meshes: the files of the manual by hand, sets by the names of files, meshes of ours there and back, errors with file and
//! line, damaged files, and the time of a large mesh.

use crate::carp_files::write_carp;
use crate::damage::damaged;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use sinew_mesh::{
    AnyMesh, Field, HexMesh, Mesh, MeshError, TetMesh, box_hexahedra, box_tetrahedra,
    enclosed_volume, read, read_mesh, rectangle_triangles,
};
use std::cell::Cell;
use std::path::Path;
use tempfile::TempDir;

/// Two tetrahedra on one triangle, of two regions.
const FILES: [(&str, &str); 3] = [
    ("heart.pts", "5\n0 0 0\n1000 0 0\n0 1000 0\n0 0 1000\n0 0 -500.5\n"),
    ("heart.elem", "2\nTt 0 1 2 3 7\nTt 0 2 1 4 10\n"),
    ("heart.lon", "1\n1 0 0\n0 0 0\n"),
];

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The files above, of which some are replaced, and others.
fn with(others: &[(&str, &str)]) -> TempDir {
    let folder = folder(&FILES);
    others.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    folder
}

fn tets(folder: &TempDir) -> TetMesh {
    read_mesh::<4>(folder.path().join("heart")).unwrap().0
}

#[test]
fn any_of_its_files_or_the_bare_name_opens_a_mesh() {
    let folder = with(&[]);
    for name in ["heart.pts", "heart.elem", "heart.lon", "heart"] {
        let (mesh, report) = read(folder.path().join(name)).unwrap();
        assert_eq!(mesh.points()[4], [0.0, 0.0, -0.5005]);
        assert_eq!(mesh.cells(), [0, 1, 2, 3, 0, 2, 1, 4]);
        assert_eq!(mesh.names_of_cells(), ["region:7", "region:10"]);
        assert_eq!(
            (mesh.cells_of("region:10"), mesh.cells_of("7")),
            (Some(vec![1]), Some(vec![0]))
        );
        let fibres = Field::vectors(&[[1.0, 0.0, 0.0], [0.0; 3]]);
        assert_eq!(mesh.cell_fields()["fibre"], fibres);
        let said = [
            "fibres of 1 of 2 elements, which are zero, left out",
            "coordinates converted to mm from µm, the unit of CARP",
        ];
        let said = said.map(String::from).to_vec();
        assert_eq!((report.changes(), report.warnings().len()), (said, 0));
    }
    // A folder of that name is no obstacle, nor is a dot in it.
    std::fs::create_dir(folder.path().join("heart")).unwrap();
    assert!(read(folder.path().join("heart")).is_ok());
    for ending in ["pts", "elem"] {
        let from = folder.path().join(format!("heart.{ending}"));
        std::fs::copy(from, folder.path().join(format!("heart.v2.{ending}"))).unwrap();
    }
    assert!(read(folder.path().join("heart.v2")).unwrap().0.cell_fields().len() == 1);
}

#[test]
fn line_ends_and_forms_of_numbers_do_not_matter() {
    let folder = with(&[
        ("heart.pts", "5\r\n0 0 0\r\n\r\n1e3 0 0\r\n0 1.0E+3 0\r\n0 0 1000\r\n0 0 -500.5\r\n\r\n"),
        ("heart.elem", "2\nTt 0 1 2 3\r\nTt\t0 2 1 4"),
        ("heart.lon", "2\n1 0 0 0 1 0\n0 0 1 1 0 0"),
    ]);
    let mesh = tets(&folder);
    assert_eq!(mesh.points, tets(&with(&[])).points);
    assert_eq!(mesh.cell_fields.keys().collect::<Vec<_>>(), ["fibre", "sheet"]);
    let sheets = Field::vectors(&[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_eq!(mesh.cell_fields["sheet"], sheets);
    std::fs::remove_file(folder.path().join("heart.lon")).unwrap();
    assert!(tets(&folder).cell_fields.is_empty());
}

#[test]
fn surfaces_and_vertices_are_named_by_their_files() {
    let folder = with(&[
        ("heart.base.surf", "1\nTr 1 0 3 1.5\n"),
        ("heart.surf", "2\nTr 0 3 2\nTr 4 3 2\n"),
        ("apex.surf.vtx", "2\nextra\n4\n4\n"),
        ("pacing.vtx", "2\nintra\n3\n0\n"),
    ]);
    let (mesh, report) = read_mesh::<4>(folder.path().join("heart.pts")).unwrap();
    let names = ["base", "heart"];
    assert_eq!(mesh.facet_sets.keys().collect::<Vec<_>>(), names);
    let corners = names.map(|name| mesh.nodes_of_facets(&mesh.facet_sets[name]));
    assert_eq!(corners, [vec![0, 1, 3], vec![0, 2, 3]]);
    assert_eq!((&mesh.node_sets["apex"], &mesh.node_sets["pacing"]), (&vec![4], &vec![0, 3]));
    assert!(report.warnings()[0].contains("`heart` lacks 1"), "{report:?}");
    assert_eq!(mesh.cell_fields["fibre"].rows(), 2);
    // Beside another mesh only files of the mesh's name are its own.
    std::fs::write(folder.path().join("fine.pts"), "0\n").unwrap();
    let (mesh, _) = read_mesh::<4>(folder.path().join("heart.elem")).unwrap();
    assert!(mesh.facet_sets.len() == 2 && mesh.node_sets.is_empty());
}

#[test]
fn elements_of_lower_dimension_are_sets_by_their_labels() {
    let elements = "5\nTt 0 1 2 3 7\nTr 1 0 3 20\nLn 0 3 21\nTt 0 2 1 4 10\nCx 3 2 21\n";
    let folder =
        with(&[("heart.elem", elements), ("heart.lon", "1\n1 0 0\n0 0 0\n0 0 0\n0 1 0\n0 0 0")]);
    let (mesh, report) = read_mesh::<4>(folder.path().join("heart")).unwrap();
    assert_eq!(mesh.nodes_of_facets(&mesh.facet_sets["region:20"]), [0, 1, 3]);
    assert_eq!(mesh.node_sets["region:21"], [0, 2, 3]);
    assert_eq!(mesh.cell_fields["fibre"].to_f64(), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0].as_slice());
    assert_eq!((report.dropped_cells, report.matched_facets), (2, 1));
}

/// Sets, labels and directions on every kind of linear cell.
fn told<const N: usize>(mut mesh: Mesh<N>) -> Mesh<N> {
    let cells = mesh.cells.len();
    let label = |cell: usize| cell as i64 % 3 - 1;
    let fibre = |cell: usize| [cell as f64 / 7.0, 1.0, -0.1];
    mesh.cell_fields.insert("region".into(), Field::labels((0..cells).map(label).collect()));
    let rows: Vec<_> = (0..cells).map(fibre).collect();
    mesh.cell_fields.insert("fibre".into(), Field::vectors(&rows));
    let rows: Vec<_> = rows.iter().map(|[x, y, z]| [-y, *x, z / 3.0]).collect();
    mesh.cell_fields.insert("sheet".into(), Field::vectors(&rows));
    mesh.points.iter_mut().for_each(|x| *x = x.map(|x| (1e6 * (x + 0.1) / 3.0).round() / 1e6));
    mesh
}

#[test]
fn meshes_of_ours_come_back_as_they_went() {
    fn check<const N: usize>(mesh: Mesh<N>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("body");
        write_carp(&path, &mesh);
        let (again, report) = read_mesh::<N>(&path).unwrap();
        assert_eq!(again, mesh);
        assert_eq!(report.repaired_cells, 0);
    }
    check(told(box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2])));
    check(told(box_hexahedra([3.0, 2.0, 1.0], [3, 2, 2])));
    let mut plate = told(rectangle_triangles([2.0, 1.0], [4, 2]));
    plate.facet_sets.clear();
    plate.points.iter_mut().for_each(|x| x[2] = 0.0);
    check(plate);
}

#[test]
fn hexahedra_are_numbered_as_the_manual_has_them() {
    // The upper side goes round the other way: 4 is above 0, 5 above 3, 6 above 2, 7 above 1.
    let points = "8\n0 0 0\n2000 0 0\n2000 1000 0\n0 1000 0\n0 0 1000\n0 1000 1000\n2000 1000 1000\n2000 0 1000\n";
    let folder = folder(&[
        ("cube.pts", points),
        ("cube.elem", "1\nHx 0 1 2 3 4 5 6 7 1\n"),
        ("top.surf", "1\nQd 4 5 6 7\n"),
    ]);
    let (mesh, report): (HexMesh, _) = read_mesh::<8>(folder.path().join("cube")).unwrap();
    assert_eq!(report.repaired_cells, 0);
    let volume = enclosed_volume(&mesh, &sinew_mesh::boundary_facets(&mesh));
    assert!((volume - 2.0).abs() < 1e-12, "{volume}");
    assert_eq!(mesh.nodes_of_facets(&mesh.facet_sets["top"]), [4, 5, 6, 7]);
}

#[test]
fn errors_name_file_line_and_way_out() {
    let cases: [(&str, &str, &[&str]); 18] = [
        ("heart.pts", "6\n0 0 0\n", &["heart.pts", "the declared count is wrong"]),
        ("heart.pts", "1\n0 0 0\n1 1 1\n", &["heart.pts, line 3", "no more rows", "`1`"]),
        ("heart.pts", "5\n0 0 0\n1 nan 0\n", &["heart.pts, line 3", "finite", "NaN"]),
        ("heart.pts", "5\n0 0 0\n1 0\nx", &["heart.pts, line 4", "finite", "`x`"]),
        ("heart.pts", "", &["heart.pts", "the number of points"]),
        (
            "heart.elem",
            "2\nTt 0 1 2 3 7\nTt 0 2 1 5 10\n",
            &["heart.elem, line 3", "a node is 5", "0..=4"],
        ),
        (
            "heart.elem",
            "2\nTt 0 1 2 3 7\nTt 0 2 1 -1 10\n",
            &["heart.elem, line 3", "a node is -1"],
        ),
        ("heart.elem", "1\nTt 0 1 2 3 LV\n", &["heart.elem, line 2", "integer label", "`LV`"]),
        ("heart.elem", "1\nOc 0 1 2 3 4 5 1\n", &["heart.elem, line 2", "`Oc`", "Tt, Hx"]),
        (
            "heart.elem",
            "2\nTt 0 1 2 3 7\nPy 0 1 2 3 4 7\n",
            &["heart.elem, line 3", "`Py`", "split"],
        ),
        ("heart.elem", "1\nTt 0 1 1 3 7\n", &["heart.elem", "cell 0 names node 1 twice"]),
        ("heart.elem", "1\nLn 0 1 7\n", &["heart.elem", "no tetrahedra"]),
        (
            "heart.lon",
            "1\n1 0 0\n",
            &["heart.lon", "components per element", "the declared count is wrong or"],
        ),
        ("heart.lon", "3\n1 0 0\n", &["heart.lon, line 1", "1 or 2 directions", "`3`"]),
        ("heart.lon", "2\n1 0 0 0 1 0\n1 0 0\n", &["heart.lon", "components per element"]),
        ("base.surf", "2\nTr 0 1 3\n", &["base.surf", "an element"]),
        ("base.surf", "1\nTt 0 1 2 3\n", &["base.surf, line 2", "a Tr or Qd"]),
        ("apex.vtx", "2\nintra\n3\n", &["apex.vtx", "a node"]),
    ];
    for (name, text, parts) in cases {
        let folder = with(&[(name, text)]);
        if name == "heart.elem" {
            std::fs::remove_file(folder.path().join("heart.lon")).unwrap();
        }
        let error = read(folder.path().join("heart")).unwrap_err().to_string();
        parts.iter().for_each(|part| assert!(error.contains(part), "{name} {text:?}: {error}"));
    }
    let folder = folder(&FILES[..1]);
    let error = read(folder.path().join("heart")).unwrap_err();
    let MeshError::File { path, .. } = error else { panic!("{error}") };
    assert!(path.ends_with("heart.elem"));
}

/// Damaged meshes for each of five files.
const CASES: u32 = 4_000;

#[test]
fn damaged_files() {
    let names = ["heart.pts", "heart.elem", "heart.lon", "base.surf", "apex.vtx"];
    let folder = with(&[
        ("heart.elem", "3\nTt 0 1 2 3 7\nTr 0 1 3 4\nTt 0 2 1 4 10\n"),
        ("heart.lon", "2\n1 0 0 0 1 0\n0 0 0 0 0 0\n0 1 0 0 0 1\n"),
        ("base.surf", "2\nTr 1 0 3\nTr 0 3 2\n"),
        ("apex.vtx", "2\nextra\n4\n3\n"),
    ]);
    let well = Cell::new(0);
    for name in names {
        let path = folder.path().join(name);
        let sound = std::fs::read(&path).unwrap();
        let config =
            ProptestConfig { cases: CASES, failure_persistence: None, ..Default::default() };
        let answers = TestRunner::new(config).run(&damaged(vec![sound.clone()]), |bytes| {
            std::fs::write(&path, &bytes).unwrap();
            match read(folder.path().join("heart")) {
                Ok((mesh, _)) => {
                    well.set(well.get() + 1);
                    prop_assert_eq!(mesh.check(), Ok(()));
                }
                Err(error) => {
                    let error = error.to_string();
                    prop_assert!(names.iter().any(|name| error.contains(name)), "{}", error);
                }
            }
            Ok(())
        });
        answers.unwrap();
        std::fs::write(&path, sound).unwrap();
    }
    // Neither are all of them refused, nor none.
    assert!((100..15_000).contains(&well.get()), "{}", well.get());
}

#[test]
fn a_hundred_thousand_tetrahedra_are_read_in_two_seconds() {
    let mesh = told(box_tetrahedra([1.0; 3], [26; 3]));
    assert!(mesh.cells.len() > 100_000);
    let folder = tempfile::tempdir().unwrap();
    write_carp(folder.path().join("large"), &mesh);
    let start = std::time::Instant::now();
    let (again, _) = read(folder.path().join("large")).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    println!("{} tetrahedra read in {seconds:.2} s", again.cell_count());
    assert_eq!(again, AnyMesh::from(mesh));
    assert!(seconds < 2.0, "{seconds} s");
}

#[test]
fn a_relative_name_finds_the_files_beside_it() {
    // `heart` alone has no folder in its path.
    assert!(!Path::new("heart.surf").exists());
    let error = read("no such heart").unwrap_err().to_string();
    assert!(error.starts_with("no such heart: "), "{error}");
}

#[test]
fn files_of_another_mesh_whose_name_begins_alike_are_its_own() {
    let folder = with(&[
        ("heart.lv.pts", "1\n0 0 0\n"),
        ("heart.lv.endo.surf", "1\nTr 0 1 9\n"),
        ("heart.base.surf", "1\nTr 0 1 3\n"),
    ]);
    assert_eq!(tets(&folder).facet_sets.keys().collect::<Vec<_>>(), ["base"]);
}
