//! A heart of four chambers with blood, as CARP files hold it: its ventricles are cut out, their surfaces named by pairs of labels, and
//! inflated; against the same wall made and named by place.

use crate::carp_files::write_carp;
use sinew::{Body, Case, Options, Solver};
use sinew_mesh::{Field, TetMesh, box_tetrahedra, enclosed_volume, read_mesh};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Edge of a cube \[mm\].
const EDGE: f64 = 10.0;

/// The label of a cube: walls of ventricles and atria 1 to 4, left before right, and their blood 11 to 14.
fn label(x: usize, y: usize, z: usize) -> i64 {
    let chamber = 1 + i64::from(x >= 4) + 2 * i64::from(z >= 4);
    let is_blood = (1..=2).contains(&(x % 4)) && (1..=3).contains(&y) && (1..=6).contains(&z);
    if is_blood { chamber + 10 } else { chamber }
}

/// Fibres of the ventricles, none elsewhere.
fn heart() -> TetMesh {
    let mut heart = box_tetrahedra([8, 5, 8].map(|n| EDGE * n as f64), [8, 5, 8]);
    let cube = |cell: &[usize; 4]| {
        let centre = |axis| cell.iter().map(|&node| heart.points[node][axis]).sum::<f64>() / 4.0;
        [0, 1, 2].map(|axis| (centre(axis) / EDGE) as usize)
    };
    let labels: Vec<i64> = heart.cells.iter().map(cube).map(|[x, y, z]| label(x, y, z)).collect();
    let fibre = |&label: &i64| if label <= 2 { [0.6, 0.8, 0.0] } else { [0.0; 3] };
    let fibres: Vec<_> = labels.iter().map(fibre).collect();
    heart.cell_fields.insert("fibre".into(), Field::vectors(&fibres));
    heart.cell_fields.insert("region".into(), Field::labels(labels));
    heart.node_sets.clear();
    heart.facet_sets.clear();
    heart
}

/// The wall of the ventricles, with surfaces by where they are.
fn ventricles() -> TetMesh {
    let heart = heart();
    let labels = heart.cell_fields["region"].to_f64().into_owned();
    let kept: Vec<usize> = (0..labels.len()).filter(|&cell| labels[cell] <= 2.0).collect();
    let mut wall = TetMesh { points: heart.points.clone(), ..TetMesh::default() };
    wall.cells = kept.iter().map(|&cell| heart.cells[cell]).collect();
    wall.cell_fields.insert("fibre".into(), Field::vectors(&vec![[0.6, 0.8, 0.0]; kept.len()]));
    sinew_mesh::remove_unused_nodes(&mut wall);
    let within = |x: f64, least: f64, most: f64| (least..=most).contains(&x);
    for (name, from) in [("lv", 10.0), ("rv", 50.0)] {
        let on = |[x, y, z]: [f64; 3]| {
            within(x, from, from + 20.0) && within(y, 10.0, 40.0) && within(z, 10.0, 40.0)
        };
        wall.name_facets(name, on);
    }
    wall.name_nodes("valves", |[_, _, z]| z == 40.0);
    wall
}

const LAW: &str = r#"
law = { name = "guccione", bulk_modulus = 25.0 }
supports = [{ clamped = "valves" }]
loads = [{ pressure = "p", facets = "lv" }, { pressure = "1.5 mmHg", facets = "rv" }]
fibres.field = "fibre"
parameters = { C = [1.0, 2.0], b_f = 8.0, b_t = 3.0, b_fs = 4.0, p = { range = [2.0, 8.0], unit = "mmHg" } }
"#;

const CUT: &str = r#"
[mesh]
file = "heart"
keep = ["region:1", 2]
[select]
lv.between = ["region:1", "region:11"]
rv.between = [12, 2]
valves.any = [{ between = [1, 3] }, { between = [2, 4] }]
"#;

fn written(folder: &Path, case: &str) -> PathBuf {
    write_carp(folder.join("heart"), &heart());
    let file = folder.join("case.toml");
    std::fs::write(&file, case).unwrap();
    file
}

fn inflated(body: &Body) -> Vec<f64> {
    Solver::new(body).unwrap().solve(&body.centre(), &Options::default()).unwrap().displacement
}

#[test]
fn ventricles_cut_out_of_a_heart_inflate_like_a_wall_made_alone() {
    let folder = tempfile::tempdir().unwrap();
    let cut = Case::read(&written(folder.path(), &format!("{LAW}{CUT}"))).unwrap().body().unwrap();
    let made = Case::parse(&format!("{LAW}[mesh]"), "made").unwrap().on(ventricles().into());
    let made = made.body().unwrap();
    assert_eq!(cut.positions, made.positions);
    let (cut, made) = (inflated(&cut), inflated(&made));
    let norm = |u: &[f64]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart: Vec<f64> = cut.iter().zip(&made).map(|(a, b)| a - b).collect();
    println!("norm of the displacement {} mm, apart by {}", norm(&made), norm(&apart));
    assert!(norm(&made) > 1.0 && norm(&apart) < 1e-9 * norm(&made));
}

