//! Mistakes on the command line, and the help of each command.

use crate::newcomer::{Faults, PLATE};
use std::path::Path;
use std::process::Command;

/// Exit code, standard output and standard error of the program in a folder.
fn sinew(folder: &Path, arguments: &str) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    let output = command.current_dir(folder).args(arguments.split_whitespace()).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// A box whose mesh names nothing.
fn plain_box() -> sinew_mesh::TetMesh {
    let mut mesh = sinew_mesh::box_tetrahedra([30.0, 20.0, 6.0], [2, 2, 1]);
    mesh.node_sets.clear();
    mesh.facet_sets.clear();
    mesh
}

/// Command lines that are wrong, and what must be said.
const COMMAND_LINES: [(&str, &[&str]); 61] = [
    ("", &["Usage: sinew <COMMAND>"]),
    ("slove plate.toml", &["slove", "'solve'"]),
    ("solve", &["<CASE>", "--help"]),
    ("solve plat.toml", &["plat.toml", "built-in scenes"]),
    ("solve OnceClampedBeem", &["did you mean `OnceClampedBeam`?"]),
    ("solve .", &["this is a folder", "name a case file"]),
    ("solve plate.toml --thetas mu=9", &["--thetas", "'--theta'"]),
    ("solve plate.toml --mesh none.vtk", &["no file none.vtk"]),
    ("solve plate.toml --mesh plate.toml", &["--mesh plate.toml: "]),
    ("solve plain.vtu", &["plain.vtu: this is the name of a mesh", "--mesh beside a case"]),
    (
        "solve plate.toml --mesh plain.vtu",
        &["loads.0.facets", "`z_min`", "facet sets of the mesh: none"],
    ),
    ("train plate.toml --minutes -1", &["budget", "-60", "give a positive"]),
    ("train plate.toml --minutes -1e-3", &["budget", "-0.06", "give a positive"]),
    ("train plate.toml --target -1e-3", &["target of a regression is -0.001"]),
    ("plan plate.toml --accuracy -1e-3", &["accuracy", "-0.001", "from 1e-10 to 0.5"]),
    ("predict plate.toml --accuracy -1e-3", &["accuracy", "-0.001", "from 1e-10 to 0.5"]),
    ("calibrate plate.toml --budget -5s", &["--budget", "-5s", "60s"]),
    ("train plate.toml --target nan", &["target of a regression is NaN"]),
    ("train plate.toml --recipe dd --simulations none --out kept", &["none holds no simulations"]),
    ("train plate.toml --recipe dd --from none", &["cannot start from none"]),
    ("train plate.toml --samples -9", &["--samples", "-9"]),
    ("train plate.toml --samples 1", &["1 simulations", "at least 2"]),
    ("train plate.toml --recipe pi --samples 9", &["--samples has no effect on `pi`"]),
    ("train plate.toml --recipe dd --target 1e-3", &["--target has no effect on `dd`"]),
    ("train plate.toml --recipe regression --steps 9", &["--steps has no effect on `regression`"]),
    ("evaluate plate.toml --cases -9", &["--cases", "-9"]),
    ("solve plate.toml --theta mu=-9,lambda=9,p=2", &["mu = -9 kPa", "positive"]),
    ("solve plate.toml --theta none.csv", &["none.csv", "CSV table"]),
    ("solve plate.toml --theta bad.csv", &["bad.csv, line 2", "no row that can be computed"]),
    ("solve plate.toml --out plate.toml", &["plate.toml/solve", "check the path"]),
    ("solve plate.toml --pictures -1", &["--pictures", "-1"]),
    ("solve plate.toml --pictures many", &["--pictures", "many"]),
    ("sample plate.toml --count some", &["--count", "some"]),
    ("sample plate.toml --count 1.5", &["--count", "give a whole number"]),
    ("sample plate.toml --count -1e4", &["--count", "-1e4"]),
    ("sample plate.toml --count 0", &["--count", "0 is not in 1.."]),
    ("plan plate.toml --count 1,0", &["--count", "0 is not in 1.."]),
    ("plan plate.toml --count 18446744073709551615", &["--count", "is not in 1..=100000000"]),
    ("sample plate.toml --design random", &["--design", "latin-hypercube"]),
    ("sample plate.toml --shard 1/4", &["--solve"]),
    ("sample plate.toml --solve --shard 5/4", &["INDEX/COUNT"]),
    ("merge plate.toml --out nothing", &["no campaign", "sinew sample"]),
    ("train plate.toml --recipe magic", &["--recipe", "regression"]),
    ("train plate.toml --minutes 1 --steps 9", &["--minutes", "--steps"]),
    ("train plate.toml --minutes soon", &["--minutes", "soon"]),
    ("train plate.toml --name ../out", &["--name ../out", "a folder within OUT"]),
    ("train plate.toml --recipe pi --simulations out", &["`pi` learns from no simulations"]),
    ("predict plate.toml --out nothing", &["no emulator in nothing", "sinew train"]),
    ("correct plate.toml --out nothing", &["no emulator in nothing", "sinew train"]),
    ("correct plate.toml --steps 0", &["--steps", "0"]),
    ("correct plate.toml --steps two", &["--steps", "two"]),
    ("evaluate plate.toml --out nothing", &["no emulator in nothing", "sinew train"]),
    ("new LeftVentrikle", &["LeftVentrikle", "LeftVentricle"]),
    ("mesh", &["ventricle"]),
    ("mesh ventricle --endocardium none.stl --epicardium none.stl", &["none.stl"]),
    (
        "mesh ventricle --endocardium none.stl --epicardium none.stl --angles steep",
        &["--angles steep", "60,-60"],
    ),
    (
        "mesh ventricle --endocardium none.stl --epicardium none.stl -o w0.stl",
        &["-o w0.stl", "must end with .vtu"],
    ),
    (
        "mesh ventricle --endocardium none.stl --epicardium none.stl --output gone/w.vtu",
        &["-o gone/w.vtu", "no folder gone", "make it"],
    ),
    ("mesh ventricle --endocardium none.stl --epicardium none.stl --out w.stl", &["-o w.stl"]),
    ("unload plate.toml --out gone/rest.vtu", &["-o gone/rest.vtu", "no folder gone"]),
    ("synthesise plate.toml --theta mu=9 --out gone/made.toml", &["no folder gone", "make it"]),
];

