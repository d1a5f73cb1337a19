//! The way from populations to the report.

use clap::Parser;
use sinew_organs::populations::options::Options;
use sinew_organs::populations::run::reproduce;
use sinew_report::Report;

#[test]
fn a_quick_run_reports_every_population_and_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let options = |more: &[&str]| {
        let fixed = ["populations", "--quick", "--hearts", "nowhere", "--out", out];
        Options::try_parse_from(fixed.iter().chain(more)).unwrap()
    };
    reproduce(&options(&[])).unwrap();
    let read = || Report::read(&folder.path().join("report.json")).unwrap();
    let report = read();
    let names: Vec<_> = report.sections.iter().map(|section| section.name.as_str()).collect();
    assert_eq!(names, ["rectangles", "rings", "beams", "ventricles", "infarcts"]);
    let plane = report.sections[0].tables().next().unwrap();
    assert_eq!(plane.rows.len(), 3, "a regression, a network without virtual nodes and one with");
    for section in &report.sections[1..] {
        let table = section.tables().next().unwrap();
        let methods: Vec<_> = table.rows.iter().map(|row| row.method.as_str()).collect();
        let mut all = vec!["mean", "nearest", "POD + GP", "no network", "network"];
        // What starts from equilibrium has no state to find.
        all.extend((section.name == "beams").then_some("network, carried"));
        if section.name == "rings" {
            all.extend(["network, dd", "network, hybrid"]);
        }
        assert_eq!(methods, all);
        // Raw, after one step and after two.
        for row in &table.rows {
            let error = |at: usize| row.errors[at].value.median().unwrap();
            assert!(error(1) <= error(0) && error(2) <= error(1), "{}", row.method);
        }
    }
    // What is done is not done again; other options are refused.
    reproduce(&options(&["--resume"])).unwrap();
    assert_eq!(read().sections, report.sections);
    let other = reproduce(&options(&["--resume", "--seed", "2"])).unwrap_err();
    assert!(format!("{other:#}").contains("other options"), "{other:#}");
    assert!(Options::try_parse_from(["populations", "--only", "spheres"]).is_err());
}
