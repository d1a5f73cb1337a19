//! Who wins, by the rule that was fixed before the study's first run: a method wins a group of bodies if it is lower in both medians, raw and
//! after one Newton step, than every other class of methods at equal CPU time, simulations included.

use super::measure::Outcome;
use super::rows::Measured;
use anyhow::{Context, Result};
use sinew_report::format::digits;
use sinew_report::{Block, Column, Distribution, Row, Table};

/// CPU times are equal up to this factor: on a machine that others keep busy, the same training varies by as much.
const EQUAL: f64 = 1.25;

/// First words of the names of methods, with the class of each; all others are networks.
const CLASSES: [(&str, &str); 6] = [
    ("POD + GP", "regression"),
    ("nearest", "regression"),
    ("mean", "regression"),
    ("Taylor expansion", "taylor"),
    ("frozen stiffness", "frozen stiffness"),
    ("coarse solution", "solver on a coarse mesh"),
];

/// A method on a group, as the rule sees it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    method: String,
    group: String,
    /// Median errors raw and after a Newton step, where there is one, in the unit of the study.
    raw: f64,
    corrected: Option<f64>,
    /// Simulations and training \[s\].
    cpu_s: f64,
}

/// Class with the lowest errors of a group, if there is one, and the numbers that decided.
#[derive(Debug)]
struct Verdict {
    winner: Option<&'static str>,
    because: String,
}

impl Entry {
    /// Verdict with errors in %.
    pub(super) fn of_outcome(outcome: &Outcome) -> Option<Self> {
        let percent = |step: usize| Some(100.0 * median(outcome.errors.get(step)?)?);
        let start = outcome.about.split(';').next();
        let simulations = start.filter(|about| about.ends_with(" simulations"));
        Some(Self {
            method: match simulations {
                Some(count) => format!("{}, {count}", outcome.method),
                None => outcome.method.clone(),
            },
            group: outcome.group.clone(),
            raw: percent(0)?,
            corrected: percent(1),
            cpu_s: outcome.cpu_s,
        })
    }

    /// Verdict with errors in mm, before any correction.
    pub(super) fn of_measured(measured: &Measured) -> Option<Self> {
        let group = if measured.group.is_empty() { "population" } else { &measured.group };
        Some(Self {
            method: measured.method.clone(),
            group: group.into(),
            raw: median(&measured.errors)?,
            corrected: None,
            cpu_s: measured.cpu_s + measured.simulated_s,
        })
    }

    fn class(&self) -> &'static str {
        let found = CLASSES.iter().find(|(start, _)| self.method.starts_with(start));
        found.map_or("network", |(_, class)| class)
    }

    fn after(&self) -> f64 {
        self.corrected.unwrap_or(f64::INFINITY)
    }

    /// Whether both medians are lower, or the only one where the other was not corrected.
    fn is_lower(&self, other: &Self) -> bool {
        self.raw < other.raw && (other.corrected.is_none() || self.after() < other.after())
    }

    fn words(&self, unit: &str) -> String {
        let Self { method, raw, corrected, cpu_s, .. } = self;
        let after = corrected.map(|error| format!(", {} {unit} after a step", digits(error, 2)));
        let after = after.unwrap_or_default();
        format!("{method} ({} {unit} raw{after}, {cpu_s:.0} CPU s)", digits(*raw, 2))
    }
}

fn median(errors: &[f64]) -> Option<f64> {
    Distribution::of(errors.to_vec()).map(|errors| errors.q50)
}

/// Entries that take part, and whether each is within the CPU time at which classes are compared: the least that any class was
/// given. A class with no entry by then takes part with its later ones: these may keep others from the lowest error, and never have it.
fn at_equal_time<'a>(entries: &[&'a Entry]) -> Vec<(&'a Entry, bool)> {
    let of_class = |class: &'static str| entries.iter().filter(move |e| e.class() == class);
    let given = |e: &&Entry| of_class(e.class()).fold(0.0, |most: f64, e| most.max(e.cpu_s));
    let given = entries.iter().map(given).filter(|seconds| *seconds > 0.0);
    let time = EQUAL * given.fold(f64::INFINITY, f64::min);
    let takes_part =
        |e: &Entry| e.cpu_s <= time || of_class(e.class()).all(|other| other.cpu_s > time);
    let part = entries.iter().filter(|e| takes_part(e));
    part.map(|e| (*e, e.cpu_s <= time)).collect()
}

