//! The way from every scene to the report.

use clap::Parser;
use sinew_emulate::Budget;
use sinew_report::Report;
use sinew_studies::organs::options::{Options, keys};

fn options(arguments: &[&str], out: &std::path::Path) -> Options {
    let fixed = ["organs", "--quick", "--meshes", "nowhere", "--out", out.to_str().unwrap()];
    Options::try_parse_from(fixed.iter().chain(arguments)).unwrap()
}

#[test]
fn a_quick_run_reports_every_scene_and_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let only = "twisting-cube,liver,ventricle,ventricle-thesis,cube-meshes,new-ventricle";
    let page =
        sinew_studies::organs::reproduce::reproduce(&options(&["--only", only], folder.path()))
            .unwrap();
    let report = Report::read(&folder.path().join("report.json")).unwrap();
    let names: Vec<_> = report.sections.iter().map(|section| section.name.as_str()).collect();
    assert_eq!(names, ["twisting-cube", "ventricle", "cube-meshes", "new-ventricle"]);
    for left_out in ["LeftVentricleThesis was not run", "Liver was not run"] {
        assert!(report.notes.iter().any(|note| note.contains(left_out)), "{:?}", report.notes);
    }
    // What stands in for a published organ is said, and is not held against published figures.
    let section = crate::section(&report, "ventricle");
    assert!(section.title.contains("in the place of LeftVentricle"), "{}", section.title);
    assert!(section.tables().all(|table| table.verdicts().next().is_none()));
    let cube = crate::section(&report, "twisting-cube").tables().next().unwrap();
    assert_eq!(
        cube.rows.len(),
        10,
        "pi, taylor and regression, raw and after two corrections, and the solver"
    );
    // Raw medians are held against what is printed, corrected ones are not.
    assert_eq!(cube.verdicts().count(), 6);
    // Corrections come nearer to the solver whatever they begin from.
    let error = |row: usize| cube.rows[row].errors[0].value.median().unwrap();
    assert!(
        error(4) < 0.1 * error(3) && error(5) < 0.1 * error(4),
        "{} {} {}",
        error(3),
        error(4),
        error(5)
    );
    let table = crate::section(&report, "cube-meshes").tables().next().unwrap();
    let networks: Vec<_> = table.rows.iter().map(|row| row.method.as_str()).collect();
    assert_eq!(networks, ["from scratch", "pre-trained", "fine-tuned", "from scratch"]);

    // Nothing is done twice.
    let before =
        std::fs::metadata(folder.path().join("ventricle/comparison.json")).unwrap().modified();
    let again = options(&["--only", only, "--resume"], folder.path());
    assert_eq!(sinew_studies::organs::reproduce::reproduce(&again).unwrap(), page);
    let after =
        std::fs::metadata(folder.path().join("ventricle/comparison.json")).unwrap().modified();
    assert_eq!(before.unwrap(), after.unwrap());
    let other = Options { seed: 2, ..again };
    let error = format!("{:#}", sinew_studies::organs::reproduce::reproduce(&other).unwrap_err());
    assert!(error.contains("other options"), "{error}");
}

#[test]
fn names_are_unique() {
    let mut names: Vec<_> = keys().collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), keys().count());
}

#[test]
fn a_budget_is_shared_by_what_is_run() {
    let parse = |arguments: &[&str]| {
        Options::try_parse_from(std::iter::once(&"organs").chain(arguments)).unwrap()
    };
    let seconds = |options: &Options, minutes: f64| match options.training(minutes, 1) {
        Budget::Seconds(seconds) => seconds,
        other => panic!("{other:?}"),
    };
    let options = parse(&["--only", "liver,twisting-cube", "--budget", "10m"]);
    let sum = seconds(&options, 3.0) + seconds(&options, 2.0);
    assert!((sum - 600.0).abs() < 1e-9, "{sum}");
    // Two networks of each, and none of a regression.
    let more = parse(&["--only", "liver", "--budget", "10m", "--recipe", "pi,dd,regression"]);
    assert!((seconds(&more, 3.0) - 300.0).abs() < 1e-9);
    // One network on the first mesh of the cube, two on the next two, one on the others.
    let cubes = parse(&["--only", "cube-meshes", "--budget", "10m"]);
    let all = 1.0 + 2.0 * 1.0 + 2.0 * 1.5 + 3.0 + 5.0;
    assert!((seconds(&cubes, 1.0) - 600.0 / all).abs() < 1e-9);
    let error = Options::try_parse_from(["organs", "--only", "kidney"]).unwrap_err().to_string();
    assert!(error.contains("twisting-cube"), "{error}");
}
