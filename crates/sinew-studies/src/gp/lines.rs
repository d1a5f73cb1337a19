//! The rival of a fit where a solver can be written: finite differences along x, the trapezoidal rule in time (Crank & Nicolson;
//! Newmark for waves), and least squares for the parameters.

use crate::gp::problems::Function;
use std::f64::consts::PI;
use std::sync::Arc;

/// Intervals along x, and steps in time.
const CELLS: usize = 100;
const STEPS: usize = 200;

/// Values over time at both ends.
type Held = [Option<fn(f64) -> f64>; 2];

/// u_t, or u_tt where a rate is given, = d u_xx − a u_x on an interval, from the start of a unit of time.
struct Lines {
    ends: [f64; 2],
    /// Values held at the ends over time; no flux where there are none.
    held: Held,
    start: fn(f64) -> f64,
    rate: Option<fn(f64) -> f64>,
}

/// A tridiagonal matrix by rows: below, on and above the diagonal.
type Rows = Vec<[f64; 3]>;

fn times(matrix: &Rows, u: &[f64]) -> Vec<f64> {
    let at = |k: usize| {
        let [below, own, above] = matrix[k];
        let before = if k > 0 { below * u[k - 1] } else { 0.0 };
        before + own * u[k] + if k + 1 < u.len() { above * u[k + 1] } else { 0.0 }
    };
    (0..u.len()).map(at).collect()
}

/// Solution of a tridiagonal system by elimination.
fn solved(matrix: &Rows, mut right: Vec<f64>) -> Vec<f64> {
    let mut pivots = matrix.clone();
    for k in 1..right.len() {
        let factor = pivots[k][0] / pivots[k - 1][1];
        pivots[k][1] -= factor * pivots[k - 1][2];
        right[k] -= factor * right[k - 1];
    }
    for k in (0..right.len()).rev() {
        let above = if k + 1 < right.len() { pivots[k][2] * right[k + 1] } else { 0.0 };
        right[k] = (right[k] - above) / pivots[k][1];
    }
    right
}

impl Lines {
    fn solve(&self, [a, d]: [f64; 2]) -> Function<2> {
        let [lower, upper] = self.ends;
        let (h, dt) = ((upper - lower) / CELLS as f64, 1.0 / STEPS as f64);
        let mut matrix: Rows =
            vec![[d / h / h + a / 2.0 / h, -2.0 * d / h / h, d / h / h - a / 2.0 / h]; CELLS + 1];
        // Mirror images beyond sealed ends; fixed ones do not move.
        (matrix[0][2], matrix[CELLS][0]) = (2.0 * d / h / h, 2.0 * d / h / h);
        for (row, held) in [0, CELLS].into_iter().zip(self.held) {
            if held.is_some() {
                matrix[row] = [0.0; 3];
            }
        }
        let part = if self.rate.is_some() { dt * dt / 4.0 } else { dt / 2.0 };
        let implicit: Rows =
            matrix.iter().map(|[l, m, u]| [-part * l, 1.0 - part * m, -part * u]).collect();
        let x = |k: usize| lower + h * k as f64;
        let of = |f: fn(f64) -> f64| (0..=CELLS).map(|k| f(x(k))).collect::<Vec<f64>>();
        let hold = |mut u: Vec<f64>, t: f64| {
            for (row, held) in [0, CELLS].into_iter().zip(self.held) {
                u[row] = held.map_or(u[row], |held| held(t));
            }
            u
        };
        let mut levels = vec![of(self.start)];
        if let Some(rate) = self.rate {
            let (u, v, bend) = (&levels[0], of(rate), times(&matrix, &levels[0]));
            let first = (0..=CELLS).map(|k| u[k] + dt * v[k] + dt * dt / 2.0 * bend[k]).collect();
            levels.push(hold(first, dt));
        }
        while levels.len() <= STEPS {
            let (now, t) = (&levels[levels.len() - 1], dt * levels.len() as f64);
            let moved = times(&matrix, now);
            let right = match self.rate {
                None => (0..=CELLS).map(|k| now[k] + part * moved[k]).collect(),
                Some(_) => {
                    let old = times(&implicit, &levels[levels.len() - 2]);
                    (0..=CELLS).map(|k| 2.0 * (now[k] + part * moved[k]) - old[k]).collect()
                }
            };
            levels.push(solved(&implicit, hold(right, t)));
        }
        Arc::new(move |[x, t]| {
            let (rows, along) = (nodes(t / dt, STEPS), nodes((x - lower) / h, CELLS));
            let row =
                |n: usize| along.iter().map(|(k, weight)| weight * levels[n][*k]).sum::<f64>();
            rows.iter().map(|(n, weight)| weight * row(*n)).sum()
        })
    }
}

/// The four nodes about a place in units of their distance, with weights of cubic interpolation (Lagrange).
fn nodes(place: f64, last: usize) -> [(usize, f64); 4] {
    let first = (place.floor() as isize - 1).clamp(0, last as isize - 3) as usize;
    std::array::from_fn(|k| {
        let others = (0..4).filter(|other| *other != k);
        let weight = others.map(|n| (place - (first + n) as f64) / (k as f64 - n as f64)).product();
        (first + k, weight)
    })
}

const ZERO: fn(f64) -> f64 = |_| 0.0;

/// Heat-BVP-1.
pub(crate) fn heat_1(theta: &[f64]) -> Function<2> {
    let ends = [-PI / 2.0, PI / 2.0];
    let held: Held = [Some(|t| -(-t).exp()), Some(|t| (-t).exp())];
    Lines { ends, held, start: f64::sin, rate: None }.solve([0.0, theta[0]])
}

/// Heat with an initial layer.
pub(crate) fn layer(theta: &[f64]) -> Function<2> {
    let start = |x: f64| (x * PI / 2.0).sin() + 0.5 * (2.5 * PI * x).sin();
    Lines { ends: [0.0, 1.0], held: [Some(ZERO), None], start, rate: None }.solve([0.0, theta[0]])
}

/// Wave-BVP-1.
pub(crate) fn wave_1(theta: &[f64]) -> Function<2> {
    let rate = Some((|x: f64| x.cos().powi(2)) as fn(f64) -> f64);
    let speed = theta[0];
    Lines { ends: [0.0, PI], held: [None; 2], start: f64::cos, rate }.solve([0.0, speed * speed])
}

/// Advection and diffusion.
pub(crate) fn advection_diffusion(theta: &[f64]) -> Function<2> {
    let start = |x: f64| (2.0 * PI * x).sin() * x.exp();
    let lines = Lines { ends: [0.0, 1.0], held: [Some(ZERO); 2], start, rate: None };
    lines.solve([theta[0], theta[1]])
}
