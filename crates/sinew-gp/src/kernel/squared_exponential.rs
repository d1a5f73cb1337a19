//! The squared-exponential kernel, in Hermite polynomials.

use super::{Hyperparameter, Kernel, MOST_PAIRS, Measure, Orders, Request};
use crate::series::{MOST_VARIABLES, Series};
use crate::simd::{exp_of_negative, lane_sum};
use sinew_num::vectorised;
use std::cell::RefCell;

/// exp(−½ Σ (xᵢ − xᵢ′)² / λᵢ²) with a lengthscale per axis (4.46); infinitely smooth.
#[doc(alias("RBF", "Gaussian kernel"))]
#[derive(Clone, Debug, Default)]
pub struct SquaredExponential {
    /// `None` for all there are.
    axes: Option<Vec<usize>>,
}

impl SquaredExponential {
    /// All axes.
    pub fn new() -> Self {
        Self::default()
    }

    /// The axes with these numbers only.
    pub fn along(axes: &[usize]) -> Self {
        Self { axes: Some(axes.to_vec()) }
    }

    /// Axes among the first `D`.
    fn of<const D: usize>(&self) -> &[usize] {
        const ALL: [usize; MOST_VARIABLES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10];
        self.axes.as_deref().unwrap_or(&ALL[..D])
    }
}

/// Highest order of a derivative in x − x′, and of one more for gradients: those of two axes come
/// together along the edge of a polygon.
const MOST_ORDERS: usize = 4 * crate::operator::MOST_DERIVATIVES + 2;

impl<const D: usize> Kernel<D> for SquaredExponential {
    fn name(&self) -> String {
        "squared-exponential".into()
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        let length = |axis: &usize| Measure::Length { axis: *axis };
        let each = self.of::<D>().iter().map(length);
        each.map(|measure| Hyperparameter { name: "lengthscale", measure }).collect()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        let kept = self.of::<D>().iter().copied().filter(|d| axes.contains(d)).collect();
        Box::new(Self { axes: Some(kept) })
    }

    fn formula(&self, lengthscales: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let square = |(d, length): (&usize, &Series)| ((&x[*d] - &y[*d]) / length).squared();
        let squares = self.of::<D>().iter().zip(lengthscales).map(square);
        (squares.fold(x[0].constant(0.0), |sum, square| sum + square) * -0.5).exp()
    }

    fn is_stationary(&self) -> bool {
        true
    }

    fn as_squared_exponential(&self) -> Option<&SquaredExponential> {
        Some(self)
    }
}

/// Whether a derivative is taken along an axis that the kernel does not depend on.
fn beyond<const D: usize>(orders: [usize; D], axes: &[usize]) -> bool {
    (0..D).any(|d| orders[d] > 0 && !axes.contains(&d))
}

impl SquaredExponential {
    /// See [`super::derivatives`].
    pub(super) fn derivatives<const D: usize>(&self, request: &Request<'_, D>, table: &mut [f64]) {
        let axes = self.of::<D>();
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.fill(axes, request, 0);
            scratch.tabulate(axes, request, table);
        });
    }

    /// See [`super::derivatives_and_pull_back`]: the exponentials and polynomials serve both directions.
    pub(super) fn derivatives_and_pull_back<const D: usize>(
        &self,
        request: &Request<'_, D>,
        [table, weights]: [&mut [f64]; 2],
        weigh: &mut dyn FnMut(&[f64], &mut [f64]),
        gradient: &mut [f64],
    ) {
        let axes = self.of::<D>();
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.fill(axes, request, 1);
            scratch.tabulate(axes, request, table);
            weigh(table, weights);
            scratch.pull_back(axes, request, weights, gradient);
        });
    }
}

/// The polynomials hₙ with ∂ⁿ exp(−r²/2λ²) = hₙ exp(−r²/2λ²) along one axis.
struct Hermite {
    differences: [f64; MOST_PAIRS],
    rows: [[f64; MOST_PAIRS]; MOST_ORDERS],
}

/// Polynomials of all axes and the exponential of them together, kept from call to call.
struct Scratch {
    exponential: [f64; MOST_PAIRS],
    axes: Vec<Hermite>,
}

/// Numbers in the widest vector; divides [`MOST_PAIRS`].
const LANES: usize = 8;

thread_local! {
    static SCRATCH: RefCell<Scratch> = const {
        RefCell::new(Scratch { exponential: [0.0; MOST_PAIRS], axes: Vec::new() })
    };
}

impl Scratch {
    fn tabulate<const D: usize>(
        &self,
        axes: &[usize],
        request: &Request<'_, D>,
        table: &mut [f64],
    ) {
        let count = request.count();
        for (order, row) in request.orders.iter().zip(table.chunks_mut(count)) {
            if beyond(order.first, axes) {
                row.fill(0.0);
                continue;
            }
            row.copy_from_slice(&self.exponential[..count]);
            self.differentiated(order, axes, None).for_each(|rows| multiply(row, rows));
        }
    }

