//! Rows, cases, and what the program makes of them.

use crate::distort::Distort as _;
use clap::{CommandFactory, Parser};
use sinew_mesh::{Mesh, box_tetrahedra};
use sinew_studies::verify::run::run;
use sinew_studies::verify::{
    Band, Case, Cost, Effort, Formulation, Label, Measure, Options, Row, Rows, cases, report,
    summary, table, verify,
};
use std::collections::BTreeSet;
use std::path::Path;

/// The file behind norms of errors.
#[path = "../../src/verify/integrate.rs"]
#[allow(dead_code)]
mod integrate;

/// A case of two meshes whose finer one lies in its band.
const GOOD: Case = Case {
    name: "fake",
    title: "A made-up <case>",
    provenance: "made up",
    run: |_, rows| two_meshes(rows, 0.01),
};
/// One whose coarser mesh does not.
const BAD: Case = Case { run: |_, rows| two_meshes(rows, 0.05), ..GOOD };
/// One that ends with an error.
const BROKEN: Case = Case {
    run: |_, rows| {
        two_meshes(rows, 0.01)?;
        Err(anyhow::anyhow!("no equilibrium").context("on the fine mesh"))
    },
    ..GOOD
};

fn two_meshes(rows: &mut Rows, fine: f64) -> anyhow::Result<()> {
    for (unknowns, error) in [(100, 4.0 * fine), (1000, fine)] {
        let label = Label::new(Formulation::P2, format!("{unknowns}"), "deflection [mm]");
        let cost = Cost { unknowns, seconds: 1e-4 * unknowns as f64 };
        rows.relative(label, [1.0 + error, 1.0], Band::below(0.1), cost)?;
    }
    Ok(())
}

#[test]
fn cases_pass_when_all_rows_do() {
    let outcome = run(&GOOD, Effort::Quick);
    assert!(outcome.passes() && outcome.rows.len() == 2);
    assert!(!run(&BAD, Effort::Quick).passes());
}

#[test]
fn errors_and_panics_are_failures_that_keep_the_rows() {
    let panics = Case {
        run: |_, rows| {
            two_meshes(rows, 0.01)?;
            panic!("index {}", 7)
        },
        ..GOOD
    };
    let outcomes = [BROKEN, panics].map(|case| run(&case, Effort::Full));
    let failures = outcomes.each_ref().map(|outcome| outcome.failure.as_deref());
    let expected = ["on the fine mesh: no equilibrium", "panicked: index 7"];
    assert_eq!(failures, expected.map(Some));
    assert!(outcomes.iter().all(|outcome| outcome.rows.len() == 2 && !outcome.passes()));
}

#[test]
fn the_table_shows_errors_beside_times() {
    let outcome = run(&BAD, Effort::Full);
    let text = table(&outcome);
    let lines: Vec<_> = text.lines().skip(2).collect();
    assert!(lines[0].contains("value") && lines[0].contains("band"));
    assert!(lines[1].contains("20 %") && lines[1].ends_with("OUTSIDE"), "{text}");
    assert!(lines[2].contains("≤ 10 %") && lines[2].contains("100 ms"), "{text}");
    assert!(lines[2].ends_with("1\u{202f}000"), "{text}");
    assert!(summary(&[outcome]).contains("1 of 2 values within their bands, 1 cases"));
}

#[test]
fn failures_are_shown_with_their_reason() {
    let outcome = run(&BROKEN, Effort::Full);
    assert!(
        table(&outcome).contains("FAILED]") && table(&outcome).contains("failed: on the fine mesh")
    );
    assert!(summary(&[outcome]).ends_with("failed: fake"));
}

#[test]
fn both_files_hold_errors_times_and_bands() {
    let outcome = run(&GOOD, Effort::Full);
    let report = report(Effort::Full, &[outcome]).unwrap();
    let row = &crate::section(&report, "fake").tables().next().unwrap().rows[1];
    assert_eq!((row.method.as_str(), row.others[2].value.median()), ("P2", Some(1000.0)));
    let error = &row.errors[0];
    assert!((error.value.median().unwrap() - 0.01).abs() < 1e-12);
    assert_eq!(error.verdict.as_ref().map(|band| (band.met, band.limit)), Some((true, 0.1)));
    assert_eq!(row.times[0].value.median(), Some(0.1));
    let page = report.to_html();
    assert!(page.contains("A made-up &lt;case&gt;") && !page.contains("A made-up <case>"));
    // Error against unknowns and error against seconds; keys of rows are hidden from screen readers.
    assert_eq!(page.matches("role=\"img\"").count(), 2);
}

