//! The whole path from mesh to report, small: what `cargo xtask reproduce-beam --quick` runs.

use clap::Parser;
use sinew_report::{Report, Row};
use sinew_study::options::{BeamOptions, Options, Study};
use sinew_study::report::Method;
use sinew_study::run::reproduce_beam;
use std::path::Path;

fn options(out: &Path, more: &[&str]) -> BeamOptions {
    let start = ["sinew-study", "reproduce-beam", "--quick", "--scene", "once", "--out"];
    let out = out.to_str().expect("a temporary folder has a plain name");
    let arguments = start.iter().copied().chain([out]).chain(more.iter().copied());
    match Options::parse_from(arguments).study {
        Study::ReproduceBeam(options) => options,
        other => panic!("{other:?} is another study"),
    }
}

fn read(out: &Path) -> Report {
    Report::read(&out.join("report.json")).unwrap()
}

fn medians(report: &Report) -> Vec<f64> {
    let rows = report.tables().flat_map(|table| &table.rows);
    rows.flat_map(|row| row.errors.iter().map(|cell| cell.value.median().unwrap())).collect()
}

#[test]
fn a_quick_run_reports_every_method_and_resumes_to_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    reproduce_beam(&options(out, &[])).unwrap();
    let report = read(out);
    let table = report.section("once").unwrap().tables().next().unwrap();
    let row = |method: Method| -> &Row {
        table.row(method.label()).unwrap_or_else(|| panic!("no row of {}", method.key()))
    };
    for method in Method::ALL.into_iter().filter(|&method| method != Method::Fdd) {
        let full = table.times.iter().position(|column| column.name == "full").unwrap();
        assert!(row(method).times[full].value.median().unwrap() > 0.0);
    }
    // The solver agrees with the independent program; regression on a dozen solves is close.
    assert_eq!(table.errors[0].name, "err_u");
    let error = |method| row(method).errors[0].value.median().unwrap();
    assert!(error(Method::FemCold) < 1e-9, "{:e}", error(Method::FemCold));
    assert!(error(Method::FemWarm) < 1e-9, "{:e}", error(Method::FemWarm));
    assert!(error(Method::Pod) < 1e-2, "{:e}", error(Method::Pod));
    for file in ["report.html", "samples.csv", "manifest.json", "once/fields/cases.pvd"] {
        assert!(out.join(file).metadata().unwrap().len() > 100, "{file}");
    }
    let cases = std::fs::read_to_string(out.join("samples.csv")).unwrap();
    // Eight test cases of dd, pi, hybrid and pod, ten fixtures of both solver rows, one head line.
    assert_eq!(cases.lines().count(), 4 * 8 + 2 * 10 + 1);

    // As after a kill while pi was in its second training: dd is kept, pi goes on from its checkpoint.
    std::fs::remove_dir_all(out.join("once/pi/emulator")).unwrap();
    std::fs::remove_file(out.join("report.json")).unwrap();
    reproduce_beam(&options(out, &["--resume"])).unwrap();
    let resumed = read(out);
    assert_eq!(medians(&resumed), medians(&report));

    // Without its last checkpoint the second training starts again, and ends at the same numbers.
    std::fs::remove_dir_all(out.join("once/pi/emulator")).unwrap();
    std::fs::remove_dir_all(out.join("once/pi/train")).unwrap();
    reproduce_beam(&options(out, &["--resume"])).unwrap();
    let repeated = read(out);
    assert_eq!(medians(&repeated), medians(&report));

    let other = reproduce_beam(&options(out, &["--resume", "--seed", "7"])).unwrap_err();
    assert!(other.to_string().contains("other options"), "{other:#}");
}

#[test]
fn nothing_to_resume_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let error = reproduce_beam(&options(folder.path(), &["--resume"])).unwrap_err();
    assert!(error.to_string().contains("without --resume"), "{error:#}");
}
