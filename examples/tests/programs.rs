//! Runs the example programs as a reader would, on small cases.

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

#[test]
fn an_emulator_is_trained_stored_and_asked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let early = run("predict_batch", folder, &[]).unwrap_err();
    assert!(early.contains("run train_emulator"), "{early}");

    let trained = run("train_emulator", folder, &["auto"]).unwrap();
    assert!(trained.contains("regression was taken"), "{trained}");
    let (mesh, _) = sinew_mesh::read_tet_mesh(folder.join("out/bar/prediction.vtu")).unwrap();
    for field in ["u", "u_corrected"] {
        assert_eq!(mesh.point_fields[field].components, 3);
    }
    let report = run("predict_batch", folder, &["7"]).unwrap();
    assert!(report.contains("7 parameter sets, 81 nodes"), "{report}");
    let wrong = run("train_emulator", folder, &["magic"]).unwrap_err();
    assert!(wrong.contains("usage"), "{wrong}");
}

#[test]
fn the_smaller_programs_run() {
    let folder = tempfile::tempdir().unwrap();
    let solved = run("solve_beam", folder.path(), &["beam.vtu"]).unwrap();
    assert!(solved.contains("stable: true"), "{solved}");
    let quality = run("mesh_quality", folder.path(), &["beam.vtu"]).unwrap();
    assert!(quality.contains("node set \"x_min\": 30 nodes"), "{quality}");
}
