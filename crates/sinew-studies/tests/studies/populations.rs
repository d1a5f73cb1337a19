//! The way from populations to the report.

use clap::Parser;
use sinew_report::{Block, Report, Section};
use sinew_studies::populations::options::Options;
use sinew_studies::populations::run::reproduce;

mod parts;
mod verdict;

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
    assert_eq!(
        names,
        ["rectangles", "inflated", "speed", "rings", "beams", "ventricles", "infarcts"]
    );
    let plane = report.sections[0].tables().next().unwrap();
    assert_eq!(plane.rows.len(), 3, "a regression, a network without virtual nodes and one with");
    let inflated: Vec<_> = report.sections[1].tables().collect();
    let row = |table: usize, method: &str| {
        let found = inflated[table].rows.iter().find(|row| row.method.contains(method));
        found.map(|row| row.errors[1].value.median().unwrap()).unwrap()
    };
    // Six simulations say nothing of 36 numbers; what the coarse mesh leaves is small, here and on one shape.
    assert!(row(0, "POD + GP, 6 simulations") > 10.0 * row(0, "coarse solution"));
    assert!(row(1, "about the coarse solution") < 3.0);
    // Volumes alone: two regressions, a plain network without patience and one with each, by best and last weights.
    assert_eq!(inflated[2].rows.len(), 2 + 2 + 2 * 5);
    let plain = inflated[2].rows.iter().filter(|row| row.method.starts_with("MLP"));
    let patience = plain.filter(|row| row.about.contains("25, 50, 75 %"));
    assert_eq!(patience.count(), 12);
    for section in &report.sections[3..] {
        let table = section.tables().next().unwrap();
        let methods: Vec<_> = table.rows.iter().map(|row| row.method.as_str()).collect();
        let about_coarse = "POD + GP about the coarse solution";
        let rivals = ["mean", "nearest", "POD + GP", about_coarse];
        let both = |method: &str| [method.into(), format!("{method}, 4 quasi-Newton steps")];
        let mut all: Vec<String> = rivals.map(String::from).into();
        all.extend(["coarse solution".into()]);
        all.extend([16, 32].map(|steps| format!("frozen stiffness, {steps} steps")));
        all.extend(both("Taylor expansion"));
        assert_eq!(methods, all);
        // Raw and after two steps; one may overshoot.
        for row in &table.rows {
            let error = |at: usize| row.errors[at].value.median().unwrap();
            assert!(error(2) <= error(0), "{}", row.method);
        }
    }
    // What is done is not done again; other options are refused.
    reproduce(&options(&["--resume"])).unwrap();
    assert_eq!(read().sections, report.sections);
    let other = reproduce(&options(&["--resume", "--seed", "2"])).unwrap_err();
    assert!(format!("{other:#}").contains("other options"), "{other:#}");
    assert!(Options::try_parse_from(["populations", "--only", "spheres"]).is_err());
}

#[test]
fn every_seed_has_a_file_of_its_own_and_a_run_goes_on_with_more_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let run = |out: &str, more: &[&str]| {
        let out = folder.path().join(out);
        let fixed = ["populations", "--quick", "--only", "rings", "--no-rivals", "--out"];
        let all = fixed.into_iter().chain(out.to_str()).chain(more.iter().copied());
        let page = reproduce(&Options::try_parse_from(all).unwrap())?;
        anyhow::Ok(Report::read(&page.with_file_name("report.json")).unwrap().sections.remove(0))
    };
    let medians = |section: &Section, table: usize| -> Vec<f64> {
        let rows = &section.tables().nth(table).unwrap().rows;
        rows.iter().map(|row| row.errors[0].value.median().unwrap()).collect()
    };
    let facts = |section: &Section| {
        let facts = section.blocks.iter().filter_map(|block| match block {
            Block::Facts(facts) => Some(facts.clone()),
            _ => None,
        });
        facts.reduce(|_, last| last).unwrap()
    };
    let one = run("several", &[]).unwrap();
    assert_eq!((one.tables().count(), facts(&one).len()), (1, 1), "a verdict on one group");
    let kept = std::fs::read(folder.path().join("several/rings/study.json")).unwrap();
    let two = run("several", &["--seeds", "2", "--resume"]).unwrap();
    assert_eq!(std::fs::read(folder.path().join("several/rings/study.json")).unwrap(), kept);
    assert_eq!(two.tables().next(), one.tables().next(), "rows are those of the first seed");
    assert!(facts(&two)[0].1.contains(" of 2 seeds"), "{:?}", facts(&two));
    // The median of two seeds is in the middle of what each finds alone.
    let alone = run("alone", &["--seed", "2"]).unwrap();
    let middle = medians(&one, 0).into_iter().zip(medians(&alone, 0)).map(|(a, b)| 0.5 * (a + b));
    for (found, expected) in medians(&two, 1).into_iter().zip(middle) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}"); // rounding
    }
    // Files of one seed are not read as those of another.
    let error = run("several", &["--seed", "2", "--resume"]).unwrap_err();
    assert!(format!("{error:#}").contains("other options"), "{error:#}");
}
