//! The experiments with Gaussian processes, small: what `cargo xtask reproduce-gp --quick` runs.

use clap::{CommandFactory, Parser, ValueEnum};
use sinew_report::{Block, Report, Row};
use sinew_studies::gp::Options;
use sinew_studies::gp::experiments::Name;
use sinew_studies::gp::reproduce_gp;
use std::path::Path;

mod cases;
mod formulas;

/// Files of the experiments behind their reports, which hold results alone.
#[path = "../../src/gp/deep.rs"]
#[allow(dead_code)]
mod deep;
#[path = "../../src/gp/pentagon.rs"]
#[allow(dead_code)]
mod pentagon;
#[path = "../../src/gp/problems.rs"]
#[allow(dead_code)]
mod problems;
#[path = "../../src/gp/row.rs"]
#[allow(dead_code, unreachable_pub)]
mod row;
#[path = "../../src/gp/workers.rs"]
#[allow(dead_code)]
mod workers;

fn options(out: &Path, more: &[&str]) -> Options {
    let start = ["reproduce-gp", "--quick", "--out"];
    let out = out.to_str().expect("a temporary folder has a plain name");
    let arguments = start.iter().copied().chain([out]).chain(more.iter().copied());
    Options::parse_from(arguments)
}

fn report(out: &Path, more: &[&str]) -> Report {
    reproduce_gp(&options(out, more)).unwrap();
    Report::read(&out.join("report.json")).unwrap()
}

fn rows(report: &Report) -> impl Iterator<Item = &Row> {
    report.tables().flat_map(|table| &table.rows)
}

/// Every number of a row that does not depend on the clock.
fn numbers(row: &Row) -> Vec<f64> {
    row.errors.iter().chain(&row.others).flat_map(|cell| cell.value.numbers()).collect()
}

/// Results of the restarts of all fits.
fn restarts(report: &Report) -> Vec<f64> {
    let blocks = report.sections.iter().flat_map(|section| &section.blocks);
    let listings = blocks.filter_map(|block| match block {
        Block::Listing { rows, .. } => Some(rows.iter().flatten()),
        _ => None,
    });
    listings.flatten().flat_map(|cell| cell.value.numbers()).collect()
}

#[test]
fn a_quick_run_has_a_finite_row_for_every_case() {
    let folder = tempfile::tempdir().unwrap();
    let report = report(folder.path(), &[]);
    let names: Vec<&str> = report.sections.iter().map(|e| e.name.as_str()).collect();
    let all: Vec<String> = Name::value_variants().iter().map(|name| name.key()).collect();
    assert_eq!(names, all);
    for row in rows(&report) {
        assert!(numbers(row).iter().all(|x| x.is_finite()), "{}", row.name());
        assert!(row.times[0].value.median().unwrap() > 0.0, "{}", row.name());
        let collapsed = row.others.last().unwrap();
        assert!(collapsed.note.is_empty(), "{}: {}", row.name(), collapsed.note);
    }
    let scale = sinew_studies::gp::experiment::Scale { quick: true };
    let cases = Name::value_variants().iter().map(|name| name.experiment(scale).unwrap().cases);
    assert_eq!(rows(&report).count(), cases.flatten().count(), "{:?}", report.notes);
    // A quick run has one data set.
    let case = folder.path().join("heat-1/heat-bvp-1-hcgp");
    assert!(case.join("0000.json").exists() && !case.join("0001.json").exists());
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert_eq!(page.matches("<section").count(), names.len() + 2);
    assert!(!page.contains("NaN"));
}

