//! Ordinary differential equations.

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