#[test]
fn mistakes_on_the_command_line_are_usage_errors() {
    let mut faults = Faults::default();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plate.toml"), PLATE).unwrap();
    std::fs::write(folder.path().join("bad.csv"), "mu,lambda,p\n9,9,two\n").unwrap();
    sinew_mesh::write_vtu(folder.path().join("plain.vtu"), &plain_box()).unwrap();
    for (line, words) in COMMAND_LINES {
        let (code, out, told) = sinew(folder.path(), line);
        faults.judge(&told, &format!("sinew {line}"), words);
        assert_eq!((code, out.as_str()), (2, ""), "sinew {line}: {told}");
    }
    assert!(!folder.path().join("out").exists(), "a refused command left files");
}

#[test]
fn every_command_has_help() {
    let folder = tempfile::tempdir().unwrap();
    let commands = [
        "solve",
        "sample",
        "merge",
        "train",
        "predict",
        "correct",
        "evaluate",
        "export",
        "scenes",
        "new",
        "mesh",
        "mesh ventricle",
    ];
    let (_, whole, _) = sinew(folder.path(), "--help");
    assert!(!whole.contains("--theta p=8mmHg -o"), "θ of a heart has more parameters: {whole}");
    assert!(whole.contains("3 sinew sample --solve or sinew evaluate was stopped"), "{whole}");
    let (_, sampling, _) = sinew(folder.path(), "sample --help");
    assert!(!sampling.contains("out/heart") && sampling.contains("sh OUT/sample"), "{sampling}");
    for command in commands {
        let (code, help, _) = sinew(folder.path(), &format!("{command} --help"));
        assert_eq!(code, 0, "{command}");
        assert!(help.contains("Usage: sinew"), "{command}: {help}");
        // Every option and argument is described.
        for (line, next) in help.lines().zip(help.lines().skip(1)) {
            let option = line.trim_start();
            if option.starts_with("--") || option.starts_with("-o,") {
                let described =
                    option.split_once("  ").is_some_and(|(_, about)| !about.trim().is_empty());
                assert!(described || next.starts_with("          "), "{command}: {line}");
            }
        }
        let first = command.split(' ').next().unwrap();
        assert!(whole.contains(&format!("\n  {first} ")), "{first} is not in the help of sinew");
    }
}
