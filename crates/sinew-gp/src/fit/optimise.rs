//! Maximisation within a box by a limited-memory quasi-Newton method, which minimises the negative objective.

use crate::Evaluation;
use nalgebra::DVector;
use std::collections::VecDeque;

/// End of a maximisation.
pub(crate) struct Maximum {
    pub point: Vec<f64>,
    /// Every accepted point.
    pub path: Vec<Vec<f64>>,
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

/// A point with value and gradient of the negative objective.
struct Visited {
    x: DVector<f64>,
    value: f64,
    gradient: DVector<f64>,
}

struct Search<F> {
    objective: F,
    bounds: Vec<[f64; 2]>,
    evaluations: usize,
    memory: VecDeque<(DVector<f64>, DVector<f64>)>,
}

impl<F: FnMut(&[f64]) -> Option<Evaluation>> Search<F> {
    fn evaluate(&mut self, x: DVector<f64>) -> Option<Visited> {
        self.evaluations += 1;
        let Evaluation { value, gradient, .. } = (self.objective)(x.as_slice())?;
        let finite = value.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then(|| Visited { x, value: -value, gradient: -DVector::from(gradient) })
    }

    /// Sets components of `v` to zero along which the gradient points out of the box at its boundary.
    fn held(&self, at: &Visited, mut v: DVector<f64>) -> DVector<f64> {
        let each = at.x.iter().zip(&at.gradient).zip(&self.bounds);
        for (v, ((x, g), [lower, upper])) in v.iter_mut().zip(each) {
            if *x <= *lower && *g > 0.0 || *x >= *upper && *g < 0.0 {
                *v = 0.0;
            }
        }
        v
    }

    fn moved(&self, x: &DVector<f64>, direction: &DVector<f64>, step: f64) -> DVector<f64> {
        let mut moved = x + direction * step;
        let ends = moved.iter_mut().zip(&self.bounds);
        ends.for_each(|(x, [lower, upper])| *x = x.clamp(*lower, *upper));
        moved
    }

    /// The two-loop recursion on the free variables.
    fn direction(&self, at: &Visited) -> DVector<f64> {
        let steepest = self.held(at, -&at.gradient);
        let mut q = steepest.clone();
        let mut alphas = Vec::new();
        for (s, y) in self.memory.iter().rev() {
            let alpha = s.dot(&q) / s.dot(y);
            q.axpy(-alpha, y, 1.0);
            alphas.push(alpha);
        }
        q *= match self.memory.back() {
            Some((s, y)) => s.dot(y) / y.dot(y),
            // A first step of at most one tenth: parameters are logarithms.
            None => 0.1 / steepest.amax().max(1.0),
        };
        for ((s, y), alpha) in self.memory.iter().zip(alphas.iter().rev()) {
            let beta = y.dot(&q) / s.dot(y);
            q.axpy(alpha - beta, s, 1.0);
        }
        let q = self.held(at, q);
        if q.dot(&steepest) > 0.0 { q } else { steepest }
    }

    /// A step with sufficient decrease, and if possible sufficient curvature.
    fn line_search(&mut self, from: &Visited, direction: &DVector<f64>) -> Option<Visited> {
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut step = 1.0;
        let mut best = None;
        let slope = from.gradient.dot(direction);
        for _ in 0..LINE_SEARCH_STEPS {
            let candidate = self.moved(&from.x, direction, step);
            let displacement = &candidate - &from.x;
            let expected = from.gradient.dot(&displacement);
            match self.evaluate(candidate) {
                Some(found) if found.value <= from.value + ARMIJO * expected => {
                    let curved = found.gradient.dot(direction) >= WOLFE * slope;
                    best = Some(found);
                    if curved || displacement != direction * step {
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

/// A local maximum of `objective` within `bounds`, from `start`; `None` if it has no value there.
pub(crate) fn maximise(
    objective: impl FnMut(&[f64]) -> Option<Evaluation>,
    start: &[f64],
    bounds: &[[f64; 2]],
    most_iterations: usize,
) -> Option<Maximum> {
    let mut search =
        Search { objective, bounds: bounds.to_vec(), evaluations: 0, memory: VecDeque::new() };
    let start = DVector::from_column_slice(start);
    let start = search.moved(&start, &start, 0.0);
    let mut at = search.evaluate(start)?;
    let mut path = vec![at.x.as_slice().to_vec()];
    let mut idle = 0;
    for _ in 0..most_iterations {
        if search.held(&at, at.gradient.clone()).amax() < GRADIENT_TOLERANCE {
            break;
        }
        let direction = search.direction(&at);
        let Some(next) = search.line_search(&at, &direction) else {
            if search.memory.is_empty() {
                break;
            }
            // The memory misled; once more from the gradient alone.
            search.memory.clear();
            continue;
        };
        let s = &next.x - &at.x;
        // Slopes across bounds say nothing of the curvature between them.
        let y = (&next.gradient - &at.gradient).zip_map(&s, |y, s| if s == 0.0 { 0.0 } else { y });
        if s.dot(&y) > 1e-12 * y.dot(&y) {
            search.memory.push_back((s, y));
            if search.memory.len() > MEMORY {
                search.memory.pop_front();
            }
        }
        let decrease = (at.value - next.value) / at.value.abs().max(next.value.abs()).max(1.0);
        at = next;
        path.push(at.x.as_slice().to_vec());
        idle = if decrease < DECREASE_TOLERANCE { idle + 1 } else { 0 };
        if idle == 2 {
            break;
        }
    }
    let (point, value) = (at.x.as_slice().to_vec(), -at.value);
    Some(Maximum { point, path, value, evaluations: search.evaluations })
}
