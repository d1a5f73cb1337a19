//! Minimisation within a box by a limited-memory quasi-Newton method.

use std::collections::VecDeque;

/// End of a minimisation.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub point: Vec<f64>,
    pub value: f64,
    pub evaluations: usize,
}

/// Steps remembered for the approximate Hessian.
const MEMORY: usize = 20;
/// Largest component of the projected gradient, in units of the objective, that counts as zero.
const GRADIENT_TOLERANCE: f64 = 1e-5;
/// Relative decrease of the objective below which a step counts as none; two in a row end it.
const DECREASE_TOLERANCE: f64 = 2e-9;
/// Sufficient decrease and curvature of the line search (Nocedal & Wright 2006, §3.1).
const ARMIJO: f64 = 1e-4;
const WOLFE: f64 = 0.9;
const LINE_SEARCH_STEPS: usize = 25;

/// An objective's value and gradient; `None` where it has none.
pub(crate) type Evaluated = Option<(f64, Vec<f64>)>;

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

struct Search<F> {
    objective: F,
    bounds: Vec<[f64; 2]>,
    evaluations: usize,
    memory: VecDeque<(Vec<f64>, Vec<f64>)>,
}

impl<F: FnMut(&[f64]) -> Evaluated> Search<F> {
    fn evaluate(&mut self, x: &[f64]) -> Evaluated {
        self.evaluations += 1;
        (self.objective)(x)
            .filter(|(value, gradient)| value.is_finite() && gradient.iter().all(|g| g.is_finite()))
    }

    /// Whether each variable may move against the gradient.
    fn free(&self, x: &[f64], gradient: &[f64]) -> Vec<bool> {
        x.iter()
            .zip(gradient)
            .zip(&self.bounds)
            .map(|((x, g), [lower, upper])| !(*x <= *lower && *g > 0.0 || *x >= *upper && *g < 0.0))
            .collect()
    }

    fn moved(&self, x: &[f64], direction: &[f64], step: f64) -> Vec<f64> {
        x.iter()
            .zip(direction)
            .zip(&self.bounds)
            .map(|((x, d), [lower, upper])| (x + step * d).clamp(*lower, *upper))
            .collect()
    }

    /// The two-loop recursion on the free variables.
    fn direction(&self, gradient: &[f64], free: &[bool]) -> Vec<f64> {
        let mask = |v: &mut [f64]| {
            v.iter_mut().zip(free).filter(|(_, free)| !**free).for_each(|(v, _)| *v = 0.0);
        };
        let mut q: Vec<f64> = gradient.iter().map(|g| -g).collect();
        mask(&mut q);
        let steepest = q.clone();
        let mut alphas = Vec::new();
        for (s, y) in self.memory.iter().rev() {
            let alpha = dot(s, &q) / dot(s, y);
            q.iter_mut().zip(y).for_each(|(q, y)| *q -= alpha * y);
            alphas.push(alpha);
        }
        let scale = match self.memory.back() {
            Some((s, y)) => dot(s, y) / dot(y, y),
            // A first step of at most one tenth: parameters are logarithms.
            None => 0.1 / steepest.iter().fold(1.0, |m: f64, g| m.max(g.abs())),
        };
        q.iter_mut().for_each(|q| *q *= scale);
        for ((s, y), alpha) in self.memory.iter().zip(alphas.iter().rev()) {
            let beta = dot(y, &q) / dot(s, y);
            q.iter_mut().zip(s).for_each(|(q, s)| *q += (alpha - beta) * s);
        }
        mask(&mut q);
        if dot(&q, &steepest) > 0.0 { q } else { steepest }
    }

    /// A step with sufficient decrease, and if possible sufficient curvature.
    fn line_search(
        &mut self,
        x: &[f64],
        (value, gradient): (f64, &[f64]),
        direction: &[f64],
    ) -> Option<(Vec<f64>, f64, Vec<f64>)> {
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut step = 1.0;
        let mut best = None;
        let slope = dot(gradient, direction);
        for _ in 0..LINE_SEARCH_STEPS {
            let candidate = self.moved(x, direction, step);
            let displacement: Vec<f64> = candidate.iter().zip(x).map(|(c, x)| c - x).collect();
            let expected = dot(gradient, &displacement);
            match self.evaluate(&candidate) {
                Some((f, g)) if f <= value + ARMIJO * expected => {
                    let curved = dot(&g, direction) >= WOLFE * slope;
                    let clipped =
                        displacement.iter().zip(direction).any(|(d, full)| *d != step * full);
                    best = Some((candidate, f, g));
                    if curved || clipped {
                        break;
                    }
                    low = step;
                }
                // Backtracking after a longer step was tried: the shorter one will do.
                _ if best.is_some() => break,
                _ => high = step,
            }
            step = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * step };
        }
        best
    }
}

