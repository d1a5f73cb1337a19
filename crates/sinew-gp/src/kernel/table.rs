//! Tables of derivatives of kernels: of the squared exponential in Hermite polynomials, of any formula by Taylor series in the
//! coordinates of a pair.

use super::{MOST_PAIRS, Request};
use crate::{MOST_DERIVATIVES, Series};
use sinew_num::vectorised;

impl<const D: usize> Request<'_, D> {
    /// Derivatives of k for each pair: entry `e` of the request's orders fills `table[e · count ..]`. With `further` of 1 the memory
    /// keeps what [`Request::pull_back`] takes; else it is 0.
    pub(crate) fn derivatives(&self, table: &mut [f64], memory: &mut Hermites, further: usize) {
        if !self.kernel.closed {
            return self.expand(None, |entry, value| table[entry] = value);
        }
        let (axes, count) = (&self.kernel.axes, self.count());
        while memory.axes.len() < axes.len() {
            // h₀ = 1 is never written again.
            let rows = [[1.0; MOST_PAIRS]; MOST_ORDERS];
            memory.axes.push(Hermite { differences: [0.0; MOST_PAIRS], rows });
        }
        // Whole vectors: what the lanes beyond the last pair hold is finite and never read.
        let padded = count.next_multiple_of(LANES);
        memory.exponential.clear();
        memory.exponential.resize(padded, 0.0);
        let scales = axes.iter().zip(self.hyperparameters);
        for ((d, lengthscale), axis) in scales.zip(&mut memory.axes) {
            recurrence(
                *lengthscale,
                self.first[*d],
                self.second[*d],
                &mut axis.differences[..padded],
                &mut memory.exponential,
                &mut axis.rows[..=self.most(*d) + further],
            );
        }
        exponentials(&mut memory.exponential);
        for (order, row) in self.orders.iter().zip(table.chunks_mut(count)) {
            row.copy_from_slice(&memory.exponential[..count]);
            for (axis, d) in memory.axes.iter().zip(axes).filter(|(_, d)| order[0][**d] > 0) {
                multiply(row, &axis.rows[order[0][*d]]);
            }
        }
    }

    /// Adds to `gradient` the derivatives of Σ weight · table in the logarithm of each hyperparameter, after
    /// [`Request::derivatives`] of the same request.
    pub(crate) fn pull_back(&self, weights: &[f64], memory: &Hermites, gradient: &mut [f64]) {
        if self.kernel.closed {
            return self.pull_back_closed(weights, memory, gradient);
        }
        for (number, slope) in gradient.iter_mut().enumerate() {
            let value = self.hyperparameters[number];
            self.expand(Some(number), |entry, d| *slope += weights[entry] * d * value);
        }
    }

    /// λ ∂/∂λ of the γ-th derivative G_γ is −(r G_{γ+1} + γ G_γ), r the difference along the axis:
    /// for each axis, weights times the other axes' polynomials are gathered by the order along it.
    fn pull_back_closed(&self, weights: &[f64], memory: &Hermites, gradient: &mut [f64]) {
        let count = self.count();
        let axes = || memory.axes.iter().zip(&self.kernel.axes);
        for (number, ((axis, d), slope)) in axes().zip(gradient).enumerate() {
            for n in 0..=self.most(*d) {
                let mut sum = [0.0; MOST_PAIRS];
                for (order, weights) in self.orders.iter().zip(weights.chunks(count)) {
                    if order[0][*d] != n {
                        continue;
                    }
                    let mut others = [1.0; MOST_PAIRS];
                    for (k, (other, e)) in axes().enumerate() {
                        if k != number && order[0][*e] > 0 {
                            multiply(&mut others[..count], &other.rows[order[0][*e]]);
                        }
                    }
                    add_product(&mut sum[..count], &others, weights);
                }
                dilation(slope, n, &sum[..count], &memory.exponential, axis);
            }
        }
    }

    /// Derivatives of k for each entry of the table, from a series in the 2 D coordinates of each pair; in the hyperparameter
    /// `varied` the first one, too.
    fn expand(&self, varied: Option<usize>, mut visit: impl FnMut(usize, f64)) {
        let further: &[usize] = if varied.is_some() { &[1] } else { &[] };
        let orders: Vec<_> = self.orders.iter().map(|[x, y]| [x, y, further].concat()).collect();
        let most = |d: usize| orders.iter().map(|order| order[d]).max().unwrap_or_default();
        let degrees: Vec<usize> = (0..2 * D + further.len()).map(most).collect();
        let variable = |value, number| Series::variable(value, number, &degrees);
        let count = self.count();
        for lane in 0..count {
            let x: [Series; D] = std::array::from_fn(|d| variable(self.first[d][lane], d));
            let y = std::array::from_fn(|d| variable(self.second[d], D + d));
            let of = |(number, value): (usize, &f64)| match varied == Some(number) {
                true => variable(*value, 2 * D),
                false => Series::number(*value),
            };
            let known: Vec<Series> = self.hyperparameters.iter().enumerate().map(of).collect();
            let value = self.kernel.formula(&known, &x, &y) + x[0].constant(0.0);
            for (entry, order) in orders.iter().enumerate() {
                visit(entry * count + lane, value.derivative(order));
            }
        }
    }
}

