//! The page of all printed figures.

use sinew_study::thesis::compare::{Standing, compare};
use sinew_study::thesis::filled::{PAGES, fill};
use sinew_study::thesis::page::page;
use sinew_study::thesis::run::kept;
use sinew_study::thesis::thesis;
use std::process::Command;

const DOCUMENTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/thesis.md");

#[test]
fn the_page_is_made_from_what_is_kept_of_the_runs() {
    let text = std::fs::read_to_string(PAGE).unwrap();
    assert!(text == page(&kept().unwrap()).unwrap(), "`cargo xtask thesis --write` writes it");
}

#[test]
fn tables_of_other_pages_are_filled_from_what_is_kept() {
    for name in PAGES {
        let text = std::fs::read_to_string(format!("{DOCUMENTS}/{name}")).unwrap();
        assert!(text.contains("<!-- table "), "{name} has no such table");
        let filled = fill(&text, &kept().unwrap()).unwrap();
        assert!(text == filled, "{name}: `cargo xtask thesis --write` writes it");
    }
}

#[test]
fn every_figure_of_a_kept_run_is_found() {
    let runs = kept().unwrap();
    assert!(!runs.is_empty());
    // A graphics processor, a kernel and a loss that no report has.
    let elsewhere = |own: &str, column: &str| {
        own.is_empty()
            || own.contains("graphics processor")
            || own.contains("periodic kernel")
            || column == "loss"
    };
    for table in thesis().table.iter().filter(|table| runs.contains_key(&table.run)) {
        for found in compare(table, &runs).unwrap() {
            let there = matches!(found.own.standing, Standing::Met | Standing::Missed);
            let cell = found.cell;
            assert!(
                there != elsewhere(&cell.own, &cell.column),
                "{}, {}: {}",
                table.place,
                cell.what,
                cell.own
            );
        }
    }
    for (name, stored) in &runs {
        let run = thesis().run.iter().find(|run| run.name == *name).unwrap();
        assert_eq!(stored.command, run.command(), "{name}");
        assert!(stored.cpu_s.is_some_and(|seconds| seconds > 0.0), "{name}");
    }
}

#[test]
fn a_quick_run_has_figures_of_its_own_and_leaves_the_page() {
    let before = std::fs::read(PAGE).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_sinew-thesis"));
        program.args(more).arg("--out").arg(folder.path()).output().unwrap()
    };
    let done = run(&["--quick", "--only", "beams"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = std::fs::read_to_string(folder.path().join("thesis.md")).unwrap();
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with("| Π, median")).collect();
    assert_eq!(lines.len(), 4);
    assert!(lines.iter().all(|line| !line.contains("not run") && line.contains("| pod |")));
    assert!(text.contains("| K = 1, 50 % | 1.47 mm | not run"));
    assert_eq!(std::fs::read(PAGE).unwrap(), before);
    let wrong = run(&["--only", "5"]);
    assert!(!wrong.status.success());
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("rectangles"));
}

#[test]
fn kept_reports_name_no_folder_of_a_machine() {
    for (name, stored) in kept().unwrap() {
        let provenance = &stored.report.provenance;
        for text in [&provenance.command, &provenance.config] {
            assert!(!text.contains("--out /") && !text.contains("out = \"/"), "{name}: {text}");
        }
    }
}
