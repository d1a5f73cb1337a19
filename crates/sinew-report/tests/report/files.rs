//! Files that are written and read back, their schema and their provenance.

use crate::support::report;
use sinew_report::{Block, Chart, Provenance, Report, ReportError, Series, Style};

#[test]
fn json_round_trip_is_exact_and_wrong_files_are_refused() {
    let mut report = report();
    let text = report.to_json().unwrap();
    let read = Report::from_json(&text).unwrap();
    assert_eq!(read.to_json().unwrap(), text);
    assert_eq!(read.sections[0].blocks[..3], report.sections[0].blocks[..3]);
    let negative = text.replacen("{\"value\":150.0}", "{\"value\":-150.0}", 1);
    assert!(
        matches!(Report::from_json(&negative), Err(ReportError::Number(field, _)) if field == "DD-GNN: train")
    );
    let newer = text.replacen("\"schema\":4", "\"schema\":5", 1);
    assert!(matches!(Report::from_json(&newer), Err(ReportError::Schema(5, _))));
    assert!(matches!(Report::from_json("{"), Err(ReportError::Json(_))));
    let hostile = text.replacen("\"triangles\":[[0,1,2]", "\"triangles\":[[0,1,77]", 1);
    assert!(matches!(Report::from_json(&hostile), Err(ReportError::Triangle(0, 77, 4))));

    // What is not finite is null in the file and a gap after reading.
    let broken = Series::new("n", Style::Line, [[1.0, f64::NAN], [2.0, f64::INFINITY], [3.0, 1.0]]);
    let chart = Chart::new("c", ["x", "y"], [false; 2]).with(broken);
    report.sections[0].blocks = vec![Block::charts("t", "", [chart])];
    let read = Report::from_json(&report.to_json().unwrap()).unwrap();
    assert_eq!(read.to_html(), report.to_html());
}

#[test]
fn files_are_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let report = report();
    let page = report.write(&folder.path().join("new")).unwrap();
    assert_eq!(std::fs::read_to_string(&page).unwrap(), report.to_html());
    let read = Report::read(&page.with_file_name("report.json")).unwrap();
    assert_eq!(read.to_html(), report.to_html());
    let message = Report::read(&folder.path().join("none.json")).unwrap_err().to_string();
    assert!(message.contains("none.json"), "{message}");
}

#[test]
fn every_field_is_documented() {
    fn names(value: &serde_json::Value, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (name, value) in fields {
                    found.push(name.clone());
                    // Names of packages are data.
                    if name != "versions" {
                        names(value, found);
                    }
                }
            }
            serde_json::Value::Array(values) => values.iter().for_each(|value| names(value, found)),
            _ => (),
        }
    }
    let schema = include_str!("../../../../docs/report-schema.md");
    let mut found = Vec::new();
    names(&serde_json::from_str(&report().to_json().unwrap()).unwrap(), &mut found);
    for name in found {
        assert!(schema.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn a_revision_is_dirty_with_changed_sources_and_clean_with_a_changed_document() {
    let folder = tempfile::tempdir().unwrap();
    let git = |arguments: &str| {
        let given = "-c user.name=a -c user.email=a@b ".to_string() + arguments;
        let given = given.split(' ');
        let done = std::process::Command::new("git").args(given).current_dir(&folder).output();
        assert!(done.unwrap().status.success(), "{arguments}");
    };
    let put = |name: &str| std::fs::write(folder.path().join(name), name).unwrap();
    let revision = || Provenance::of_this_run("p", folder.path().join("sources")).revision;
    for name in ["docs", "sources"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    assert_eq!(revision(), "unknown");
    put("sources/a.rs");
    ["init -q", "add .", "commit -q -m first"].iter().copied().for_each(git);
    let clean = revision();
    assert_eq!(clean.len(), 12, "{clean}");
    put("docs/results.md");
    assert_eq!(revision(), clean);
    put("sources/b.rs");
    assert_eq!(revision(), format!("{clean}-dirty"));
}
