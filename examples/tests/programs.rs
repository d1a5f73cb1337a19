//! Runs the example programs as a reader would, on small cases.

use sinew_mesh::{Field, box_tetrahedra, write_vtu};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Cargo puts examples beside the tests it builds: `deps/this-test` and `examples/name`.
fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a running program has a path");
    let folder = test.ancestors().nth(2).expect("Cargo's folders are nested").join("examples");
    let path = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(path.exists(), "build the examples first: cargo build -p sinew-examples --examples");
    path
}

/// What a program printed; `Err` when it failed.
fn run(name: &str, folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let mut command = Command::new(program(name));
    let output = command.current_dir(folder).args(arguments).output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}

/// The case that comes with the examples, edited; every edit must apply.
fn write_case(folder: &Path, edits: &[(&str, &str)]) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/hanging_bar.toml");
    let mut text = std::fs::read_to_string(path).unwrap();
    for (from, to) in edits {
        assert!(text.contains(from), "the case no longer holds {from:?}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join("case.toml"), text).unwrap();
}

#[test]
fn an_emulator_is_trained_stored_and_asked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_case(folder, &[("steps = 3000", "steps = 100")]);
    let early = run("predict_batch", folder, &["case.toml"]).unwrap_err();
    assert!(early.contains("run train_emulator"), "{early}");

    run("train_emulator", folder, &["case.toml"]).unwrap();
    let (mesh, _) =
        sinew_mesh::read_tet_mesh(folder.join("out/hanging_bar/prediction.vtu")).unwrap();
    for field in ["u_emulator", "u_fem"] {
        assert_eq!(mesh.point_fields[field].components, 3);
    }
    let report = run("predict_batch", folder, &["case.toml", "7"]).unwrap();
    assert!(report.contains("7 parameter sets, 81 nodes"), "{report}");
}

#[test]
fn ones_own_mesh_is_read_beside_its_case() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A pad held at its four sides, so that the rim of its top is held, too.
    let mut mesh = box_tetrahedra([6.0, 6.0, 2.0], [4, 4, 2]);
    let side = |x: &[f64; 3]| [0.0, 6.0].iter().any(|edge| x[0] == *edge || x[1] == *edge);
    let held = mesh.points.iter().map(|x| f64::from(u8::from(side(x)))).collect();
    mesh.point_fields.insert("held".into(), Field::scalars(held));
    write_vtu(folder.join("organ.vtu"), &mesh).unwrap();
    let generated = "box = { extent = [30.0, 6.0, 6.0], cells = [8, 2, 2] }";
    let edits = [
        (generated, "file = \"organ.vtu\""),
        ("clamped = \"x_min\"", "clamped = \"held\""),
        ("body_force = [0.0, 0.0, -9.8e-3]", "pressure = { facets = \"z_max\", value = 2.0 }"),
        ("\"pi\"   ", "\"dd\"   "),
        ("steps = 3000", "steps = 50"),
    ];
    write_case(folder, &edits);
    run("train_emulator", folder, &["case.toml"]).unwrap();
    let (mesh, _) =
        sinew_mesh::read_tet_mesh(folder.join("out/hanging_bar/prediction.vtu")).unwrap();
    let pressed = mesh.point_fields["u_fem"].to_f64().iter().fold(0.0f64, |most, u| most.max(-u));
    assert!(pressed > 0.1, "a pressure of 2 kPa presses soft tissue in, not by {pressed} mm");
}

#[test]
fn the_smaller_programs_run() {
    let folder = tempfile::tempdir().unwrap();
    let solved = run("solve_beam", folder.path(), &["beam.vtu"]).unwrap();
    assert!(solved.contains("stable: true"), "{solved}");
    let quality = run("mesh_quality", folder.path(), &["beam.vtu"]).unwrap();
    assert!(quality.contains("node set \"x_min\": 30 nodes"), "{quality}");
}

#[test]
fn help_explains_and_mistakes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let help = run("train_emulator", folder.path(), &["--help"]).unwrap();
    assert!(help.contains("usage") && help.contains("[training]"), "{help}");
    write_case(folder.path(), &[("latent = 16", "latnet = 16")]);
    let error = run("train_emulator", folder.path(), &["case.toml"]).unwrap_err();
    assert!(error.contains("latnet") && error.contains("case.toml"), "{error}");
}
