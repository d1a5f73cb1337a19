//! The program on patient files: data that it makes, posteriors, curves, and runs that are resumed.

use crate::patients::PATIENT;
use sinew::PatientFile;
use sinew_mesh::{AnyMesh, Field};
use std::path::Path;
use std::process::Command;

#[test]
fn the_program_makes_data_and_their_posterior() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        (output.status.code(), text)
    };
    // One layer of cells: how the program goes about it, not how the wall moves.
    let patient = PATIENT.replace("cells = [2, 8, 4]", "cells = [1, 8, 4]");
    assert_ne!(patient, PATIENT);
    let short = patient.clone() + "draws = 80\nchecks = 40\ndesign = 20\n";
    std::fs::write(folder.path().join("patient.toml"), short).unwrap();
    let (code, said) =
        run(&["synthesise", "patient.toml", "--theta", "a=0.2,a_f=2.8", "-o", "made.toml"]);
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = run(&["calibrate", "made.toml", "--check"]);
    assert!(said.contains("too stiff"), "{said}");
    assert_eq!(code, Some(5), "{said}");
    assert!(said.starts_with("cannot tell whether the model calibrates these data: "), "{said}");
    // Sharper volumes identify a stiffness.
    let sharp = patient.replace("sd = 2.0", "sd = 0.5");
    std::fs::write(folder.path().join("sharp.toml"), sharp).unwrap();
    run(&["synthesise", "sharp.toml", "--theta", "a=0.2,a_f=2.8", "-o", "sharper.toml"]);
    let (code, told) = run(&["calibrate", "sharper.toml", "--check"]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.starts_with("the model calibrates these data: "), "{told}");
    // Pressures in another unit: a code of its own for scripts.
    let text = std::fs::read_to_string(folder.path().join("made.toml")).unwrap();
    let wrong = text.replace("\"3 mmHg\"", "\"3 kPa\"");
    assert_ne!(wrong, text);
    std::fs::write(folder.path().join("wrong.toml"), wrong).unwrap();
    let (code, told) = run(&["calibrate", "wrong.toml", "--check"]);
    assert_eq!(code, Some(4), "{told}");
    assert!(told.starts_with("the model does not calibrate these data: misfits"), "{told}");
    assert!(told.contains("phase low: p = 3 kPa") && told.contains("error: the check"), "{told}");
    // A last phase without load does not hide what the cells lose.
    let free = text.replace("\"3 mmHg\"", "\"0 mmHg\"");
    std::fs::write(folder.path().join("free.toml"), free).unwrap();
    let (_, told) = run(&["calibrate", "free.toml", "--check"]);
    assert!(told.contains("p = 0 kPa") && told.contains("too stiff"), "{told}");
    for words in [
        "phase high: p = 2.133 kPa = 16 mmHg",
        "segments: 1-1",
        "The data identify",
        "mL, computed",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // At rest it is no image that could be unloaded again.
    let unloaded = ["unload", "made.toml", "--theta", "a=0.2,a_f=2.8,p=8", "-o", "rest.vtu"];
    let (code, told) = run(&unloaded);
    assert_eq!(code, Some(0), "{told}");
    let (code, told) = run(&["calibrate", "rest.toml", "--check"]);
    assert!(code == Some(2) && told.contains("image_at_rest"), "{told}");
    let out = ["--out", "out"];
    let (code, said) = run(&["calibrate", "made.toml", "--budget", "0.01s", out[0], out[1]]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("--resume"), "{said}");
    let (code, said) = run(&["calibrate", "made.toml", "--resume", out[0], out[1]]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("the solver confirms this posterior"), "{said}");
    assert!(said.contains("before sampling:") && !said.contains("by itself is"), "{said}");
    let made = folder.path().join("out/calibrate");
    for name in ["posterior.csv", "posterior.json", "edpvr.csv", "rest.vtu", "report.html"] {
        assert!(made.join(name).exists(), "{name}");
    }
    let read = |name: &str| std::fs::read_to_string(made.join(name)).unwrap();
    let first = read("posterior.csv");
    assert_eq!(first.lines().count(), 81);
    assert_eq!(first.lines().next().unwrap(), "chain,draw,a [kPa],a_f [kPa]");
    // The truth lies within the band of the curve at rest, give or take its width.
    let dict: serde_json::Value = serde_json::from_str(&read("posterior.json")).unwrap();
    assert_eq!(dict["posterior"]["a [kPa]"].as_array().unwrap().len(), 4);
    assert!(dict["observed_data"]["volume of endo at low"].is_number());
    let names = dict["coords"]["datum"].as_array().unwrap();
    assert_eq!((names.len(), names[5].as_str()), (6, Some("volume of endo at low")));
    assert_eq!(dict["log_likelihood"]["data"][3][19].as_array().unwrap().len(), names.len());
    // Volume across, pressure up.
    let page: String = read("report.json").split_whitespace().collect();
    assert!(page.contains(r#""axes":["volume[mL]","pressure[mmHg]"]"#), "{page}");
    let solves = read("solves.csv");
    // Killed while writing its solves, and resumed: the same bits, whatever the comments of the file.
    std::fs::write(made.join("solves.csv"), &solves[..solves.len() / 2]).unwrap();
    let text = std::fs::read_to_string(folder.path().join("made.toml")).unwrap();
    std::fs::write(folder.path().join("made.toml"), format!("# A comment.\n{text}")).unwrap();
    let (code, said) = run(&["calibrate", "made.toml", "--resume", out[0], out[1]]);
    assert_eq!((code, read("posterior.csv")), (Some(0), first.clone()), "{said}");
    assert!(Path::new(&made).join("report.json").exists());
}

#[test]
fn a_curve_ends_where_draws_begin_to_lack_an_equilibrium() {
    // Softer walls, which the datum does not exclude, bear only a few millimetres of mercury more than was measured.
    let balloon = r#"
        law = { name = "neo-hookean-isochoric", bulk_modulus = 100.0 }
        loads = [{ pressure = "p", facets = "endo" }]
        supports = [{ clamped = "base" }]
        formulation = "averaged"
        mesh.ellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [1, 8, 4] }
        parameters = { mu = [1.0, 12.0], p = { range = [0.0, 40.0], unit = "mmHg", sampling = "linear" } }
        phases = { image = { p = "1 mmHg" }, high = { p = "3 mmHg" } }
        data = [{ volume = "endo", phase = "high", unit = "mL", sd = "6 %" }]
        calibration = { draws = 100 }
    "#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("balloon.toml"), balloon).unwrap();
    for arguments in ["synthesise balloon.toml --theta mu=3 -o made.toml", "calibrate made.toml"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
        let done = command.args(arguments.split(' ')).current_dir(folder.path()).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let read = |name: &str| {
        std::fs::read_to_string(folder.path().join("out/made/calibrate").join(name)).unwrap()
    };
    let curve = read("edpvr.csv");
    let rows: Vec<Vec<f64>> = curve
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    // Bands widen up to the end: the softest draws are in them.
    assert!((2..11).contains(&rows.len()), "{curve}");
    assert!(rows.windows(2).skip(1).all(|pair| pair[1][3] - pair[1][1] > pair[0][3] - pair[0][1]));
    assert!(read("report.html").contains("the curve ends before"), "{curve}");
}

#[test]
fn solves_belong_to_the_whole_body_and_to_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let prepared = PatientFile::parse(PATIENT, "patient.toml").unwrap().prepare().unwrap();
    let write = |mesh: &AnyMesh| mesh.write_vtu(folder.path().join("wall.vtu")).unwrap();
    let mesh = AnyMesh::clone(&prepared.body.mesh);
    let ellipsoid = "[mesh]\nellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [2, 8, 4] }";
    let rule = "[fibres.rule]\nendocardium = \"endo\"\nepicardium = \"epi\"\nbase = \"base\"\nangles = [60.0, -60.0]";
    assert!(PATIENT.contains(ellipsoid) && PATIENT.contains(rule));
    let text = PATIENT.replace(ellipsoid, "[mesh]\nfile = \"wall.vtu\"");
    let text = text.replace(rule, "[fibres]\nfield = \"wound\"");
    std::fs::write(folder.path().join("patient.toml"), text).unwrap();
    let fibres = |z: f64| {
        let along = |x: &[f64; 3]| {
            let radius = x[0].hypot(x[1]).max(1e-9);
            let length = (1.0 + z * z).sqrt();
            [-x[1] / radius / length, x[0] / radius / length, z / length]
        };
        let rows: Vec<_> = mesh.points().iter().map(along).collect();
        // On the axis any direction will do.
        let rows = rows
            .iter()
            .map(|row| if row[0] == 0.0 && row[1] == 0.0 { [1.0, 0.0, 0.0] } else { *row });
        let mut wound = mesh.clone();
        let rows: Vec<_> = rows.collect();
        wound.point_fields_mut().insert("wound".into(), Field::vectors(&rows));
        wound
    };
    let run = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(["calibrate", "patient.toml", "--out", "out", "--budget", "0.01s"])
            .args(more)
            .current_dir(folder.path())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    write(&fibres(1.0));
    // Elsewhere `wall.vtu` would be another mesh, or none.
    std::fs::create_dir(folder.path().join("elsewhere")).unwrap();
    let mut synthesise = Command::new(env!("CARGO_BIN_EXE_sinew"));
    let line = "synthesise patient.toml --theta a=0.2,a_f=2.8 -o elsewhere/made.toml";
    let moved = synthesise.args(line.split(' ')).current_dir(folder.path()).output().unwrap();
    let told = String::from_utf8_lossy(&moved.stderr);
    assert!(told.contains("write into its folder"), "{told}");
    let (code, said) = run(&[]);
    assert!(code == Some(1) && said.contains("budget"), "{said}");
    let (code, said) = run(&["--resume"]);
    assert!(code == Some(1) && said.contains("budget"), "{said}");
    // Other fibres, and another set of the mesh.
    write(&fibres(0.5));
    let (code, said) = run(&["--resume"]);
    assert!(code == Some(2) && said.contains("another patient, body or settings"), "{said}");
    let mut less = fibres(1.0);
    less.facet_sets_mut().get_mut("epi").unwrap().pop();
    write(&less);
    let (code, said) = run(&["--resume"]);
    assert!(code == Some(2) && said.contains("another patient, body or settings"), "{said}");
    // Another run keeps its solves there.
    write(&fibres(1.0));
    let stored = std::fs::File::open(folder.path().join("out/calibrate/solves.csv")).unwrap();
    stored.lock().unwrap();
    let before = std::fs::read_to_string(folder.path().join("out/calibrate/solves.csv")).unwrap();
    for how in ["--resume", "--restart"] {
        let (code, said) = run(&[how]);
        assert!(code == Some(2) && said.contains("another run keeps its solves here"), "{said}");
    }
    let after = std::fs::read_to_string(folder.path().join("out/calibrate/solves.csv")).unwrap();
    assert_eq!(after, before);
    stored.unlock().unwrap();
    let (code, said) = run(&["--resume"]);
    assert!(code == Some(1) && said.contains("budget"), "{said}");
}

#[test]
fn made_data_name_their_origin_and_replace_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("patient.toml"), PATIENT).unwrap();
    std::fs::write(file("notes.csv"), "mine\n").unwrap();
    let run = |theta: &str, output: &str| {
        let done = Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(["synthesise", "patient.toml", "--theta", theta, "-o", output])
            .current_dir(folder.path())
            .output()
            .unwrap();
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    let (theta, output) = ("a=0.2,a_f=2.8", "made.toml");
    let (code, said) = run(theta, "notes.csv");
    assert!(code == Some(2) && said.contains("notes.csv is there already"), "{said}");
    assert_eq!(std::fs::read_to_string(file("notes.csv")).unwrap(), "mine\n");
    let (code, said) = run(theta, "patient.toml");
    assert!(code == Some(2) && said.contains("patient.toml is an input"), "{said}");
    let (code, said) = run("a=-0.2,a_f=2.8", output);
    let named = "--theta a=-0.2,a_f=2.8: a = -0.2 kPa makes no sense";
    assert!(code == Some(2) && said.contains(named), "{said}");
    assert!(!file(output).exists());
    let (code, said) = run("a=0.45,a_f=2.8", output);
    let named = "warning: a = 0.45 kPa is outside its range from 0.1 to 0.4 kPa";
    assert!(code == Some(0) && said.contains(named), "{said}");
    // What it wrote itself is replaced.
    assert_eq!(run(theta, output), (Some(0), String::new()));
    let made = std::fs::read_to_string(file(output)).unwrap();
    let origin = "# synthesised from patient.toml, theta a=0.2,a_f=2.8, seed 1\n";
    assert!(made.starts_with(origin), "{made}");
    PatientFile::parse(&made, output).unwrap();
}

