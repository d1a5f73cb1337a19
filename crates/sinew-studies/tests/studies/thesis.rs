//! The page of all printed figures.

use sinew_studies::thesis::compare::{Standing, compare};
use sinew_studies::thesis::filled::{PAGES, fill};
use sinew_studies::thesis::page::page;
use sinew_studies::thesis::page::picture;
use sinew_studies::thesis::run::kept;
use sinew_studies::thesis::thesis;
use std::process::Command;

const DOCUMENTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/thesis.md");

#[test]
fn the_page_is_made_from_what_is_kept_of_the_runs() {
    let text = std::fs::read_to_string(PAGE).unwrap();
    assert!(text == page(&kept().unwrap()).unwrap(), "`cargo xtask thesis --write` writes it");
    let drawing = std::fs::read_to_string(PAGE.replace(".md", ".svg")).unwrap();
    assert!(drawing == picture(&kept().unwrap()).unwrap(), "`cargo xtask thesis --write` draws it");
}

/// Rows of the page beside the places of ours in the kept reports: table, row, run, section, subject and method, column, statistic, and
/// the unit of the row in that of the column.
const PLACES: &str = "
Figure 1.4, §1.7.3 | strong form, g, error | gp | pinn | Poisson in 1-D, PINN, strong form | err_f | q50 | 1
Figure 2.10, §2.3 | K = 2, 25 % | rectangles | rectangles | K = 2, M = 40, η = [24, 6] | mean err_u | q25 | 1
Figure 2.10, §2.3 | K = 2, 75 % | rectangles | rectangles | K = 2, M = 40, η = [24, 6] | mean err_u | q75 | 1
§2.4.5.2 | GNN 2, largest | inflated | inflated | K = 3, M = 40, η = [60, 8], 32 numbers | volume | q100 | 1
§2.4.5.2 | MLP 2, largest | inflated | inflated | MLP 2, patience none, best weights | volume | q100 | 1
Table 2.1, CPU | varying geometry, time | speed | speed | network, shape varies | answer | | 1
§2.4.6.2 | MLP, time | inflated | inflated | MLP 2, patience none, best weights | CPU | | 60
Table A.1 | K = 1, 25 % | rectangles | rectangles | K = 1, M = 40, no virtual nodes | err_u | q25 | 1
Table A.2 | K = 1, 50 % | rectangles | rectangles | K = 1, M = 40, η = [24, 6] | err_u | q50 | 1
Table A.4 | M = 60, 75 % | rectangles | rectangles | K = 2, M = 60, η = [24, 6] | err_u | q75 | 1
Table A.6 | [48, 24, 6], 25 % | template | rectangles | K = 2, M = 40, η = [48, 24, 6], template | err_u | q25 | 1
Table A.10 | GNN 1, 75 % | inflated | inflated | K = 3, M = 40, η = [60, 8], parameters as they are, 32 numbers | volume | q75 | 1
Table A.12 | 25, 50 % | volumes | inflated | MLP 2, patience 25, best weights | volume | q50 | 1
Table A.13 | 100, 25 % | volumes | inflated | MLP 2, patience 100, last weights | volume | q25 | 1
Figure 3.3, data-driven | F, median | beams | once | dd | err_F | q50 | 1
Figure 3.4, physics-informed | Π, median | beams | twice | pi | err_Π | q50 | 1
Figure 3.5 | u, median | organs | twisting-cube | pi | err_u | q50 | 1
Figure 3.5 | u, largest | organs | twisting-cube | pi | err_u | q100 | 1
Figure 3.5 | I₁, largest | organs | twisting-cube | pi | err_I₁ | q100 | 1
Figure 3.6 | u, largest | organs | twisting-cube | pi | err_u | q100 | 1
Table 3.2 | 4 096 nodes, mean of the slice | meshes | cube-meshes | 4 096 nodes, fine-tuned | slice | | 1
Table 3.2, decoder | 343 nodes, time | meshes | cube-meshes | 343 nodes, from scratch | decoder | | 1e-3
Figure 3.7 | u, largest | organs | liver | pi | err_u | q100 | 1
Figure 3.7 | I₁, largest | organs | liver | pi | err_I₁ | q100 | 1
Figure 3.8 | u, largest | organs | liver | pi | err_u | q100 | 1
Figure 3.10 | F, median | ventricle | ventricle-thesis | pi | err_F | q50 | 1
Figure 3.10 | volume, largest | ventricle | ventricle-thesis | pi | err_V | q100 | 1
Figure 3.11 | u, largest | ventricle | ventricle-thesis | pi | err_u | q100 | 1
Figure B.7 | u, mean | organs | biventricle | pi | err_u | mean | 1
Figure B.9 | transfer, median | shapes | new-ventricle | heart-008, fine-tuned | err_V | q50 | 1
§B.5, volume | transfer, largest | shapes | new-ventricle | heart-008, fine-tuned | err_V | q100 | 1
Figure 4.11 | HCGP, u | gp | helmholtz | Helmholtz, HCGP | err_u | q50 | 1";

