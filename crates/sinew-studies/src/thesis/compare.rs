//! A printed figure against ours: by the thesis' own kind of method, and by the best.

use super::printed::{Cell, Kind, Table, thesis};
use super::stored::{Found, Stored};
use anyhow::Result;
use sinew_report::format::rounded;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Runs by name.
pub type Runs = BTreeMap<String, Stored>;

/// Result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// At or below the printed figure in its digits (at or above, for a gain).
    Met,
    /// Not so.
    Missed,
    /// A time beside one of other hardware or of a solver: neither.
    Beside,
    /// A run has the method but not this statistic.
    NotStored,
    /// No run has the method.
    NotRun,
}

impl Standing {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Met, Self::Missed, Self::Beside, Self::NotStored, Self::NotRun];

    /// Name on the page.
    pub fn name(self) -> &'static str {
        ["met", "missed", "neither", "not stored", "not run"][self as usize]
    }
}

/// A figure of ours beside a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Ours {
    /// Result.
    pub standing: Standing,
    /// Value in the thesis' unit, method and cost, where there is one.
    pub found: Option<Found>,
    /// Ours over the limit; for a gain the other way round.
    pub ratio: f64,
    /// Ratios with other seeds, where it is [`NEAR`] 1 and there are such runs.
    pub again: Vec<f64>,
}

/// Ratios that another seed may carry to the other side of 1.
pub const NEAR: RangeInclusive<f64> = 0.8..=1.25;

/// A printed figure with ours.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// The printed figure.
    pub cell: Cell,
    /// Limit, in proportion to displacements where the table says so.
    pub limit: f64,
    /// Figure of the thesis' kind of method.
    pub own: Ours,
    /// Figure of the method of least error.
    pub best: Ours,
}

/// Compares all figures of a table.
///
/// # Errors
/// A table that is not well formed, or a run without the displacement that limits are in proportion to.
pub fn compare(table: &Table, runs: &Runs) -> Result<Vec<Compared>> {
    let names = [&table.run, &table.rivals];
    let repeats = thesis().run.iter().filter(|run| run.repeats == table.run);
    let repeats: Vec<&Stored> = repeats.filter_map(|run| runs.get(&run.name)).collect();
    let runs: Vec<&Stored> = names.into_iter().filter_map(|name| runs.get(name)).collect();
    table.cells()?.into_iter().map(|cell| one(table, cell, &runs, &repeats)).collect()
}

fn one(table: &Table, cell: Cell, runs: &[&Stored], repeats: &[&Stored]) -> Result<Compared> {
    let factor = match (&table.scale, runs.first()) {
        (Some(scale), Some(run)) => run.mean_of_fact(&scale.fact)? / scale.printed,
        _ => 1.0,
    };
    let limit = if factor == 1.0 { cell.limit } else { rounded(cell.limit * factor, cell.digits) };
    let place = [&*table.section, &*cell.own, &*cell.column];
    let of = |run: &&Stored| {
        run.value(place, cell.statistic).and_then(|found| in_unit(table, &cell, run, found))
    };
    let own = runs.iter().find_map(of);
    let judged = |found: Option<Found>| {
        let Some(found) = found else {
            let there = runs.iter().any(|run| run.has(&table.section, &cell.own));
            let standing = if there { Standing::NotStored } else { Standing::NotRun };
            return Ours { standing, found: None, ratio: f64::NAN, again: Vec::new() };
        };
        let ours = rounded(found.value, cell.digits);
        let (met, ratio) = match table.kind.grows() {
            true => (ours >= limit * (1.0 - ROUNDING), limit / found.value),
            false => (ours <= limit * (1.0 + ROUNDING), found.value / limit),
        };
        let standing = match met {
            _ if cell.is_beside() => Standing::Beside,
            true => Standing::Met,
            false => Standing::Missed,
        };
        Ours { standing, found: Some(found), ratio, again: Vec::new() }
    };
    let least = |run: &&Stored, step: bool| {
        let subject = run.subject(place).unwrap_or_default();
        let all = [&*table.section, subject, &*cell.column];
        let found = run.least(all, &cell.best, (cell.statistic, step))?;
        in_unit(table, &cell, run, found)
    };
    let better = |a: &Found, b: &Found| match table.kind.grows() {
        true => b.value.total_cmp(&a.value),
        false => a.value.total_cmp(&b.value),
    };
    let best = |steps: &[bool]| {
        let all = steps.iter().flat_map(|step| runs.iter().filter_map(|run| least(run, *step)));
        judged(all.chain(own.clone()).min_by(better))
    };
    let raw = best(&[false]);
    // A gain over a row that has no step takes none either.
    let steps = raw.standing == Standing::Missed && table.kind == Kind::Error;
    let best = if steps { best(&[false, true]) } else { raw };
    let mut own = judged(own);
    if NEAR.contains(&own.ratio) {
        own.again = repeats.iter().filter_map(of).map(|found| judged(Some(found)).ratio).collect();
    }
    Ok(Compared { limit, own, best, cell })
}

/// Rounding of a product of two decimals.
const ROUNDING: f64 = 1e-9;

/// A value in the thesis' unit; relative to that of another row for gains and growths.
fn in_unit(table: &Table, cell: &Cell, run: &Stored, found: Found) -> Option<Found> {
    if table.kind == Kind::Error {
        return Some(found);
    }
    let value = match table.kind {
        Kind::Time => found.value / seconds(&cell.unit),
        kind => {
            let over = run.value([&*table.section, &*cell.over, &*cell.column], cell.statistic)?;
            if kind.grows() { over.value / found.value } else { found.value / over.value }
        }
    };
    Some(Found { value, ..found })
}

fn seconds(unit: &str) -> f64 {
    match unit {
        "ms" => 1e-3,
        "min" => 60.0,
        _ => 1.0,
    }
}
