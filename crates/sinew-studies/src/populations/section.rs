//! Section of the report about one population.

use super::measure::{CORRECTIONS, Outcome};
use super::stage::Stage;
use super::verdict::{self, Entry};
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use sinew_report::{Block, Cell, Column, Distribution, Row, Section, Table};

/// Everything measured on a population.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Study {
    pub facts: Vec<(String, String)>,
    pub outcomes: Vec<Outcome>,
}

/// The section of a population, with every seed.
pub(super) fn section(key: &str, studies: &[Study]) -> Result<Section> {
    let study = studies.first().context("no seed")?;
    let entries = |study: &Study| study.outcomes.iter().filter_map(Entry::of_outcome).collect();
    let entries: Vec<Vec<Entry>> = studies.iter().map(entries).collect();
    let table = table(study)?;
    let stage = Stage::new(key, true)?;
    let mut blocks = vec![
        Block::Text(stage.about.into()),
        Block::Facts(study.facts.clone()),
        Block::Table(table),
    ];
    blocks.extend(verdict::blocks(&entries, "%")?);
    Ok(Section { name: key.into(), title: format!("A population of {key}"), blocks })
}

fn table(study: &Study) -> Result<Table> {
    let percent = |name: &str, about: &str| Column::new(name, "%").about(about);
    // Not every population has a cavity.
    let cavities = study.outcomes.iter().any(|outcome| !outcome.volumes.is_empty());
    let volume = cavities.then(|| percent("volume", "|V − V̂| / V of the cavity, raw"));
    let mut table = Table::new(
        [
            percent("raw", "‖u − û‖ / ‖u‖ of each individual"),
            percent("1 step", "after one Newton step"),
            percent("2 steps", "after two"),
        ]
        .into_iter()
        .chain(volume),
        [
            Column::new("answer", "s").about("the first for a shape, all that it needs included"),
            Column::new("CPU", "s").once().about("simulations and training, on all threads"),
        ],
        OTHERS.map(|(name, unit, about, _)| Column::new(name, unit).about(about)),
    );
    for outcome in &study.outcomes {
        let many = |values: &[f64], factor: f64| {
            Distribution::of(values.iter().map(|value| factor * value).collect())
        };
        let answer = many(&outcome.answer_s, 1.0).context("no individual")?;
        let raw = many(&outcome.errors[0], 100.0).context("no individual")?;
        let mut row = Row {
            subject: outcome.group.clone(),
            about: outcome.about.clone(),
            reference: "our finite-element solution on the same mesh".into(),
            ..Row::new(outcome.method.clone(), raw, answer)?
        };
        for step in 1..=CORRECTIONS {
            row = row.error(many(&outcome.errors[step], 100.0));
        }
        if cavities {
            row = row.error(many(&outcome.volumes, 100.0));
        }
        let others = OTHERS.map(|(.., value)| Cell::from(value(outcome)));
        table.push(Row { others: others.into(), ..row.time(outcome.cpu_s) })?;
    }
    Ok(table)
}

/// A column by name, unit and what it says, and its value.
type Other = (&'static str, &'static str, &'static str, fn(&Outcome) -> Option<f64>);

const OTHERS: [Other; 6] = [
    (
        "estimates",
        "%",
        "of error estimates within a factor two: the length of a Newton step from the prediction over that of its error",
        |outcome| Some(outcome.estimates_within_two().round()),
    ),
    ("iterations", "", "median, of a solve from the prediction to its end", |outcome| {
        Distribution::of(outcome.iterations.clone()).map(|found| found.q50)
    }),
    ("no end", "", "predictions that such a solve does not end from", |outcome| {
        Some(outcome.unfinished as f64)
    }),
    ("inverted", "", "predictions that no Newton step corrects", |outcome| {
        Some(outcome.inverted as f64)
    }),
    (
        "elsewhere",
        "",
        "predictions from which a solve ends at another equilibrium than from rest",
        |outcome| Some(outcome.elsewhere as f64),
    ),
    ("lower", "", "of these, such with less energy", |outcome| Some(outcome.lower as f64)),
];
