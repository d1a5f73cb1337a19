//! Rows of the listings.

use sinew_report::{Block, Cell};

/// A row of a listing, which is printed too.
pub(super) fn row(name: &str, head: &[&str], numbers: &[f64]) -> Vec<Cell> {
    let said = head.iter().zip(numbers).filter(|(_, number)| !number.is_nan());
    let said: Vec<String> = said.map(|(head, number)| format!("{head} {number:.3}")).collect();
    println!("{name}: {}", said.join(", "));
    let cell = |number: &f64| if number.is_nan() { Cell::default() } else { Cell::from(*number) };
    std::iter::once(Cell::from(name)).chain(numbers.iter().map(cell)).collect()
}

/// A listing whose rows have a name and a number under each of some heads.
pub(super) fn listing(
    title: impl Into<String>,
    first: &str,
    names: &[&str],
    rows: Vec<Vec<Cell>>,
) -> Block {
    let head = [first].iter().chain(names).map(|name| name.to_string()).collect();
    Block::Listing { title: title.into(), head, rows }
}
