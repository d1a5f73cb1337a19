//! Summary of a table, in sentences made from its numbers.

use crate::format::{count, digits, factor, rounded, seconds};
use crate::{Row, Table};

impl Table {
    /// The most accurate method, the speed of each method against the baseline, and the number of predictions that repays
    /// preparation.
    pub fn summary(&self) -> Vec<String> {
        [self.accuracy(), self.speed(), self.payback()].into_iter().flatten().collect()
    }

    fn accuracy(&self) -> Option<String> {
        let best = |(number, column): (usize, &crate::Column)| {
            let median = |row: &Row| row.errors[number].value.median();
            let mut found: Vec<_> =
                self.ranked().filter_map(|row| Some((median(row)?, &row.method))).collect();
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            let [first, second, ..] = found[..] else { return None };
            let behind = match second.0 / first.0 {
                ratio if ratio < 1.05 => "the same".to_string(),
                ratio => format!("{} as much", factor(ratio)),
            };
            let error = format!("{} {}", digits(first.0, 2), column.unit);
            let (error, name) = (error.trim_end(), &column.name);
            Some(format!("{name} {} ({error}; {} {behind})", first.1, second.1))
        };
        let parts: Vec<_> = self.errors.iter().enumerate().filter_map(best).collect();
        (!parts.is_empty()).then(|| format!("Most accurate by median: {}.", parts.join(", ")))
    }

    /// Rows to be compared with the baseline, and its time of one prediction.
    fn compared(&self) -> Option<(&Row, usize, Vec<&Row>)> {
        let baseline = self.row(self.baseline.as_deref()?)?;
        // The second time that is not paid once, or the first if there is only one.
        let repeated: Vec<_> = (0..self.times.len()).filter(|&t| !self.times[t].once).collect();
        let column = *repeated.get(1).or(repeated.first())?;
        let rows = self.ranked().filter(|row| row.method != baseline.method).collect();
        Some((baseline, column, rows))
    }

    fn speed(&self) -> Option<String> {
        let (baseline, column, rows) = self.compared()?;
        let reference = baseline.times[column].value.median()?;
        let part = |row: &&Row| {
            let time = row.times[column].value.median()?;
            Some(format!("{} {} ({})", row.method, seconds(time), against(reference, time)))
        };
        let parts = first_of(rows.iter().filter_map(part).collect());
        let (name, about) = (&baseline.method, &self.times[column].name);
        let reference = seconds(reference);
        Some(format!("Time of one prediction ({about}) beside {name}, {reference}: {parts}."))
    }

    fn payback(&self) -> Option<String> {
        let (baseline, column, rows) = self.compared()?;
        let part = |row: &&Row| {
            let [ours, theirs] = [row, baseline].map(|row| row.times[column].value.median());
            let times = row.times.iter().zip(&self.times).filter(|(_, column)| column.once);
            let spent: f64 = times.filter_map(|(cell, _)| cell.value.median()).sum();
            let saved = theirs? - ours?;
            Some(match saved > 0.0 {
                true => {
                    let after = rounded((spent / saved).ceil(), 2) as u64;
                    format!("{} after {} predictions", row.method, count(after))
                }
                false => format!("{} never", row.method),
            })
        };
        let parts = first_of(rows.iter().filter_map(part).collect());
        let once = self.times.iter().any(|column| column.once);
        let name = &baseline.method;
        once.then(|| format!("Preparation and training pay off against {name}: {parts}."))
    }
}

/// Rows that a sentence names; the table has the others.
const MOST_NAMED: usize = 8;

/// The first of some parts of a sentence, and how many more there are.
fn first_of(parts: Vec<String>) -> String {
    let more = parts.len().saturating_sub(MOST_NAMED);
    let named = parts[..parts.len() - more].join(", ");
    if more == 0 { named } else { format!("{named}, and {more} more in the table") }
}

/// `29× faster`
pub(crate) fn against(reference: f64, time: f64) -> String {
    match reference / time {
        ratio if !ratio.is_finite() || ratio <= 0.0 => "no ratio".into(),
        ratio if ratio >= 1.0 => format!("{} faster", factor(ratio)),
        ratio => format!("{} slower", factor(1.0 / ratio)),
    }
}
