//! Patient files: what they are read as, what is refused in words, and the program on one.

use sinew::PatientFile;
use sinew_calibrate::{Forward, Solves, check_identifiability};
use sinew_mesh::{AnyMesh, Field};
use std::path::Path;
use std::process::Command;

/// A small ventricle with three volumes and strains of four segments.
const PATIENT: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
parameters = { a = [0.1, 0.4], b = 2.0, a_f = [1.5, 5.0], b_f = 2.1, p = { range = [0.0, 40.0], unit = "mmHg", sampling = "linear" } }

[mesh]
ellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [2, 8, 4] }

[fibres.rule]
endocardium = "endo"
epicardium = "epi"
base = "base"
angles = [60.0, -60.0]

[phases.image]
p = "8 mmHg"
[phases.low]
p = "3 mmHg"
[phases.high]
p = "16 mmHg"

[[data]]
volume = "endo"
phase = "low"
value = 44.0
unit = "mL"
sd = "3 %"

[[data]]
volume = "endo"
phase = "high"
value = 72.0
unit = "mL"
sd = 2.0

[[data]]
strain = "circumferential"
phase = "high"
values = [0.05, 0.06, 0.05, 0.06]
sd = 0.02

[calibration]
wall = { endocardium = "endo", epicardium = "epi", base = "base", septum = [-1.0, 0.0, 0.0] }
segments = "1x4"
"#;

fn refused(from: &str, to: &str) -> String {
    assert!(PATIENT.contains(from), "{from}");
    let text = PATIENT.replace(from, to);
    let file = PatientFile::parse(&text, "patient.toml");
    file.and_then(|file| file.prepare()).expect_err(to).to_string()
}

#[test]
fn units_phases_and_segments_are_read() {
    let prepared = PatientFile::parse(PATIENT, "patient.toml").unwrap().prepare().unwrap();
    let problem = &prepared.problem;
    assert_eq!(
        problem.unknowns.iter().map(|u| u.head()).collect::<Vec<_>>(),
        ["a [kPa]", "a_f [kPa]"]
    );
    assert_eq!((problem.data.len(), prepared.segments.as_ref().unwrap().names().len()), (6, 4));
    // 16 mmHg in kPa, 44 mL in mm³ and 3 % as a share.
    assert!((prepared.phases["high"]["p"] - 2.133158).abs() < 1e-6);
    let low = problem.data.iter().find(|d| d.name == "volume of endo at low").unwrap();
    assert_eq!((low.value, low.deviation, low.is_share), (44_000.0, 0.03, true));
    assert!((low.error() - 0.03 * 44.0 * 1e3).abs() < 1e-9);
    let name = |&at: &usize| prepared.observables[at].to_string();
    let reported: Vec<_> = prepared.reported.iter().map(name).collect();
    let expected = ["rest", "high", "low"].map(|state| format!("volume of endo at {state}"));
    assert_eq!(reported, expected);
    // Pressures of another unit are beyond their range; no pressure is none.
    assert!(prepared.warnings().is_empty());
    let kilopascals = PATIENT.replace("16 mmHg", "16 kPa");
    let prepared = PatientFile::parse(&kilopascals, "patient.toml").unwrap().prepare().unwrap();
    let [told] = &prepared.warnings()[..] else { panic!("one phase") };
    assert!(
        told.starts_with("phase high: p = 120.0") && told.contains("outside its range"),
        "{told}"
    );
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let says = |from: &str, to: &str, expected: &[&str]| {
        let error = refused(from, to);
        expected.iter().for_each(|words| assert!(error.contains(words), "{words}: {error}"));
    };
    says("value = 72.0", "value = nan", &["data.1.value", "is NaN"]);
    says("unit = \"mL\"\nsd = 2.0", "sd = 2.0", &["data.1.unit", "the unit is missing", "mL"]);
    says(
        "unit = \"mL\"\nsd = 2.0",
        "unit = \"mmHg\"\nsd = 2.0",
        &["`mmHg` is not a unit of volume"],
    );
    says("p = \"16 mmHg\"", "p = 16.0", &["phases.high.p", "the unit is missing", "16 mmHg"]);
    says("p = \"16 mmHg\"", "p = \"16 bar\"", &["`bar` is not a unit of stress"]);
    says("p = \"16 mmHg\"", "q = \"16 mmHg\"", &["no parameter `q`", "a, a_f, p"]);
    says("[phases.high]", "[phases.low]", &["`low` is there twice"]);
    says(
        "phase = \"high\"\nvalue = ",
        "phase = \"hihg\"\nvalue = ",
        &["no phase `hihg`", "`high`?"],
    );
    let unknown = refused("phase = \"high\"\nvalue = ", "phase = \"systole\"\nvalue = ");
    assert!(
        unknown.trim().ends_with("no phase `systole`; phases: high, image, low, rest"),
        "{unknown}"
    );
    says(
        "volume = \"endo\"\nphase = \"low\"",
        "volume = \"lv\"\nphase = \"low\"",
        &["no cavity `lv`", "endo"],
    );
    says("values = [0.05, 0.06, 0.05, 0.06]", "values = [0.05]", &["1 values for 4 segments"]);
    says("values = [0.05, 0.06, 0.05, 0.06]", "segment = 9\nvalue = 0.1", &["no segment `9`"]);
    says(
        "values = [0.05, 0.06, 0.05, 0.06]",
        "segment = 18\nvalue = 0.1",
        &["no segment `18`; segments: 1"],
    );
    says("segments = \"1x4\"", "segments = \"aha\"", &["`aha` is not a division"]);
    says(", septum = [-1.0, 0.0, 0.0]", "", &["septum"]);
    says("sd = 2.0", "sd = 0.0", &["standard deviation is 0"]);
    says("sd = 0.02", "sd = \"2 %\"", &["a share is for volumes"]);
    says(
        "phase = \"high\"\nvalue = ",
        "phase = \"low\"\nvalue = ",
        &["line 30, data.1", "`volume of endo at low` is given in line 23 already"],
    );
    for (setting, advice) in [
        ("pressure_common = 5", "write 0.05 for 5 %"),
        ("pressure_each = 1.5", "write 0.015 for 1.5 %"),
        ("priors.a = { median = 0.2, sd = 30 }", "write 0.3 for 30 %"),
    ] {
        let key = setting.split_once(" = ").unwrap().0;
        says("[calibration]", &format!("[calibration]\n{setting}"), &[key, advice]);
    }
    says(
        "a = [0.1, 0.4]",
        "a = { range = [0.0, 0.4], sampling = \"linear\" }",
        &["parameters.a", "positive"],
    );
    says(
        "segments = \"1x4\"",
        "segments = \"1x4\"\ninfer_noise = [\"strains\"]",
        &["kind `strains`", "`strain`?"],
    );
    says("segments = \"1x4\"", "segments = \"1x4\"\nsede = 3", &["`seed`?"]);
    says("[phases.image]\np = \"8 mmHg\"", "", &["the loads of the image are missing"]);
}