fn options(out: &Path, only: &[&str]) -> Options {
    let only = only.iter().map(ToString::to_string).collect();
    Options { only, list: false, quick: true, out: out.into() }
}

#[test]
fn a_value_outside_its_band_fails_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let passes = |case: Case| verify(&[case], &options(folder.path(), &[])).unwrap();
    assert!(passes(GOOD));
    assert!(!passes(BAD));
    assert!(folder.path().join("report.html").exists());
}

#[test]
fn unknown_names_are_refused_with_those_there_are() {
    let error = verify(&[GOOD], &options(Path::new("unused"), &["other"])).unwrap_err();
    assert_eq!(error.to_string(), "no case is named `other`; there are fake");
}

fn label() -> Label {
    Label::new(Formulation::P1, "2 cells", "u [mm]")
}

const COST: Cost = Cost { unknowns: 3, seconds: 0.1 };

#[test]
fn rows_judge_their_errors() {
    let row = Row::new(label(), Measure::Relative, [2.02, -2.0], Band::below(1e-2), COST).unwrap();
    assert!((row.error - 2.01).abs() < 1e-12 && !row.passes());
    let row = Row::new(label(), Measure::Absolute, [2.02, 2.0], Band::below(0.03), COST).unwrap();
    assert!((row.error - 0.02).abs() < 1e-12 && row.passes());
    let locking = Band::between(0.8, 0.9);
    let row = Row::new(label(), Measure::Relative, [0.99, 1.0], locking, COST).unwrap();
    assert!(!row.passes(), "a smaller error than the stated weakness is outside");
}

#[test]
fn rows_without_error_or_time_are_refused() {
    let band = Band::below(1.0);
    let refused =
        |measure, pair, cost| Row::new(label(), measure, pair, band, cost).unwrap_err().to_string();
    let slow = Cost { seconds: f64::NAN, ..COST };
    assert!(refused(Measure::Absolute, [1.0; 2], slow).contains("the time is NaN"));
    assert!(refused(Measure::Relative, [1.0, 0.0], COST).contains("the error is inf"));
    let none = refused(Measure::Absolute, [f64::NAN, 1.0], COST);
    assert!(none.contains("u [mm] (2 cells): the value is NaN"), "{none}");
}

#[test]
fn cases_have_names_of_their_own_and_say_where_references_come_from() {
    let names: BTreeSet<_> = cases::ALL.iter().map(|case| case.name).collect();
    assert_eq!(names.len(), cases::ALL.len());
    for case in &cases::ALL {
        let plain = |c: char| c.is_ascii_lowercase() || c == '-' || c.is_ascii_digit();
        assert!(case.name.chars().all(plain));
        assert!(!case.title.is_empty() && !case.provenance.is_empty());
    }
}

/// The cheap cases, as they run under `--quick`.
#[test]
fn cheap_cases_pass() {
    for name in ["patch", "shear", "beam-fixture", "elastica", "limit-point"] {
        let outcome = run(cases::find(name).expect(name), Effort::Quick);
        assert!(outcome.passes(), "{}", table(&outcome));
    }
}

#[test]
fn the_command_line_is_sound() {
    Options::command().debug_assert();
    let options = Options::parse_from(["verify", "--only", "cook", "--only", "beam", "--quick"]);
    assert_eq!(options.only, ["cook", "beam"]);
    assert!(options.quick && !options.list);
}

#[test]
fn linear_fields_are_integrated_exactly() {
    let mesh = box_tetrahedra([1.0, 2.0, 3.0], [2; 3]).distorted(3, 0.2).quadratic();
    let field: Vec<_> = mesh.points.iter().flat_map(|x| [x[0] + 2.0 * x[1], x[2], 1.0]).collect();
    let (mut volume, mut integral) = (0.0, 0.0);
    for point in integrate::points(&mesh, Mesh::<10>::FINE_QUADRATURE) {
        volume += point.volume;
        integral += point.volume * point.value(&field)[0];
        let slope = point.slope(&field);
        assert!((slope[0][1] - 2.0).abs() < 1e-12 && (slope[1][2] - 1.0).abs() < 1e-12);
    }
    assert!((volume - 6.0).abs() < 1e-12 && (integral - 6.0 * 2.5).abs() < 1e-11);
}
