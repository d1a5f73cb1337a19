//! The whole path from mesh to report, small: what `cargo xtask reproduce-beam --quick` runs.

use clap::{CommandFactory, Parser};
use sinew_report::{Report, Row};
use sinew_studies::beams::options::BeamOptions;
use sinew_studies::beams::run::reproduce_beam;
use sinew_studies::beams::scenes;
use std::path::Path;

fn options(out: &Path, more: &[&str]) -> BeamOptions {
    let start = ["reproduce-beam", "--quick", "--scene", "once", "--out"];
    let out = out.to_str().expect("a temporary folder has a plain name");
    let arguments = start.iter().copied().chain([out]).chain(more.iter().copied());
    BeamOptions::parse_from(arguments)
}

fn read(out: &Path) -> Report {
    Report::read(&out.join("report.json")).unwrap()
}

/// Errors with gaps where the solver has none: it is the truth.
fn medians(report: &Report) -> Vec<Option<f64>> {
    let rows = report.tables().flat_map(|table| &table.rows);
    rows.flat_map(|row| row.errors.iter().map(|cell| cell.value.median())).collect()
}

#[test]
fn a_quick_run_reports_every_method_and_resumes_to_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    reproduce_beam(&options(out, &[])).unwrap();
    let report = read(out);
    assert!(report.about.starts_with("A quick check"), "{}", report.about);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<li>OnceClampedBeam, err_"), "misses name their beam");
    let tables: Vec<_> = crate::section(&report, "once").tables().collect();
    let [emulators, solver] = tables[..] else { panic!("{} tables", tables.len()) };
    let row = |table: &'static str, method: &str| -> &Row {
        let of = if table == "solver" { solver } else { emulators };
        of.row(method).unwrap_or_else(|| panic!("no row of {method}"))
    };
    for method in ["dd", "pi", "pod"] {
        let full = emulators.times.iter().position(|column| column.name == "in full").unwrap();
        assert!(row("emulators", method).times[full].value.median().unwrap() > 0.0);
    }
    // What the thesis prints of its two networks.
    assert_eq!(emulators.verdicts().count(), 2 * 4);
    // The truth of the table is no rival, but what its times are compared with.
    assert!(emulators.ranked().all(|row| row.method != "Newton solver"));
    let said = emulators.summary();
    assert!(said.len() == 3 && said[0].contains("pod") && said[1].contains("predict"), "{said:?}");
    // The solver agrees with the independent program; regression on a dozen solves is close.
    assert_eq!((&*emulators.errors[0].name, &*solver.errors[0].name), ("err_u", "err_u"));
    let error = |table, method| row(table, method).errors[0].value.median().unwrap();
    for method in ["fem_cold", "fem_warm"] {
        assert!(error("solver", method) < 1e-9, "{:e}", error("solver", method));
    }
    assert!(error("emulators", "pod") < 1e-2, "{:e}", error("emulators", "pod"));
    for file in ["report.html", "samples.csv", "once/fields/cases.pvd"] {
        assert!(out.join(file).metadata().unwrap().len() > 100, "{file}");
    }
    let cases = std::fs::read_to_string(out.join("samples.csv")).unwrap();
    // Eight test cases of dd, pi and pod, ten fixtures of both solver rows, one head line.
    assert_eq!(cases.lines().count(), 3 * 8 + 2 * 10 + 1);

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
fn the_command_line_is_consistent() {
    BeamOptions::command().debug_assert();
}

#[test]
fn nothing_to_resume_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let error = reproduce_beam(&options(folder.path(), &["--resume"])).unwrap_err();
    assert!(error.to_string().contains("without --resume"), "{error:#}");
}

mod samples {
    use sinew_emulate::CaseErrors;
    use sinew_energy::Parameter;
    use sinew_studies::beams::scenes::{head, lines};

    #[test]
    fn one_line_per_case_under_its_head() {
        let parameters = ["mu", "lambda"].map(|name| Parameter::log(name, "kPa", 50.0..=100.0));
        let errors = vec![0.25, 0.5, 0.75];
        let mut case = CaseErrors {
            err_u: errors.clone(),
            err_f: errors.clone(),
            err_i1: errors,
            err_pi: 0.5,
            err_volume: Vec::new(),
            relative: 0.1,
            inverted: false,
            energy_excess: 0.0,
        };
        let row = |case: &CaseErrors| {
            lines("once", "fem_warm", &[vec![60.0, 70.5]], std::slice::from_ref(case))
        };
        let (head, line) = (head(&parameters), row(&case).unwrap());
        assert!(head.starts_with("scene,sample,method,mu_kPa,lambda_kPa,err_u_mm_mean,"), "{head}");
        assert!(line.starts_with("once,0,fem_warm,60,70.5,5e-1,5e-1,7.5e-1,"), "{line}");
        assert!(line.ends_with(",5e-1\n"));
        assert_eq!(head.split(',').count(), line.split(',').count());
        case.err_f[1] = f64::NAN;
        assert!(row(&case).is_err());
    }
}

mod both_beams {
    use super::scenes::BEAMS;

    #[test]
    fn both_beams_have_the_thesis_mesh() {
        for beam in &BEAMS {
            let case = sinew::Case::read(std::path::Path::new(beam.scene)).unwrap();
            let potential = case.body().expect("the scene is complete");
            assert_eq!((potential.nodes, potential.cell_count()), (390, 1440));
            let volume: f64 = potential.volumes.iter().sum();
            let weight: f64 = potential.nodal_force.iter().sum();
            assert!((weight / volume + 9.8e-3).abs() < 1e-15);
        }
    }
}

mod manifest {
    use sinew_studies::program::of_this_run;

    #[test]
    fn the_pinned_tensor_library_is_named() {
        let config = std::collections::BTreeMap::from([("steps", 1)]);
        let provenance = of_this_run(1, &config).unwrap();
        assert!(provenance.command.starts_with("cargo xtask"), "{}", provenance.command);
        assert_eq!(provenance.versions["burn"], "0.22.1");
        assert!(provenance.versions.contains_key("faer"));
        assert!(!provenance.revision.is_empty());
    }
}