/// The rule on one group.
fn verdict(entries: &[&Entry], unit: &str) -> Verdict {
    let all = at_equal_time(entries);
    let none = |because: String| Verdict { winner: None, because };
    let rivals = |of: &Entry| -> Vec<&Entry> {
        all.iter().map(|(e, _)| *e).filter(|e| e.class() != of.class()).collect()
    };
    let wins = |e: &Entry| rivals(e).iter().all(|rival| e.is_lower(rival));
    let everyone: Vec<&Entry> = all.iter().map(|(e, _)| *e).collect();
    let Some([raw, after]) = least(&everyone) else { return none("nothing was measured".into()) };
    let Some(others) = least(&rivals(raw)) else {
        return none("there is one class of methods only".into());
    };
    let [found, other] = [[raw, after], others].map(|pair| pair.map(|e| e.words(unit)));
    let other = if other[0] == other[1] { other[0].clone() } else { other.join(" and ") };
    let winner = all.iter().filter(|(e, _)| wins(e)).min_by(|a, b| a.0.raw.total_cmp(&b.0.raw));
    match winner {
        Some((winner, true)) => {
            let because = format!("{}, before {other}", winner.words(unit));
            Verdict { winner: Some(winner.class()), because }
        }
        Some((late, false)) => {
            let late = late.words(unit);
            none(format!("{late} is lower, but with more CPU time than {other} had"))
        }
        None if found[0] == found[1] => none(format!("{} is equalled by {other}", found[0])),
        None => none(format!("{} is lower raw, {} after a step", found[0], found[1])),
    }
}

/// The entries with the lowest error raw and after a step.
fn least<'a>(of: &[&'a Entry]) -> Option<[&'a Entry; 2]> {
    let by = |key: fn(&Entry) -> [f64; 2]| {
        let order = |a: [f64; 2], b: [f64; 2]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]));
        of.iter().copied().min_by(|a, b| order(key(a), key(b)))
    };
    Some([by(|e| [e.raw, e.after()])?, by(|e| [e.after(), e.raw])?])
}

/// The rule on one group with every seed: how often each class has the lowest errors, and the numbers of the first of these seeds.
fn tally(seeds: &[Vec<Entry>], group: &str, unit: &str) -> String {
    let mut found: Vec<(Verdict, usize)> = Vec::new();
    for seed in seeds {
        let entries: Vec<&Entry> = seed.iter().filter(|e| e.group == group).collect();
        let verdict = verdict(&entries, unit);
        match found.iter_mut().find(|(earlier, _)| earlier.winner == verdict.winner) {
            Some((_, count)) => *count += 1,
            None => found.push((verdict, 1)),
        }
    }
    let words = |(Verdict { winner, because }, count): &(Verdict, usize)| {
        let seeds = match seeds.len() {
            1 => String::new(),
            all => format!(" in {count} of {all} seeds"),
        };
        format!("{}{seeds}: {because}", winner.unwrap_or("none"))
    };
    found.iter().map(words).collect::<Vec<_>>().join("; ")
}

/// Who wins every group; and, where there are several seeds, the medians with each.
pub(super) fn blocks(seeds: &[Vec<Entry>], unit: &str) -> Result<Vec<Block>> {
    let first = seeds.first().context("no seed")?;
    let corrected = first.iter().any(|e| e.corrected.is_some());
    let medians =
        if corrected { "both medians, raw and after a Newton step," } else { "the median" };
    let rule = format!(
        "Who wins: the method that is lower in {medians} than all of other classes at equal CPU time, simulations included."
    );
    let is_first =
        |(index, e): &(usize, &Entry)| first[..*index].iter().all(|f| f.group != e.group);
    let groups = first.iter().enumerate().filter(is_first).map(|(_, e)| e.group.clone());
    let facts = groups.map(|group| {
        let who = tally(seeds, &group, unit);
        (group, who)
    });
    let mut blocks = vec![Block::Text(rule), Block::Facts(facts.collect())];
    if seeds.len() > 1 {
        blocks.push(Block::Text(format!("Over {} seeds:", seeds.len())));
        blocks.push(Block::Table(over_seeds(seeds, corrected, unit)?));
    }
    Ok(blocks)
}

/// Verdict on methods whose errors are in mm: those of each seed.
pub(super) fn of_measured<'a, S: Iterator<Item = &'a Measured>>(
    seeds: impl Iterator<Item = S>,
) -> Result<Vec<Block>> {
    let entries = |seed: S| seed.filter_map(Entry::of_measured).collect();
    blocks(&seeds.map(entries).collect::<Vec<_>>(), "mm")
}

fn over_seeds(seeds: &[Vec<Entry>], corrected: bool, unit: &str) -> Result<Table> {
    let about = "median with each seed: the median of these, the smallest and the largest";
    let column = |name| Column::new(name, unit).about(about);
    let after = corrected.then(|| column("median, 1 step"));
    let errors = std::iter::once(column("median, raw")).chain(after);
    let mut table = Table::new(errors, [Column::new("CPU", "s").once()], []);
    for (index, entry) in seeds[0].iter().enumerate() {
        // The methods of a study come in the same order with every seed.
        let same = |e: &&Entry| e.class() == entry.class() && e.group == entry.group;
        let with: Vec<&Entry> = seeds.iter().filter_map(|s| s.get(index).filter(same)).collect();
        let over = |value: &dyn Fn(&Entry) -> Option<f64>| {
            Distribution::of(with.iter().filter_map(|e| value(e)).collect())
        };
        let raw = over(&|e| Some(e.raw)).context("no seed")?;
        let cpu = over(&|e| Some(e.cpu_s)).context("no seed")?;
        let row = Row::new(entry.method.clone(), raw, cpu)?;
        let mut row = Row { subject: entry.group.clone(), ..row };
        if corrected {
            row = row.error(over(&|e| e.corrected));
        }
        table.push(row)?;
    }
    Ok(table)
}