#[test]
fn phases_without_a_load_of_others_are_refused() {
    let says = |from: &str, to: &str| refused(from, to);
    let error = says("[phases.high]\np = \"16 mmHg\"", "[phases.high]");
    assert!(
        error.contains("phases.high: phase `high` lacks `p`, which phase `image` has"),
        "{error}"
    );
    // With an image at rest its own loads are zero, those of phases are not.
    let at_rest = "[calibration]\nimage_at_rest = true";
    let text = PATIENT.replace("[phases.image]\np = \"8 mmHg\"\n", "");
    let text = text.replace("[calibration]", at_rest);
    let read = |text: &str| PatientFile::parse(text, "patient.toml").unwrap().prepare();
    assert_eq!(read(&text).unwrap().phases["image"]["p"], 0.0);
    let lacking = text.replace("[phases.low]\np = \"3 mmHg\"", "[phases.low]");
    assert!(read(&lacking).unwrap_err().to_string().contains("phase `low` lacks `p`"));
}

#[test]
fn data_that_no_parameter_changes_are_refused() {
    let strain = "strain = \"circumferential\"\nphase = \"high\"";
    let zero = "data.2.phase: it is counted from the same state";
    for to in [
        "strain = \"circumferential\"\nfrom = \"high\"\nphase = \"high\"",
        "strain = \"circumferential\"\nphase = \"image\"",
        "strain = \"circumferential\"\nfrom = \"rest\"\nphase = \"rest\"",
    ] {
        let error = refused(strain, to);
        assert!(error.contains(zero), "{error}");
    }
    // Another name for the same loads, unless each pressure has an error of its own.
    let error = refused("p = \"16 mmHg\"", "p = \"8 mmHg\"");
    assert!(error.contains("data.1.phase: the volume in the image"), "{error}");
    let own = PATIENT.replace("p = \"16 mmHg\"", "p = \"8 mmHg\"") + "pressure_each = 0.05\n";
    assert!(PatientFile::parse(&own, "patient.toml").unwrap().prepare().is_ok());
    let error =
        refused("volume = \"endo\"\nphase = \"low\"", "volume = \"endo\"\nphase = \"image\"");
    assert!(error.contains("data.0.phase: the volume in the image is that of the mesh"), "{error}");
    let moved =
        "displacement = [0.0, 0.0, 1.0]\npoint = [25.0, 0.0, 0.0]\nvalue = 1.0\nunit = \"mm\"";
    let error = refused(
        "strain = \"circumferential\"\nphase = \"high\"\nvalues = [0.05, 0.06, 0.05, 0.06]",
        &format!("{moved}\nfrom = \"low\"\nphase = \"low\""),
    );
    assert!(error.contains(zero), "{error}");
}

