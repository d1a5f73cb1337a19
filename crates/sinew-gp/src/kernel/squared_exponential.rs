//! The squared-exponential kernel, in Hermite polynomials.

use super::{Hyperparameter, Kernel, MOST_PAIRS, Measure, Orders, Request};
use crate::kernel::simd::{exp_of_negative, lane_sum};
use crate::series::{MOST_VARIABLES, Series};
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

/// Orders of derivatives in x − x′, with one more for gradients.
const MOST_ORDERS: usize = 2 * crate::problem::operator::MOST_DERIVATIVES + 2;

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
    /// See [`Request::derivatives`].
    pub(super) fn derivatives<const D: usize>(&self, request: &Request<'_, D>, table: &mut [f64]) {
        let axes = self.of::<D>();
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.fill(axes, request, 0);
            scratch.tabulate(axes, request, table);
        });
    }

    /// See [`Request::derivatives_and_pull_back`]: the exponentials and polynomials serve both directions.
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

/// Numbers of the pairs of a request.
type Pairs = [f64; MOST_PAIRS];

/// The polynomials hₙ with ∂ⁿ exp(−r²/2λ²) = hₙ exp(−r²/2λ²) along one axis.
struct Hermite {
    differences: Pairs,
    rows: [Pairs; MOST_ORDERS],
}

/// Polynomials of all axes and the exponential of them together, kept from call to call.
struct Scratch {
    exponential: Pairs,
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
            let mut rows = self.differentiated(order, axes, None);
            match rows.next() {
                Some(first) => product(row, &self.exponential, first),
                None => row.copy_from_slice(&self.exponential[..count]),
            }
            rows.for_each(|next| multiply(row, next));
        }
    }

    /// Polynomials of the axes along which derivatives are taken, but for that of one axis.
    fn differentiated<const D: usize>(
        &self,
        order: &Orders<D>,
        axes: &[usize],
        skipped: Option<usize>,
    ) -> impl Iterator<Item = &Pairs> {
        let numbered = self.axes.iter().zip(axes).enumerate();
        numbered
            .map(move |(number, (axis, d))| (number, axis, order.first[*d]))
            .filter(move |(number, _, n)| *n > 0 && skipped != Some(*number))
            .map(|(_, axis, n)| &axis.rows[n])
    }

    /// λ ∂/∂λ of the γ-th derivative G_γ is −(r G_{γ+1} + γ G_γ), r the difference along the axis:
    /// for each axis, weights times the other axes' polynomials are gathered by the order along it.
    fn pull_back<const D: usize>(
        &self,
        axes: &[usize],
        request: &Request<'_, D>,
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        let count = request.count();
        for (number, (d, slope)) in axes.iter().zip(gradient).enumerate() {
            let axis = &self.axes[number];
            for n in 0..=request.most(*d) {
                let mut sum = [0.0; MOST_PAIRS];
                for (order, weights) in request.orders.iter().zip(weights.chunks(count)) {
                    if order.first[*d] != n || beyond(order.first, axes) {
                        continue;
                    }
                    let mut others = self.differentiated(order, axes, Some(number));
                    let Some(first) = others.next() else {
                        add(&mut sum[..count], weights);
                        continue;
                    };
                    let mut scaled = *first;
                    others.for_each(|other| multiply(&mut scaled[..count], other));
                    add_product(&mut sum[..count], &scaled, weights);
                }
                dilation(slope, n, &sum[..count], &self.exponential, axis);
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
            let most = request.most(*d) + extra;
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
}

vectorised! {
    fn exponentials(squares: &mut [f64]) {
        for s in squares {
            *s = exp_of_negative(-0.5 * *s);
        }
    }
}

vectorised! {
    fn product(product: &mut [f64], a: &[f64], b: &[f64]) {
        for ((p, a), b) in product.iter_mut().zip(a).zip(b) {
            *p = a * b;
        }
    }
}

vectorised! {
    fn add(sum: &mut [f64], terms: &[f64]) {
        for (s, t) in sum.iter_mut().zip(terms) {
            *s += t;
        }
    }
}

vectorised! {
    fn add_product(sum: &mut [f64], a: &[f64], b: &[f64]) {
        for ((s, a), b) in sum.iter_mut().zip(a).zip(b) {
            *s += a * b;
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
    fn dilation(slope: &mut f64, n: usize, weights: &[f64], product: &Pairs, axis: &Hermite) {
        let [at, after] = [&axis.rows[n], &axis.rows[n + 1]];
        *slope -= lane_sum(weights.len(), |lane| {
            let turned = axis.differences[lane] * after[lane] + n as f64 * at[lane];
            weights[lane] * product[lane] * turned
        });
    }
}
