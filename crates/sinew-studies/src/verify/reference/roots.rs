//! Roots of scalar functions.

use anyhow::{Result, ensure};

/// A root of a continuous function between two points at which its signs differ, to the last bits, by bisection.
///
/// # Errors
/// No change of sign, or a value at an end that is not a number.
pub fn root(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> Result<f64> {
    let [at_low, at_high] = [low, high].map(&f);
    ensure!(
        at_low * at_high <= 0.0,
        "no change of sign between {low} ({at_low:e}) and {high} ({at_high:e}); widen the bracket"
    );
    if at_low == 0.0 {
        return Ok(low);
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            return Ok(middle);
        }
        if (f(middle) < 0.0) == (at_low < 0.0) { low = middle } else { high = middle }
    }
}