#[test]
fn medians_in_another_unit_are_refused() {
    let setting =
        |line: &str| refused("segments = \"1x4\"", &format!("segments = \"1x4\"\n{line}"));
    let error = setting("priors.a = { median = 200.0, sd = 0.3 }");
    let words = "calibration.priors.a: the median 200 is outside of the range of `a`, 0.1 to 0.4 in the unit kPa";
    assert!(error.contains(words), "{error}");
    assert!(setting("priors.a_f = { median = 0.003, sd = 0.3 }").contains("0.003 is outside"));
    let inside = PATIENT.to_string() + "priors.a = { median = 0.4, sd = 0.3 }\n";
    assert!(PatientFile::parse(&inside, "patient.toml").unwrap().prepare().is_ok());
}

#[test]
fn settings_that_make_no_sense_are_refused_with_their_key() {
    let setting = |line: &str, expected: &[&str]| {
        let error = refused("segments = \"1x4\"", &format!("segments = \"1x4\"\n{line}"));
        expected.iter().for_each(|words| assert!(error.contains(words), "{words}: {error}"));
    };
    let prior = "calibration.priors.a: ";
    setting(
        "priors.a = { median = -0.2, sd = 0.3 }",
        &[prior, "the median is -0.2; give a positive"],
    );
    setting(
        "priors.a = { median = 0.2, sd = 0.0 }",
        &[prior, "standard deviation of the logarithm is 0"],
    );
    setting("pressure_common = -1.0", &["calibration.pressure_common: ", "logarithm is -1; give"]);
    setting("pressure_each = nan", &["calibration.pressure_each: ", "logarithm is NaN; give"]);
    for key in ["draws", "design", "checks", "rounds"] {
        setting(&format!("{key} = 0"), &[&format!("calibration.{key}: it is 0; give at least")]);
    }
    setting("degree = 9", &["calibration.degree: it is 9; give at least 1 and at most 4"]);
}

#[test]
fn pressures_in_kpa_that_were_meant_in_mmhg_are_seen_ahead() {
    // 3 and 16 kPa are 22 and 120 mmHg: the volumes cannot be those.
    let text = PATIENT.replace("p = \"3 mmHg\"", "p = \"3 kPa\"");
    let prepared = PatientFile::parse(&text, "patient.toml").unwrap().prepare().unwrap();
    let model = prepared.patient().unwrap();
    let mut solves = Solves::new(&model, Box::new(|_, _, _| ()));
    let (mode, _) = check_identifiability(&prepared.problem, &mut solves).unwrap();
    let low = prepared.problem.data.iter().position(|d| d.name == "volume of endo at low").unwrap();
    assert!(mode.misfits[low] < -5.0, "{:?}", mode.misfits);
}

#[test]
fn factors_of_pressures_are_parameters() {
    let text = PATIENT.replace(
        "segments = \"1x4\"",
        "segments = \"1x4\"\npressure_common = 0.1\npressure_each = 0.05",
    );
    let prepared = PatientFile::parse(&text, "patient.toml").unwrap().prepare().unwrap();
    let names: Vec<_> = prepared.problem.unknowns.iter().map(|u| u.name.as_str()).collect();
    let own = ["high", "image", "low"].map(|phase| format!("pressure factor at {phase}"));
    assert_eq!(names[..3], ["a", "a_f", "pressure factor"]);
    assert_eq!(names[3..], own);
    // All stresses times a factor leave the displacements: the two other laws' parameters are known, so only nearly here.
    let model = prepared.patient().unwrap();
    let [plain, pressed] = [1.0, 1.1]
        .map(|factor| model.observe(&[0.2, 2.8, factor, 1.0, 1.0, 1.0], false).unwrap().values);
    assert!(pressed[1] > plain[1], "{pressed:?} {plain:?}");
    let curve = prepared.curve("endo", &[1.0]).unwrap();
    assert_eq!((curve.parameters(), prepared.curve_parameters()), (4, vec![0, 1, 2, 4]));
}

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
    for words in [
        "phase high: p = 2.133 kPa = 16 mmHg",
        "segments: 1-1",
        "The data identify",
        "mL, computed",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
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
    assert!(code == Some(2) && said.contains("the patient file itself"), "{said}");
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

#[test]
fn the_patient_file_of_the_documentation_is_one() {
    let page = include_str!("../../../../docs/calibration.md");
    let blocks: Vec<&str> = page.split("```toml\n").skip(1).collect();
    assert_eq!(blocks.len(), 1);
    let text = blocks[0].split("```").next().unwrap();
    let prepared = PatientFile::parse(text, "docs").unwrap().prepare().unwrap();
    assert_eq!((prepared.problem.data.len(), prepared.problem.unknowns.len()), (2, 4));
}