    /// Polynomials of the axes along which derivatives are taken, but for that of one axis.
    fn differentiated<const D: usize>(
        &self,
        order: &Orders<D>,
        axes: &[usize],
        skipped: Option<usize>,
    ) -> impl Iterator<Item = &[f64; MOST_PAIRS]> {
        let numbered = self.axes.iter().zip(axes).enumerate();
        numbered
            .map(move |(number, (axis, d))| (number, axis, order.first[*d]))
            .filter(move |(number, _, n)| *n > 0 && skipped != Some(*number))
            .map(|(_, axis, n)| &axis.rows[n])
    }

    /// λ ∂/∂λ of the γ-th derivative G_γ is −(r G_{γ+1} + γ G_γ), r the difference along the axis.
    fn pull_back<const D: usize>(
        &self,
        axes: &[usize],
        request: &Request<'_, D>,
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        let count = request.count();
        let weighed = request.orders.iter().zip(weights.chunks(count));
        for (order, weights) in weighed.filter(|(order, _)| !beyond(order.first, axes)) {
            for (number, (d, slope)) in axes.iter().zip(gradient.iter_mut()).enumerate() {
                let mut scaled = [0.0; MOST_PAIRS];
                scaled[..count].copy_from_slice(weights);
                let others = self.differentiated(order, axes, Some(number));
                others.for_each(|other| multiply(&mut scaled[..count], other));
                let (axis, n) = (&self.axes[number], order.first[*d]);
                let [at, after] = [&axis.rows[n], &axis.rows[n + 1]];
                let weights = &scaled[..count];
                dilation(slope, n as f64, weights, &self.exponential, &axis.differences, at, after);
            }
        }
    }

    fn fill<const D: usize>(&mut self, axes: &[usize], request: &Request<'_, D>, extra: usize) {
        let count = request.count();
        while self.axes.len() < axes.len() {
            // h₀ = 1 is never written again.
            let rows = [[1.0; MOST_PAIRS]; MOST_ORDERS];
            self.axes.push(Hermite { differences: [0.0; MOST_PAIRS], rows });
        }
        // Whole vectors: what the lanes beyond the last pair hold is finite and never read.
        let padded = count.next_multiple_of(LANES);
        self.exponential[..padded].fill(0.0);
        for ((d, lengthscale), axis) in axes.iter().zip(request.hyperparameters).zip(&mut self.axes)
        {
            let most = request.orders.iter().map(|o| o.first[*d]).max().unwrap_or(0) + extra;
            recurrence(
                *lengthscale,
                request.first[*d],
                request.second[*d],
                &mut axis.differences[..padded],
                &mut self.exponential[..padded],
                &mut axis.rows[..=most],
            );
        }
        exponentials(&mut self.exponential[..padded]);
    }
}

vectorised! {
    /// Differences, their squares' sum in `squares`, and hₙ₊₁ = −(r/λ² hₙ + n/λ² hₙ₋₁).
    fn recurrence(
        lengthscale: f64,
        first: &[f64],
        second: f64,
        differences: &mut [f64],
        squares: &mut [f64],
        rows: &mut [[f64; MOST_PAIRS]],
    ) {
        let inverse = lengthscale.recip();
        for (difference, x) in differences.iter_mut().zip(first) {
            *difference = x - second;
        }
        for (r, square) in differences.iter().zip(squares.iter_mut()) {
            *square += (r * inverse) * (r * inverse);
        }
        let slope = inverse * inverse;
        if rows.len() > 1 {
            for (h, r) in rows[1].iter_mut().zip(differences.iter()) {
                *h = -r * slope;
            }
        }
        for n in 1..rows.len().saturating_sub(1) {
            let [before, at, after] = &mut rows[n - 1..n + 2] else { unreachable!("three rows") };
            let factor = n as f64 * slope;
            for (((after, at), before), r) in
                after.iter_mut().zip(at.iter()).zip(before.iter()).zip(differences.iter())
            {
                *after = -(r * slope * at + factor * before);
            }
        }
    }
}

vectorised! {
    fn exponentials(squares: &mut [f64]) {
        for s in squares {
            *s = exp_of_negative(-0.5 * *s);
        }
    }
}

vectorised! {
    fn multiply(product: &mut [f64], factor: &[f64]) {
        for (p, f) in product.iter_mut().zip(factor) {
            *p *= f;
        }
    }
}

vectorised! {
    /// Adds −Σ weight · product · (r hₙ₊₁ + n hₙ) to `slope`.
    fn dilation(
        slope: &mut f64,
        n: f64,
        weights: &[f64],
        product: &[f64; MOST_PAIRS],
        differences: &[f64],
        at: &[f64; MOST_PAIRS],
        after: &[f64; MOST_PAIRS],
    ) {
        *slope -= lane_sum(weights.len(), |lane| {
            weights[lane] * product[lane] * (differences[lane] * after[lane] + n * at[lane])
        });
    }
}
