//! Numbers of a shape and of its cells.

use anyhow::{Result, ensure};

pub(super) fn check_cells(found: &[usize], fit: bool, needed: &str) -> Result<()> {
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    ensure!(fit, "a mesh cannot have {} cells; give {needed}", found.join(" x "));
    Ok(())
}

/// At most `N` finite numbers, followed by zeros.
pub(super) fn padded<const N: usize>(numbers: &[f64]) -> Result<[f64; N]> {
    let fits = numbers.len() <= N && numbers.iter().all(|x| x.is_finite());
    let found = numbers.len();
    ensure!(
        fits,
        "a shape has {N} finite numbers; {found} were given, or one of them is not finite"
    );
    Ok(std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0)))
}
