//! Ordinary differential equations.

/// Nodes, weights and error weights of J. R. Dormand and P. J. Prince, J. Comput. Appl. Math. 6 (1980).
const STAGES: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const NODES: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];
/// Steps shorter than this part of the interval mean that the solution does not exist.
const SHORTEST: f64 = 1e-10;

/// Solves `y' = slope(x, y)` from `span[0]` to `span[1]` by the method of Dormand and Prince of order 5(4).
///
/// `tolerance` bounds the error of each step, absolute and relative. `None` where the solution leaves the
/// domain of `slope` (a value that is not finite).
pub fn integrate<const N: usize>(
    slope: impl Fn(f64, &[f64; N]) -> [f64; N],
    span: [f64; 2],
    start: [f64; N],
    tolerance: f64,
) -> Option<[f64; N]> {
    let [mut x, end] = span;
    let mut y = start;
    let mut step = 0.01 * (end - x);
    let mut first = slope(x, &y);
    while x != end {
        if (x + 1.0001 * step - end) * step >= 0.0 {
            step = end - x;
        }
        let (next, last, error) = attempt(&slope, x, &y, first, step);
        let scaled =
            |i: usize| error[i].abs() / (tolerance * (1.0 + y[i].abs().max(next[i].abs())));
        let size = (0..N).map(scaled).fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
        if size <= 1.0 {
            x = if step == end - x { end } else { x + step };
            (y, first) = (next, last);
        }
        let factor = if size.is_finite() { 0.9 * size.max(1e-10).powf(-0.2) } else { 0.1 };
        step *= factor.clamp(0.1, 5.0);
        if x != end && step.abs() < SHORTEST * (end - span[0]).abs() {
            return None;
        }
    }
    y.iter().all(|v| v.is_finite()).then_some(y)
}

/// One step: the new value, the slope there, and the estimated error.
fn attempt<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    x: f64,
    y: &[f64; N],
    first: [f64; N],
    step: f64,
) -> ([f64; N], [f64; N], [f64; N]) {
    let mut slopes = [[0.0; N]; 7];
    slopes[0] = first;
    let mut moved = *y;
    for stage in 0..6 {
        moved = std::array::from_fn(|i| {
            let sum: f64 = (0..=stage).map(|k| STAGES[stage][k] * slopes[k][i]).sum();
            y[i] + step * sum
        });
        slopes[stage + 1] = slope(x + NODES[stage] * step, &moved);
    }
    let error =
        std::array::from_fn(|i| step * (0..7).map(|k| ERROR[k] * slopes[k][i]).sum::<f64>());
    // The last stage is at the new point.
    (moved, slopes[6], error)
}
