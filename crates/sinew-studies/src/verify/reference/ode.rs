//! Ordinary differential equations, roots of scalar functions, and the elastica: large bending of a thin cantilever.

use anyhow::{Result, ensure};
use std::f64::consts::FRAC_PI_2;

/// Steps over an interval: the error of smooth solutions is near their fourth power, 1e-13 of them.
const STEPS: usize = 2000;

/// Solves `y' = slope(x, y)` from `from` to `to` by the classical method of Runge and Kutta; `None` where the solution leaves the
/// domain of `slope` (a value that is not finite).
pub fn integrate<const N: usize>(
    slope: impl Fn(f64, &[f64; N]) -> [f64; N],
    [from, to]: [f64; 2],
    start: [f64; N],
) -> Option<[f64; N]> {
    let step = (to - from) / STEPS as f64;
    let mut y = start;
    for number in 0..STEPS {
        let x = from + step * number as f64;
        let moved = |part: f64, slope: &[f64; N]| std::array::from_fn(|i| y[i] + part * slope[i]);
        let first = slope(x, &y);
        let second = slope(x + 0.5 * step, &moved(0.5 * step, &first));
        let third = slope(x + 0.5 * step, &moved(0.5 * step, &second));
        let last = slope(x + step, &moved(step, &third));
        let sum = |i: usize| first[i] + 2.0 * (second[i] + third[i]) + last[i];
        y = std::array::from_fn(|i| y[i] + step / 6.0 * sum(i));
    }
    y.iter().all(|value| value.is_finite()).then_some(y)
}

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

/// A cantilever that neither stretches nor shears, under a dead load across it: Euler's `EIθ″ = −Q cos θ` with
/// the load Q beyond each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elastica {
    /// A force at the tip; the number is `PL²/EI`.
    TipLoad(f64),
    /// A uniform load per length; the number is `qL³/EI`.
    UniformLoad(f64),
}

impl Elastica {
    /// Distance of the tip from the clamp along the straight beam and its deflection, both over the length, by shooting from the
    /// tip, where the curvature is zero.
    ///
    /// # Errors
    /// Loads that are not positive.
    pub fn tip(self) -> Result<[f64; 2]> {
        let at_clamp = |angle: f64| {
            let start = [angle, 0.0, 0.0, 0.0];
            integrate(|s, y| self.slope(s, y), [0.0, 1.0], start).unwrap_or([f64::NAN; 4])
        };
        let angle = root(|angle| at_clamp(angle)[0], [0.0, FRAC_PI_2])?;
        let [_, _, along, across] = at_clamp(angle);
        Ok([along, across])
    }

    /// Slopes of angle, curvature and position over the distance from the tip.
    fn slope(self, s: f64, &[angle, curvature, _, _]: &[f64; 4]) -> [f64; 4] {
        let load = match self {
            Self::TipLoad(load) => load,
            Self::UniformLoad(load) => load * s,
        };
        [curvature, -load * angle.cos(), angle.cos(), angle.sin()]
    }
}
