//! Values of runs that may be marks of failure, such as -9999.

use crate::report::format::digits;

/// Gap between a value and all others, over the range of these, from which on it is doubtful: of one that is there once, and of one that
/// repeats, has nines only, or is an output of 0 or −1.
const FAR: [f64; 2] = [10.0, 0.5];
/// Distance from the median beyond which a value is not among the others \[interquartile ranges\].
const APART: f64 = 10.0;
/// Least magnitude of a mark of nines.
const LEAST_MARK: f64 = 999.0;

/// Component of largest magnitude of the values of each run.
pub(super) fn largest(values: &[Vec<f64>]) -> Vec<f64> {
    let of = |values: &Vec<f64>| values.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
    values.iter().filter_map(of).collect()
}

/// Warnings about values that are far outside all others. Parameters repeat in most designs, outputs do not.
pub(super) fn doubts(
    name: &str,
    values: &[f64],
    is_output: bool,
    said: impl Fn(usize) -> String,
) -> Vec<String> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let [low, median, high] = [1, 2, 3].map(|quarter| sorted[quarter * (sorted.len() - 1) / 4]);
    let within = if high > low { APART * (high - low) } else { f64::INFINITY };
    let others: Vec<f64> =
        sorted.iter().copied().filter(|value| (value - median).abs() <= within).collect();
    sorted.dedup();
    let doubt = |value: f64| {
        let mut others = others.iter().copied().filter(|other| *other != value);
        let least = others.next()?;
        let most = others.next_back()?;
        let runs: Vec<usize> = (0..values.len()).filter(|&run| values[run] == value).collect();
        let has_nines = value.abs() >= LEAST_MARK && (value.abs() + 1.0).log10().fract() == 0.0;
        let is_mark = has_nines || is_output && [0.0, -1.0].contains(&value);
        let far = FAR[usize::from(is_mark || (is_output && runs.len() > 1))];
        (most > least && (least - value).max(value - most) > far * (most - least)).then(|| {
            let (first, more) = (said(runs[0]), runs.len() - 1);
            let also = if more > 0 { format!(" and {more} more") } else { String::new() };
            let [value, least, most] = [value, least, most].map(|x| digits(x, 4));
            format!("{name} is {value} in {first}{also}, far from all others ({least} to {most}); leave failed runs out")
        })
    };
    // No value between two others is far from them.
    let ends = |value: &f64| *value <= others[0] || *value >= others[others.len() - 1];
    sorted.iter().copied().filter(ends).filter_map(doubt).collect()
}
