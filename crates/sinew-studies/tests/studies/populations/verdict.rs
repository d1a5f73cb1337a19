//! Who wins a group of bodies, by the rule of the study.

use measure::Outcome;
use rule::{Entry, blocks};
use sinew_report::{Block, Value};

/// The file of the rule, which reports apply to hours of computing.
#[path = "../../../src/populations/verdict.rs"]
#[allow(dead_code)]
mod rule;

/// Errors of methods, as far as the rule reads them.
mod measure {
    pub(super) struct Outcome {
        pub method: String,
        pub about: String,
        pub group: String,
        pub cpu_s: f64,
        pub errors: Vec<Vec<f64>>,
    }
}

/// Errors in mm, as far as the rule reads them.
mod rows {
    #[allow(dead_code)]
    pub(super) struct Measured {
        pub method: String,
        pub group: String,
        pub errors: Vec<f64>,
        pub cpu_s: f64,
        pub simulated_s: f64,
    }
}

/// Medians in percent, raw and after a step.
fn entry(method: &str, raw: f64, after: impl Into<Option<f64>>, cpu_s: f64) -> Entry {
    let errors = std::iter::once(raw).chain(after.into()).map(|error| vec![error / 100.0]);
    let (method, about, group) = (method.into(), String::new(), "population".into());
    let outcome = Outcome { method, about, group, cpu_s, errors: errors.collect() };
    Entry::of_outcome(&outcome).unwrap()
}

/// Sentences on one group with each seed.
fn said(seeds: &[Vec<Entry>]) -> String {
    let Block::Facts(facts) = blocks(seeds, "%").unwrap().remove(1) else { panic!("no facts") };
    assert_eq!((facts.len(), &*facts[0].0), (1, "population"));
    facts[0].1.clone()
}

/// Winner, if there is one, and the numbers that decided.
struct Verdict {
    winner: Option<String>,
    because: String,
}

fn of(entries: &[Entry]) -> Verdict {
    let text = said(&[entries.to_vec()]);
    let (winner, because) = text.split_once(": ").unwrap();
    Verdict {
        winner: Some(winner).filter(|winner| *winner != "none").map(String::from),
        because: because.into(),
    }
}

#[test]
fn a_method_wins_that_is_lower_in_both_medians_than_all_other_classes() {
    let mut all = vec![
        entry("POD + GP, 400 simulations", 43.0, 42.0, 74.0),
        entry("frozen stiffness", 5.4, 1.1, 0.0),
        entry("network", 9.7, 2.2, 322.0),
        entry("network, dd", 8.2, 7.5, 305.0),
    ];
    let found = of(&all);
    assert_eq!(found.winner.as_deref(), Some("frozen stiffness"), "{}", found.because);
    for number in ["frozen stiffness (5.4 % raw, 1.1 %", "network, dd (8.2 %", "network (9.7 %"] {
        assert!(found.because.contains(number), "{}", found.because);
    }
    // One network with the lower raw error and another with the lower error after a step do not make one with both.
    all[2] = entry("network", 9.7, 1.0, 322.0);
    let found = of(&all);
    assert_eq!(found.winner, None);
    assert!(
        found.because.starts_with("frozen stiffness (5.4 %")
            && found.because.contains("lower raw, network (9.7")
    );
}

#[test]
fn more_cpu_time_does_not_win_and_less_does() {
    let mut all =
        vec![entry("POD + GP, 100 simulations", 2.0, 1.0, 48.0), entry("network", 1.0, 0.1, 191.0)];
    let found = of(&all);
    assert!(found.winner.is_none() && found.because.contains("more CPU time"), "{}", found.because);
    // Regression was given as much and is not lower.
    all.push(entry("POD + GP, 800 simulations", 1.5, 0.5, 300.0));
    assert_eq!(of(&all).winner.as_deref(), Some("network"));
    // What it does with more than the network had does not count.
    all[2] = entry("POD + GP, 800 simulations", 0.5, 0.05, 300.0);
    assert_eq!(of(&all).winner.as_deref(), Some("network"));
    // Nearly the same time is the same time.
    all[2] = entry("POD + GP, 800 simulations", 0.5, 0.05, 230.0);
    assert_eq!(of(&all).winner.as_deref(), Some("regression"));
    all[1] = entry("network", 1.0, 0.1, 10.0);
    assert_eq!(of(&all[..2]).winner.as_deref(), Some("network"));
}

#[test]
fn equal_medians_win_for_nobody() {
    let all = [entry("Taylor expansion", 1.0, 0.5, 0.0), entry("network", 1.0, 0.5, 9.0)];
    let found = of(&all);
    assert!(
        found.winner.is_none() && found.because.contains("equalled by network"),
        "{}",
        found.because
    );
    let all = [entry("Taylor expansion", 1.0, 0.5, 0.0), entry("network", 0.9, 0.5, 9.0)];
    assert_eq!(of(&all).winner, None);
    assert_eq!(of(&all[..1]).winner, None, "nobody to win over");
}

#[test]
fn without_corrections_raw_medians_decide() {
    let mut all = vec![entry("coarse solution", 0.85, None, 0.0), entry("K = 3", 0.25, None, 9.0)];
    assert_eq!(of(&all).winner.as_deref(), Some("network"));
    // Who has a corrected median is not beaten raw alone, and beats who has none.
    all[0] = entry("coarse solution", 0.85, 0.3, 0.0);
    assert_eq!(of(&all).winner, None);
    all[0] = entry("coarse solution", 0.2, 0.3, 0.0);
    assert_eq!(of(&all).winner.as_deref(), Some("solver on a coarse mesh"));
}

#[test]
fn seeds_are_counted_and_their_medians_range_from_the_smallest_to_the_largest() {
    let seed =
        |raw| vec![entry("frozen stiffness", raw, 1.0, 0.0), entry("network", 3.0, 2.0, 60.0)];
    let seeds = [2.0, 2.5, 4.0].map(seed);
    let found = said(&seeds);
    assert!(found.starts_with("frozen stiffness in 2 of 3 seeds: frozen stiffness (2"), "{found}");
    assert!(found.contains("; none in 1 of 3 seeds: network (3"), "{found}");
    assert!(said(&seeds[..1]).starts_with("frozen stiffness: frozen stiffness (2"));
    let Block::Table(table) = blocks(&seeds, "%").unwrap().remove(3) else { panic!("no table") };
    let Value::Distribution(raw) = &table.rows[0].errors[0].value else {
        panic!("no distribution")
    };
    assert_eq!([raw.q0, raw.q50, raw.q100], [2.0, 2.5, 4.0]);
    assert_eq!(blocks(&seeds[..1], "%").unwrap().len(), 2);
    assert_eq!(blocks(&seeds, "%").unwrap().len(), 4);
}