fn list(value: &serde_json::Value) -> Vec<serde_json::Value> {
    value.as_array().cloned().unwrap_or_default()
}

/// Tables with each of their rows in a section of the file of a run, read as it stands.
fn rows(run: &str, section: &str) -> Vec<[serde_json::Value; 2]> {
    let text = std::fs::read_to_string(format!("{DOCUMENTS}/thesis/{run}.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let sections = list(&file["report"]["sections"]).into_iter();
    let blocks = sections.filter(|part| part["name"] == section).flat_map(|s| list(&s["blocks"]));
    let tables = blocks.map(|block| block["table"].clone());
    tables
        .flat_map(|table| list(&table["rows"]).into_iter().map(move |row| [table.clone(), row]))
        .collect()
}

/// Whether a row goes by a name: its method, with its subject, or with its setting too.
fn is_named(row: &serde_json::Value, name: &str) -> bool {
    let [subject, method, about] =
        ["subject", "method", "about"].map(|part| row[part].as_str().unwrap_or_default());
    let longer = format!("{subject}, {method}");
    name == method || name == longer || name == format!("{longer}, {about}")
}

/// Value of a place; `None` where it is a number and no median is asked for.
fn raw(run: &str, section: &str, name: &str, column: &str, statistic: &str) -> Option<f64> {
    let places = rows(run, section).into_iter().filter(|[_, row]| is_named(row, name));
    let cell = |[table, row]: &[serde_json::Value; 2]| {
        ["errors", "times", "others"].iter().find_map(|part| {
            let at = list(&table[part]).iter().position(|head| head["name"] == column)?;
            Some(row[part][at]["value"].clone())
        })
    };
    let found = places.into_iter().find_map(|place| cell(&place)).expect(name);
    let alone = found.as_f64().filter(|_| ["", "q50"].contains(&statistic));
    assert!(found.is_number() || found.is_object(), "{run}, {name}: {found}");
    alone.or(found[statistic].as_f64())
}

#[test]
fn rows_hold_the_statistic_that_they_name() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    for place in PLACES.trim().lines() {
        let [table, row, run, section, name, column, statistic, unit] =
            place.split('|').map(str::trim).collect::<Vec<_>>()[..]
        else {
            panic!("{place}")
        };
        let part = page.split(&format!("\n### {table}\n")).nth(1).unwrap();
        let line = part.lines().find(|line| line.starts_with(&format!("| {row} |"))).unwrap();
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let first = |cell: usize| cells[cell].split(' ').next().unwrap().parse::<f64>().unwrap();
        let Some(ours) = raw(run, section, name, column, statistic) else {
            assert_eq!(cells[3..6], ["not stored", "", ""], "{line}");
            continue;
        };
        let ours = ours / unit.parse::<f64>().unwrap();
        // Two digits are printed at least.
        assert!((first(3) / ours - 1.0).abs() < 0.05, "{line}\n{ours}");
        assert!((first(4) / (ours / first(2)) - 1.0).abs() < 0.05, "{line}\n{ours}");
        let mark = cells[3].split(' ').nth(1);
        let met = ours < first(2) * 1.05;
        let missed = ours > first(2) * 0.95;
        assert!(mark != Some("✓") || met, "{line}");
        assert!(mark != Some("✗") || missed, "{line}");
    }
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
            let there = found.own.found.is_some();
            // No solver's time counts for an emulator.
            for ours in [&found.own, &found.best] {
                let solver = ours.found.as_ref().is_some_and(|f| f.method.contains("solver"));
                assert!(!solver || ours.standing == Standing::Beside, "{}", table.place);
            }
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
        let mut program = Command::new(env!("CARGO_BIN_EXE_sinew-studies"));
        program.arg("thesis").args(more).arg("--out").arg(folder.path()).output().unwrap()
    };
    let done = run(&["--quick", "--only", "gp"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = std::fs::read_to_string(folder.path().join("thesis.md")).unwrap();
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with("| u, HCGP |")).collect();
    assert_eq!(lines.len(), 5);
    assert!(lines.iter().all(|line| !line.contains("not run")));
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