#[test]
fn a_run_is_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let made = folder.path().join("out/calibrate");
    std::fs::create_dir_all(&made).unwrap();
    std::fs::write(folder.path().join("patient.toml"), PATIENT).unwrap();
    let stored = "# solves of a patient, 0\n2e-1,2.8e0,;!no body\n";
    std::fs::write(made.join("solves.csv"), stored).unwrap();
    let results = ["posterior.csv", "posterior.json", "rest.vtu", "report.html", "report.json"];
    results.iter().for_each(|name| std::fs::write(made.join(name), "old").unwrap());
    let run = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_sinew"))
            .args(["calibrate", "patient.toml", "--out", "out"])
            .args(more)
            .current_dir(folder.path())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = run(&[]);
    assert_eq!(code, Some(2), "{said}");
    for words in ["solves.csv holds 1 solves", "--resume", "--restart"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let (code, said) = run(&["--resume"]);
    assert!(code == Some(2) && said.contains("another patient"), "{said}");
    assert_eq!(std::fs::read_to_string(made.join("solves.csv")).unwrap(), stored);
    assert!(results.iter().all(|name| made.join(name).exists()));
    // Stopped after it began: no results of the run before are left.
    let (code, said) = run(&["--restart", "--budget", "0.01s"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(results.iter().all(|name| !made.join(name).exists()));
}
