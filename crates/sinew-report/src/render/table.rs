//! Errors beside times, with verdicts.

use crate::format::{count, digits, seconds, trimmed};
use crate::render::chart::Palette;
use crate::summary::against;
use crate::{Row, Table, Value};
use maud::{Markup, html};

/// Significant digits of errors, and of what is neither error nor time.
const ERROR_DIGITS: usize = 2;
const OTHER_DIGITS: usize = 8;

/// A value as text: a whole number grouped, any other with at most so many digits.
pub(super) fn value(value: &Value, most: usize) -> String {
    match value {
        Value::Nothing => String::new(),
        Value::Number(x) if x.fract() == 0.0 && (0.0..1e15).contains(x) => count(*x as u64),
        Value::Number(x) => trimmed(*x, most),
        Value::Text(text) => text.clone(),
        Value::Distribution(found) => trimmed(found.q50, most.min(5)),
        Value::Several(values) => {
            values.iter().map(|v| self::value(v, most)).collect::<Vec<_>>().join(", ")
        }
    }
}

/// `0.98 to 1.03` for values over several seeds.
fn range(value: &Value, text: &dyn Fn(f64) -> String) -> String {
    match value {
        Value::Distribution(d) if d.density.is_empty() && text(d.q0) != text(d.q100) => {
            format!("{} to {}", text(d.q0), text(d.q100))
        }
        Value::Several(values) => {
            let ranges: Vec<_> = values.iter().map(|v| range(v, text)).collect();
            if ranges.concat().is_empty() { String::new() } else { ranges.join(", ") }
        }
        _ => String::new(),
    }
}

pub(super) fn table(table: &Table, palette: &Palette) -> Markup {
    let columns = table.errors.iter().chain(&table.times).chain(&table.others);
    html! {
        div.scroll tabindex="0" { table {
            thead { tr {
                th scope="col" { "method" }
                @for column in columns { th scope="col" title=(column.about) { (column.head()) } }
            } }
            tbody { @for row in &table.rows { (self::row(table, row, palette)) } }
        } }
        (references(table))
    }
}

fn row(table: &Table, row: &Row, palette: &Palette) -> Markup {
    let best = |pick: fn(&Row) -> &[crate::Cell], column: usize| {
        let own = pick(row)[column].value.median();
        let ranked = || table.ranked().filter(|other| other.subject == row.subject);
        let least = ranked().filter_map(|other| pick(other)[column].value.median());
        ranked().count() > 1
            && ranked().any(|r| std::ptr::eq(r, row))
            && own.is_some()
            && own == least.reduce(f64::min)
    };
    let name = if row.subject.is_empty() { &row.method } else { &row.subject };
    html! {
        tr {
            th scope="row" { (palette.key(&row.method)) (name) small {
                @if !row.subject.is_empty() { (row.method) " " }
                (row.about)
            }
            @for warning in &row.warnings { small.missed { "⚠ " (warning) } } }
            @for (index, cell) in row.errors.iter().enumerate() {
                td.best[best(|r| &r.errors, index)] {
                    @match cell.value.median() {
                        Some(median) => { (digits(median, ERROR_DIGITS)) }
                        None => { (value(&cell.value, ERROR_DIGITS)) }
                    }
                    small {
                        @if cell.note.is_empty() { (range(&cell.value, &|x| digits(x, ERROR_DIGITS))) }
                        (cell.note)
                    }
                    @if let Some(verdict) = &cell.verdict {
                        small.met[verdict.met].missed[!verdict.met] {
                            (if verdict.met { "✓ " } else { "✗ " }) (verdict.text)
                        }
                    }
                }
            }
            @for (index, cell) in row.times.iter().enumerate() {
                td.best[!table.times[index].once && best(|r| &r.times, index)] {
                    (cell.value.median().map_or(String::new(), seconds))
                    small { (range(&cell.value, &seconds)) (compared(table, row, index).unwrap_or_default()) }
                }
            }
            @for cell in &row.others { td {
                (value(&cell.value, OTHER_DIGITS))
                small { (range(&cell.value, &|x| trimmed(x, 4))) (cell.note) }
            } }
        }
    }
}

/// The time beside that of the baseline.
fn compared(table: &Table, row: &Row, column: usize) -> Option<String> {
    let baseline = table.row(table.baseline.as_deref()?)?;
    let time = row.times[column].value.median()?;
    let reference = baseline.times[column].value.median()?;
    let other = baseline.method != row.method && !table.times[column].once;
    other.then(|| against(reference, time))
}

/// References of the errors: one line per reference.
fn references(table: &Table) -> Markup {
    let mut references: Vec<&str> = table.rows.iter().map(|row| row.reference.as_str()).collect();
    references.dedup();
    references.retain(|reference| !reference.is_empty());
    let methods = |reference: &str| {
        let rows = table.rows.iter().filter(|row| row.reference == reference);
        let mut methods: Vec<&str> = rows.map(|row| row.method.as_str()).collect();
        methods.dedup();
        methods.join(", ")
    };
    html! { @if !references.is_empty() { p.note {
        "Errors are measured "
        @for reference in references { "for " b { (methods(reference)) } " against " (reference) "; " }
        "the best of every column is marked among rows of the first reference."
        @if let Some(name) = &table.baseline { " Faster and slower: than " (name) "." }
    } } }
}
