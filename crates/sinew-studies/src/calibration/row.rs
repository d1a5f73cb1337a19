//! Rows of the listings.

use sinew_report::Cell;

/// A row of a listing, which is printed too.
pub(super) fn row(name: &str, head: &[&str], numbers: &[f64]) -> Vec<Cell> {
    let said = head.iter().zip(numbers).filter(|(_, number)| !number.is_nan());
    let said: Vec<String> = said.map(|(head, number)| format!("{head} {number:.3}")).collect();
    println!("{name}: {}", said.join(", "));
    let cell = |number: &f64| if number.is_nan() { Cell::default() } else { Cell::from(*number) };
    std::iter::once(Cell::from(name)).chain(numbers.iter().map(cell)).collect()
}
