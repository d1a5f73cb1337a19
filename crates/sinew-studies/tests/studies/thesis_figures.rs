//! Figures as they are printed, compared and written into pages.

use sinew_report::{Block, Column, Distribution, Report, Row, Section, Table};
use sinew_studies::thesis::compare::{Runs, Standing, compare};
use sinew_studies::thesis::filled::fill;
use sinew_studies::thesis::page::page;
use sinew_studies::thesis::printed::Cell;
use sinew_studies::thesis::stored::Stored;
use sinew_studies::thesis::{printed_median, thesis};

/// Two methods with their times before the first answer \[s\].
fn run_of([regression, network]: [f64; 2]) -> Runs {
    let mut table = Table::new([Column::new("err_u", "mm")], [Column::new("CPU", "s").once()], []);
    let row = |method: &str, samples: Vec<f64>, seconds: f64| {
        Row::new(method, Distribution::of(samples).unwrap(), seconds).unwrap()
    };
    for (method, samples, seconds) in [
        ("POD + GP, 225 simulations", vec![1e-5, 2e-5, 3e-5], regression),
        ("K = 1, M = 40, no virtual nodes", vec![0.4164, 1.4751, 9.0], network),
    ] {
        table.push(row(method, samples, seconds)).unwrap();
    }
    let section = Section { blocks: vec![Block::Table(table)], ..Section::default() };
    let report = Report { sections: vec![section], ..Report::default() };
    [("rectangles".to_string(), Stored::new("command".into(), None, report))].into()
}

fn run() -> Runs {
    run_of([7.0; 2])
}

#[test]
fn figures_are_met_in_the_digits_that_are_printed() {
    let table = thesis().table.iter().find(|table| table.place == "Table A.1").unwrap();
    let found = compare(table, &run()).unwrap();
    // Quartiles of three samples lie amid them.
    let first = &found[0];
    assert_eq!(first.own.standing, Standing::Missed, "{first:?}");
    let median = &found[6];
    // 1.4751 is 1.48 in three digits.
    assert_eq!((median.own.standing, median.best.standing), (Standing::Missed, Standing::Met));
    assert_eq!(median.best.found.as_ref().unwrap().before_s, Some(7.0));
    assert!((median.best.ratio - 2e-5 / 1.47).abs() < 1e-9);
    // Another method was not run, but regression met its figure.
    assert_eq!((found[1].own.standing, found[1].best.standing), (Standing::NotRun, Standing::Met));
    // A number alone is a median and tells no quartile.
    let mut alone = run();
    let blocks = &mut alone.get_mut("rectangles").unwrap().report.sections[0].blocks;
    let Block::Table(kept) = &mut blocks[0] else { unreachable!() };
    kept.rows.iter_mut().for_each(|row| row.errors[0] = 1e-9.into());
    let found = compare(table, &alone).unwrap();
    let standings = |at: usize| (found[at].own.standing, found[at].best.standing);
    assert_eq!(standings(0), (Standing::NotStored, Standing::NotStored));
    assert_eq!(standings(6), (Standing::Met, Standing::Met));
    let nothing = compare(table, &Runs::new()).unwrap();
    assert!(nothing.iter().all(|cell| cell.best.standing == Standing::NotRun));
}

#[test]
fn numbers_have_the_digits_that_are_asked_for() {
    // Two digits of times and ratios, three of these figures, powers of ten below 0.01 and from 10 000 on.
    let text = page(&run_of([78.04, 3.3e5])).unwrap();
    let line = "| K = 1, 25 % | 4.16e-1 mm | 0.946 ✗ | 2.3 | 3.3e5 | 1.50e-5 ✓ | 3.6e-5 | 78 | POD + GP, 225 simulations |";
    assert!(text.contains(line), "{text}");
    let text = page(&run_of([23.0, 0.4164])).unwrap();
    assert!(text.contains("| 0.946 ✗ | 2.3 | 0.42 | 1.50e-5 ✓ | 3.6e-5 | 23 |"), "{text}");
}

#[test]
fn a_page_without_runs_has_every_figure_and_says_what_was_not_run() {
    let text = page(&Runs::new()).unwrap();
    assert!(
        text.contains("| **All** | 328 | 0 | 0 | 0 | 0 | 328 | 0 | 0 | 0 | 0 | 0 | 328 | 0 |"),
        "{text}"
    );
    assert!(text.contains("| K = 6, 50 % | 3.47e-2 mm | not run | |  | not run | |  |  |"));
    assert!(text.contains("`cargo xtask reproduce-populations --only rectangles"));
}

#[test]
fn every_figure_is_a_number_with_a_place_of_ours() {
    let mut counts = [0; 2];
    for table in &thesis().table {
        for cell in table.cells().unwrap() {
            assert!(cell.limit > 0.0 && !cell.column.is_empty(), "{}", table.place);
            counts[usize::from(table.kind.is_time())] += 1;
        }
        assert!(thesis().run.iter().any(|run| run.name == table.run), "{}", table.run);
    }
    assert_eq!(counts, [297, 31]);
}

#[test]
fn limits_have_the_digits_that_are_printed() {
    let cells: Vec<Cell> = thesis().table.iter().flat_map(|t| t.cells().unwrap()).collect();
    let limit = |printed: &str, what: &str| {
        let cell = cells.iter().find(|cell| cell.printed == printed && cell.what == what).unwrap();
        (cell.limit, cell.digits)
    };
    assert_eq!(limit("4.16e-1", "K = 1, 25 %"), (0.416, 3));
    let short = cells.iter().find(|cell| cell.printed == "0.03").unwrap();
    assert_eq!((short.limit, short.digits), (0.03, 2));
    assert_eq!(limit("2.30e-2", "K = 3, 25 %").1, 3);
    // The distance of an estimate from the truth, 1, and half of its last digit.
    let estimate = cells.iter().find(|cell| cell.printed == "0.994").unwrap();
    assert!((estimate.limit - 0.0065).abs() < 1e-12, "{}", estimate.limit);
    let median = |place| printed_median(place).map(|printed| printed.limit);
    assert_eq!(median(["", "K = 6, M = 40, η = [24, 6]", "err_u"]), Some(0.0347));
    assert_eq!(median(["", "K = 3, M = 40, η = [60, 8], trained further", "volume"]), Some(0.34));
    assert_eq!(median(["", "POD + GP, 225 simulations", "err_u"]), None);
    assert_eq!(median(["heat-1", "Heat-BVP-1, HCGP", "err_u"]), Some(4.9e-5));
    assert_eq!(median(["noise", "Heat-BVP-1, HCGP", "err_u"]), None);
}

#[test]
fn a_marker_of_what_is_not_kept_says_what_is_missing() {
    let said = |page: &str| format!("{:#}", fill(page, &Runs::new()).unwrap_err());
    assert!(said("<!-- table a/b | * | err_u -->\n<!-- end -->").contains("run a is kept"));
    assert!(said("<!-- table a/b | * -->\n<!-- end -->").contains("this has 2"));
    assert!(said("<!-- table a/b | * | err_u -->\n").contains("<!-- end -->"));
    assert_eq!(fill("text\n", &Runs::new()).unwrap(), "text\n");
}
