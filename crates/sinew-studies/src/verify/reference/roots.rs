//! Roots of scalar functions.

/// A bracket over which a function does not change sign.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no change of sign between {low} ({at_low:e}) and {high} ({at_high:e}); widen the bracket")]
#[expect(missing_docs, reason = "the message says what the fields are")]
pub struct NoSignChange {
    pub low: f64,
    pub high: f64,
    pub at_low: f64,
    pub at_high: f64,
}

/// Halvings that reach neighbouring numbers from any bracket of one sign.
const MOST_HALVINGS: usize = 2000;
/// Steps of the false position before each forced halving, so that the bracket shrinks from both ends.
const FALSE_POSITIONS: usize = 2;

/// A root of a continuous function between two points at which its signs differ, to the last bits.
///
/// Bisection, sped up by the Illinois variant of the false position.
///
/// # Errors
/// [`NoSignChange`], also where the function is not a number at an end.
pub fn root(
    mut f: impl FnMut(f64) -> f64,
    [mut low, mut high]: [f64; 2],
) -> Result<f64, NoSignChange> {
    let (mut at_low, mut at_high) = (f(low), f(high));
    let changes = at_low * at_high <= 0.0;
    if !changes {
        return Err(NoSignChange { low, high, at_low, at_high });
    }
    let (mut weight_low, mut weight_high) = (at_low, at_high);
    for step in 0..MOST_HALVINGS {
        if at_low == 0.0 {
            return Ok(low);
        }
        if at_high == 0.0 {
            return Ok(high);
        }
        let middle = 0.5 * (low + high);
        if !(low.min(high) < middle && middle < low.max(high)) {
            break;
        }
        let secant = high - weight_high * (high - low) / (weight_high - weight_low);
        let inside = secant > low.min(high) && secant < low.max(high);
        let forced = step % (FALSE_POSITIONS + 1) == FALSE_POSITIONS;
        let trial = if inside && !forced { secant } else { middle };
        let value = f(trial);
        if (value < 0.0) == (at_low < 0.0) {
            (low, at_low, weight_low) = (trial, value, value);
            weight_high *= 0.5;
        } else {
            (high, at_high, weight_high) = (trial, value, value);
            weight_low *= 0.5;
        }
    }
    Ok(if at_low.abs() < at_high.abs() { low } else { high })
}