/// A local minimum of `objective` within `bounds`, from `start`; `None` if it has no value there.
///
/// `watch` sees every accepted point.
pub(crate) fn minimise(
    objective: impl FnMut(&[f64]) -> Evaluated,
    start: &[f64],
    bounds: &[[f64; 2]],
    most_iterations: usize,
    mut watch: impl FnMut(&[f64], f64),
) -> Option<Minimum> {
    let mut search =
        Search { objective, bounds: bounds.to_vec(), evaluations: 0, memory: VecDeque::new() };
    let mut x = search.moved(start, &vec![0.0; start.len()], 0.0);
    let (mut value, mut gradient) = search.evaluate(&x)?;
    watch(&x, value);
    let mut idle = 0;
    for _ in 0..most_iterations {
        let free = search.free(&x, &gradient);
        let largest = gradient
            .iter()
            .zip(&free)
            .filter(|(_, f)| **f)
            .fold(0.0_f64, |m, (g, _)| m.max(g.abs()));
        if largest < GRADIENT_TOLERANCE {
            break;
        }
        let direction = search.direction(&gradient, &free);
        let Some((next, f, g)) = search.line_search(&x, (value, &gradient), &direction) else {
            if search.memory.is_empty() {
                break;
            }
            // The memory misled; once more from the gradient alone.
            search.memory.clear();
            continue;
        };
        let s: Vec<f64> = next.iter().zip(&x).map(|(n, x)| n - x).collect();
        let y: Vec<f64> = g.iter().zip(&gradient).map(|(n, g)| n - g).collect();
        if dot(&s, &y) > 1e-12 * dot(&y, &y) {
            search.memory.push_back((s, y));
            if search.memory.len() > MEMORY {
                search.memory.pop_front();
            }
        }
        let decrease = (value - f) / value.abs().max(f.abs()).max(1.0);
        (x, value, gradient) = (next, f, g);
        watch(&x, value);
        idle = if decrease < DECREASE_TOLERANCE { idle + 1 } else { 0 };
        if idle == 2 {
            break;
        }
    }
    Some(Minimum { point: x, value, evaluations: search.evaluations })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rosenbrock(x: &[f64]) -> Evaluated {
        let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
        Some((a * a + 100.0 * b * b, vec![-2.0 * a - 400.0 * x[0] * b, 200.0 * b]))
    }

    #[test]
    fn finds_the_valley_and_stops_at_bounds() {
        let free = minimise(rosenbrock, &[-1.2, 1.0], &[[-5.0, 5.0]; 2], 200, |_, _| ()).unwrap();
        assert!((free.point[0] - 1.0).abs() < 1e-4 && free.value < 1e-8, "{free:?}");
        assert!(free.evaluations < 80, "{}", free.evaluations);
        let bound = minimise(rosenbrock, &[-1.2, 1.0], &[[-5.0, 0.5], [-5.0, 5.0]], 200, |_, _| ())
            .unwrap();
        assert!((bound.point[0] - 0.5).abs() < 1e-12);
        assert!((bound.point[1] - 0.25).abs() < 1e-5, "{bound:?}");
    }

    #[test]
    fn steps_into_nothing_are_taken_back() {
        let log_barrier =
            |x: &[f64]| (x[0] > 0.0).then(|| (x[0] - x[0].ln(), vec![1.0 - 1.0 / x[0]]));
        let found = minimise(log_barrier, &[1e-3], &[[-10.0, 10.0]], 100, |_, _| ()).unwrap();
        assert!((found.point[0] - 1.0).abs() < 1e-4);
        assert!(minimise(log_barrier, &[-1.0], &[[-10.0, 10.0]], 100, |_, _| ()).is_none());
    }
}