/// Orders of derivatives in x − x′, with one more for gradients.
const MOST_ORDERS: usize = 2 * MOST_DERIVATIVES + 2;

/// Numbers of the pairs of a request.
type Pairs = [f64; MOST_PAIRS];

/// The polynomials hₙ with ∂ⁿ exp(−r²/2λ²) = hₙ exp(−r²/2λ²) along one axis.
struct Hermite {
    differences: Pairs,
    rows: [Pairs; MOST_ORDERS],
}

/// Polynomials of all axes and the exponential of them together, in memory that is kept from request to request.
#[derive(Default)]
pub(crate) struct Hermites {
    exponential: Vec<f64>,
    axes: Vec<Hermite>,
}

/// Numbers in the widest vector; divides [`MOST_PAIRS`].
const LANES: usize = 8;

vectorised! {
    /// Differences, their squares' sum in `squares`, and hₙ₊₁ = −(r/λ² hₙ + n/λ² hₙ₋₁).
    fn recurrence(
        lengthscale: f64,
        first: &[f64],
        second: f64,
        differences: &mut [f64],
        squares: &mut [f64],
        rows: &mut [Pairs],
    ) {
        let inverse = lengthscale.recip();
        for (difference, x) in differences.iter_mut().zip(first) {
            *difference = x - second;
        }
        for (r, square) in differences.iter().zip(squares.iter_mut()) {
            *square += (r * inverse) * (r * inverse);
        }
        let slope = inverse * inverse;
        for n in 1..rows.len() {
            let (lower, upper) = rows.split_at_mut(n);
            let (at, before) = (&lower[n - 1], &lower[n.saturating_sub(2)]);
            let factor = (n - 1) as f64 * slope;
            for (((after, at), before), r) in
                upper[0].iter_mut().zip(at).zip(before).zip(differences.iter())
            {
                *after = -(r * slope * at + factor * before);
            }
        }
    }

    fn exponentials(squares: &mut [f64]) {
        for s in squares {
            *s = exp_of_negative(-0.5 * *s);
        }
    }

    fn add_product(sum: &mut [f64], a: &[f64], b: &[f64]) {
        for ((s, a), b) in sum.iter_mut().zip(a).zip(b) {
            *s += a * b;
        }
    }

    fn multiply(product: &mut [f64], factor: &[f64]) {
        for (p, f) in product.iter_mut().zip(factor) {
            *p *= f;
        }
    }

    /// Adds −Σ weight · product · (r hₙ₊₁ + n hₙ) to `slope`.
    fn dilation(slope: &mut f64, n: usize, weights: &[f64], product: &[f64], axis: &Hermite) {
        let [at, after] = [&axis.rows[n], &axis.rows[n + 1]];
        *slope -= lane_sum(weights.len(), |lane| {
            let turned = axis.differences[lane] * after[lane] + n as f64 * at[lane];
            weights[lane] * product[lane] * turned
        });
    }
}

/// exp(x) for x ≤ 0 without branches, so that loops over it use vector instructions; within two
/// units in the last place, and 0 below −708.
#[inline(always)]
pub(crate) fn exp_of_negative(x: f64) -> f64 {
    const LOG2_E: f64 = std::f64::consts::LOG2_E;
    // ln 2 in two parts, the first with trailing zeros so that its multiples are exact.
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    // Adding it rounds to a whole number, left in the low bits.
    const SHIFTER: f64 = 6_755_399_441_055_744.0;
    // Coefficients 1/k! of the exponential: the remainder on |r| ≤ ln(2)/2 is below 1e-17.
    const TAYLOR: [f64; 14] = {
        let (mut taylor, mut factorial, mut k) = ([1.0; 14], 1.0, 1);
        while k < 14 {
            factorial *= k as f64;
            taylor[k] = 1.0 / factorial;
            k += 1;
        }
        taylor
    };
    let clamped = if x < -708.0 { -708.0 } else { x };
    let shifted = clamped * LOG2_E + SHIFTER;
    let whole = shifted - SHIFTER;
    let r = (clamped - whole * LN2_HIGH) - whole * LN2_LOW;
    let mut sum = TAYLOR[13];
    for coefficient in TAYLOR[..13].iter().rev() {
        sum = sum * r + coefficient;
    }
    let exponent = shifted.to_bits().wrapping_sub(SHIFTER.to_bits());
    let power = f64::from_bits(exponent.wrapping_add(1023) << 52);
    if x < -708.0 { 0.0 } else { sum * power }
}

/// Σ term over lanes in eight partial sums: what vector instructions add at once.
#[inline(always)]
pub(crate) fn lane_sum(count: usize, term: impl Fn(usize) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let whole = count / 8 * 8;
    for start in (0..whole).step_by(8) {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += term(start + k);
        }
    }
    (whole..count).for_each(|lane| sums[0] += term(lane));
    sums.iter().sum()
}
