//! Error estimates against true errors.

use clap::Parser;
use serde_json::Value;
use sinew_studies::coverage::{Options, run};
use std::path::Path;

/// Outcomes of a run on the bodies of a name.
fn outcomes(name: &str, out: &Path) -> Vec<Value> {
    let fixed = ["coverage", "--recipe", "taylor,regression", "--cases", "12", "--meshes"];
    let more = ["no such folder", "--only", name];
    let options = Options::try_parse_from(fixed.into_iter().chain(more)).unwrap();
    run(&Options { out: out.into(), ..options }).unwrap();
    let text = std::fs::read_to_string(out.join("coverage.json")).unwrap();
    let stored: Value = serde_json::from_str(&text).unwrap();
    stored[1].as_array().unwrap().clone()
}

#[test]
fn estimates_hold_on_a_soft_block_and_a_balloon_beyond_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["soft block", "balloon beyond its limit"] {
        let outcomes = outcomes(name, folder.path());
        assert_eq!(outcomes.len(), 6);
        let count = |outcome: &Value, of: &str| outcome[of].as_u64().unwrap();
        let ratios = |outcome: &Value| outcome["ratios"].as_array().unwrap().clone();
        for outcome in &outcomes {
            println!("{outcome}");
            let understated = ratios(outcome).iter().filter(|r| r.as_f64().unwrap() > 2.0).count();
            assert_eq!((understated, count(outcome, "hopeless_estimated")), (0, 0));
        }
        let sum = |of: &str| outcomes.iter().map(|outcome| count(outcome, of)).sum::<u64>();
        assert!(outcomes.iter().any(|outcome| !ratios(outcome).is_empty()) && sum("good") > 0);
        assert!(50 * sum("good_refused") <= sum("good"));
        assert_eq!(name == "soft block", sum("hopeless") == 0);
    }
}