#[test]
fn surfaces_by_labels_have_the_areas_of_the_cubes() {
    let folder = tempfile::tempdir().unwrap();
    let (mut heart, _) = {
        write_carp(folder.path().join("heart"), &heart());
        read_mesh::<4>(folder.path().join("heart")).unwrap()
    };
    heart.keep(&["1", "2"]).unwrap();
    let between = |one: &str, other: &str| sinew_mesh::Selection::between(one, other);
    // In squares of two triangles.
    for (one, other, squares) in [
        ("1", "11", 36),
        ("2", "12", 36),
        ("1", "3", 14),
        ("1", "2", 20),
        ("1", "outside", 20 + 2 * 16 + 20),
    ] {
        let found = heart.select("found", &between(one, other)).unwrap().facets;
        assert_eq!(found, 2 * squares, "{one} {other}");
    }
    let volume = enclosed_volume(&heart, &sinew_mesh::boundary_facets(&heart)) / EDGE.powi(3);
    assert!((volume - (8 * 5 * 4 - 2 * 18) as f64).abs() < 1e-9, "{volume}");
}

#[test]
fn the_program_tells_units_fibres_and_cuts() {
    let folder = tempfile::tempdir().unwrap();
    let solve = |case: String, more: &[&str]| {
        written(folder.path(), &case);
        let done = Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(["solve", "case.toml", "--theta", "C=1.5,p=3"])
            .args(more)
            .current_dir(folder.path())
            .output()
            .unwrap();
        (
            done.status.code(),
            String::from_utf8_lossy(&[done.stdout, done.stderr].concat()).into_owned(),
        )
    };
    let whole = format!("{LAW}{CUT}");
    let (code, told) = solve(whole.clone(), &[]);
    assert_eq!(code, Some(0), "{told}");
    let said = [
        "coordinates converted to mm from µm, the unit of CARP",
        "fibres of 1176 of 1920 elements, which are zero, left out",
        "1176 of 1920 cells, which `keep` does not name, left out",
    ];
    said.iter().for_each(|said| assert!(told.contains(said), "{said}: {told}"));
    // By any file of the mesh, and with its unit said.
    let line = |text: &str| {
        text.lines().find(|line| line.contains("displacement mean")).unwrap().to_string()
    };
    for (case, more) in [
        (whole.replace("\"heart\"", "\"heart.elem\""), &[][..]),
        (whole.replace("\"heart\"", "\"none.vtk\""), &["--mesh", "heart.pts"][..]),
        (whole.replace("[select]", "unit = \"um\"\n[select]"), &[]),
    ] {
        let (code, again) = solve(case, more);
        assert_eq!((code, line(&again)), (Some(0), line(&told)), "{again}");
    }
    let refusals: [(String, &[&str]); 6] = [
        (
            whole.replace("keep = [\"region:1\", 2]", ""),
            &["fibres.field", "without length", "`keep` under [mesh]"],
        ),
        (
            whole.replace("\"region:1\", 2]", "\"LV\"]"),
            &["mesh.keep", "no set of cells `LV`", "region:14"],
        ),
        (whole.replace("\"region:1\", 2]", "0.5]"), &["mesh.keep", "no set of cells `0.5`"]),
        (whole.replace("[12, 2]", "[2, 99]"), &["select.rv", "no set of cells `99`", "region:2"]),
        (
            whole.replace("[12, 2]", "[2, 3]"),
            &["select.rv", "surface between the regions holds 0 of"],
        ),
        (whole.replace("[12, 2]", "[2]"), &["select.rv.between", "1 value where 2 belong"]),
    ];
    for (case, parts) in refusals {
        let (code, told) = solve(case, &[]);
        assert_eq!(code, Some(2), "{told}");
        parts.iter().for_each(|part| assert!(told.contains(part), "{part}: {told}"));
    }
    let (_, told) = solve(whole.replace("[select]", "unit = \"mm\"\n[select]"), &[]);
    assert!(told.contains("the body is") && told.contains("say so: unit = \"um\""), "{told}");
    assert!(!told.contains("converted to mm"), "{told}");
    let (code, told) = solve(whole.replace("\"heart\"", "\"hart\""), &[]);
    assert!(code == Some(2) && told.contains("there is no file hart"), "{told}");
}

#[test]
fn a_plane_mesh_that_stands_upright_is_told_apart_from_a_surface() {
    for file in ["gmsh_plane_xz.msh", "abaqus_plane_xz.inp", "pyvista_plane_xz.vtu"] {
        let path = format!("{}/../../fixtures/writers/{file}", env!("CARGO_MANIFEST_DIR"));
        let case = format!(
            "law = \"linear-elastic\"\nsupports = [{{ clamped = \"left\" }}]\nmesh.file = \"{path}\"\n\
             parameters = {{ mu = [1.0, 2.0], lambda = [1.0, 2.0] }}\nselect.left.nearest = [0.0, 0.0, 0.0]\n"
        );
        let error = Case::parse(&case, "plate.toml").unwrap().body().unwrap_err().to_string();
        assert!(error.contains("a plane body lies in x–y"), "{error}");
    }
}