#[test]
fn numbers_do_not_depend_on_threads_and_stored_fits_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    // An experiment that is named twice runs once.
    let only = ["--only", "heat-1,helmholtz,heat-1", "--seeds", "2"];
    let of =
        |report: &Report| rows(report).map(numbers).chain([restarts(report)]).collect::<Vec<_>>();
    let run =
        |name: &str, more: &[&str]| report(&folder.path().join(name), &[&only, more].concat());
    let alone = run("one", &["--threads", "1"]);
    assert_eq!(of(&alone), of(&run("two", &["--threads", "2"])));
    assert_eq!(rows(&alone).count(), 6);

    // A mark in a stored fit comes back, one that is missing is done again to the same numbers.
    let case = folder.path().join("one/heat-1/heat-bvp-1-hcgp");
    let text = std::fs::read_to_string(case.join("0000.json")).unwrap();
    let seconds = text.lines().find(|line| line.contains("\"seconds\"")).unwrap();
    std::fs::write(case.join("0000.json"), text.replace(seconds, "\"seconds\": 4321.0,")).unwrap();
    std::fs::remove_file(case.join("0001.json")).unwrap();
    let resumed = run("one", &["--resume"]);
    assert_eq!(rows(&resumed).next().unwrap().times[0].value.numbers()[6], 4321.0);
    assert_eq!(of(&resumed), of(&alone));

    let other = options(&folder.path().join("one"), &["--resume", "--seed", "7"]);
    let message = reproduce_gp(&other).unwrap_err().to_string();
    assert!(message.contains("--seed 1"), "{message}");
    let nothing = options(&folder.path().join("nothing"), &["--resume"]);
    let message = reproduce_gp(&nothing).unwrap_err().to_string();
    assert!(message.contains("without --resume"), "{message}");
}

#[test]
fn experiments_are_chosen_by_name() {
    Options::command().debug_assert();
    let parse = |arguments: &[&str]| {
        let start = ["reproduce-gp"];
        Options::try_parse_from(start.iter().chain(arguments))
    };
    let options = parse(&["--only", "heat-1,pinn", "--seeds", "3", "--threads", "1"]).unwrap();
    assert_eq!(options.only, [Name::Heat1, Name::Pinn]);
    assert_eq!((options.seeds, options.threads), (Some(3), Some(1)));
    assert_eq!(Name::AdvectionDiffusion.key(), "advection-diffusion");
    let wrong = parse(&["--only", "heat"]).unwrap_err().to_string();
    assert!(wrong.contains("heat-1") && wrong.contains("advection-diffusion"), "{wrong}");
    for wrong in ["0", "-1", "ten", "1.5"] {
        assert!(parse(&[&format!("--seeds={wrong}")]).is_err(), "{wrong}");
    }
}

mod experiment {
    use sinew_studies::gp::experiment::{Case, Task, derived};
    use sinew_studies::gp::row::{Label, Method, Run};

    #[test]
    fn seeds_differ_by_purpose_and_data_set() {
        let seeds: Vec<u64> = (0..4).flat_map(|a| (0..4).map(move |b| derived(a, b))).collect();
        let mut distinct = seeds.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), seeds.len());
        assert_eq!(derived(1, 2), seeds[6]);
    }

    #[test]
    fn keys_are_names_of_files() {
        let label = Label {
            problem: "Poisson-BVP-1".into(),
            setting: "N_f = 4".into(),
            method: Method::Hcnn,
            abscissa: None,
            truth: Vec::new(),
        };
        let run = |_: &Task| Ok(Run::default());
        let case = Case { label, run: Box::new(run) };
        assert_eq!(case.key(), "poisson-bvp-1-hcnn-n-f-4");
    }
}

mod section {
    use sinew_report::{Table, Value};
    use sinew_studies::gp::report::section;
    use sinew_studies::gp::row::{Label, Method, Row, Run, Truth};

    fn row(err_u: f64, theta: f64) -> Row {
        let label = Label {
            problem: "Heat-BVP-1".into(),
            setting: String::new(),
            method: Method::Hcgp,
            abscissa: None,
            truth: vec![Truth { name: "theta".into(), value: 1.0 }],
        };
        let run = Run { err_u, seconds: 0.5, theta: vec![theta], ..Run::default() };
        Row::of(label, vec![run], Vec::new()).unwrap()
    }

    #[test]
    fn what_is_missed_is_said_plainly() {
        let section = |row| section("heat-1".into(), "Heat", "", &[row], Vec::new()).unwrap();
        let reached = section(row(4.94e-5, 1.0004));
        assert!(reached.tables().flat_map(Table::verdicts).all(|found| found.3.met));
        let missed = section(row(9.8e-5, 1.02));
        let texts: Vec<_> =
            missed.tables().flat_map(Table::verdicts).map(|found| found.3.text.clone()).collect();
        assert_eq!(texts, ["2.0× the thesis’ 4.9×10⁻⁵", "40× the thesis’ 5.0×10⁻⁴"]);
        assert_eq!(missed.tables().next().unwrap().rows[0].others[1].value, Value::from("1.000"));
    }
}
