//! Shares of a budget.

use super::for_budgets::Options;
use clap::Parser;
use sinew_emulate::Budget;

#[test]
fn a_budget_is_shared_by_what_is_run() {
    let parse = |arguments: &[&str]| {
        Options::try_parse_from(std::iter::once(&"organs").chain(arguments)).unwrap()
    };
    let seconds = |options: &Options, minutes: f64| match options.training(minutes, 1) {
        Budget::Seconds(seconds) => seconds,
        other => panic!("{other:?}"),
    };
    let options = parse(&["--only", "liver,twisting-cube", "--budget", "10m"]);
    let sum = seconds(&options, 3.0) + seconds(&options, 2.0);
    assert!((sum - 600.0).abs() < 1e-9, "{sum}");
    // Two networks of each, and none of a regression.
    let more = parse(&["--only", "liver", "--budget", "10m", "--recipe", "pi,dd,regression"]);
    assert!((seconds(&more, 3.0) - 300.0).abs() < 1e-9);
    // One network on the first mesh of the cube, two on the next two, one on the others.
    let cubes = parse(&["--only", "cube-meshes", "--budget", "10m"]);
    let all = 1.0 + 2.0 * 1.0 + 2.0 * 1.5 + 3.0 + 5.0;
    assert!((seconds(&cubes, 1.0) - 600.0 / all).abs() < 1e-9);
    let error = Options::try_parse_from(["organs", "--only", "kidney"]).unwrap_err().to_string();
    assert!(error.contains("twisting-cube"), "{error}");
}
