//! Kernels g(s) of s = ½ Σ (xᵢ − xᵢ′)² / λᵢ²: derivatives of any order from those of g.

use super::axes::Axes;
use super::{Hyperparameter, Kernel, Measure, Orders, Request};
use crate::series::Series;
use std::fmt::Debug;

/// Highest order of a derivative in x − x′ over all axes together, and one more for gradients.
const MOST_TOTAL: usize = 26;

/// A function g of s, at its own hyperparameters if it has any: those behind the lengthscales.
pub trait Profile: Clone + Debug + Send + Sync + 'static {
    /// Name of the kernel.
    fn name(&self) -> String;

    /// Derivatives of the kernel's functions; none for all.
    fn smoothness(&self) -> Option<usize>;

    /// Its own hyperparameters, one at most.
    fn own(&self) -> Vec<Hyperparameter>;

    /// g over Taylor series.
    fn formula(&self, s: Series, own: &[Series]) -> Series;

    /// Fills `slopes` with g, g′, g″ … at s. Where a derivative at s = 0 does not exist it is 0.
    fn slopes(&self, s: f64, own: &[f64], slopes: &mut [f64]);

    /// Derivatives of the derivative of g in the logarithm of its own hyperparameter.
    fn slopes_by_own(&self, _: f64, _: &[f64], _: &mut [f64]) {}
}

/// A kernel of a scaled distance, with a lengthscale per axis.
#[derive(Clone, Debug, Default)]
pub struct Radial<P> {
    pub(super) axes: Axes,
    pub(super) profile: P,
}

/// One length for each axis.
pub(super) fn lengths(name: &'static str, axes: &[usize]) -> Vec<Hyperparameter> {
    let length = |axis: &usize| Hyperparameter { name, measure: Measure::Length { axis: *axis } };
    axes.iter().map(length).collect()
}

/// ½ Σ (xᵢ − yᵢ)² / λᵢ².
pub(super) fn half_square<const D: usize>(
    axes: &[usize],
    lengthscales: &[Series],
    x: &[Series; D],
    y: &[Series; D],
) -> Series {
    axes.iter().zip(lengthscales).fold(x[0].constant(0.0), |sum, (d, lengthscale)| {
        sum + ((&x[*d] - &y[*d]) / lengthscale).squared() * 0.5
    })
}

/// Whether a derivative is taken along an axis that the kernel does not depend on.
pub(super) fn beyond<const D: usize>(orders: [usize; D], axes: &[usize]) -> bool {
    (0..D).any(|d| orders[d] > 0 && !axes.contains(&d))
}

/// Number of ways to pick `pairs` disjoint pairs out of `n`: n! / (pairs! (n − 2 pairs)! 2^pairs).
fn pairings(n: usize, pairs: usize) -> f64 {
    (0..pairs).map(|j| ((n - 2 * j) * (n - 2 * j - 1)) as f64 / (2.0 * (j + 1) as f64)).product()
}

/// ∂^γ g(s) for one pair, u the differences over lengthscales of the axes in use and `slopes` the
/// derivatives g⁽ᵐ⁾(s), from that of order `order` on:
/// Π λ^(−γ) Σ_j Π c(γ, j) u^(γ−2j) g^(|γ|−|j|), the formula of Faà di Bruno for a quadratic s.
fn derivative(orders: &[usize], u: &[f64], order: usize, slopes: &[f64]) -> f64 {
    let Some((n, rest)) = orders.split_first() else { return slopes[order] };
    (0..=n / 2)
        .map(|j| {
            let inner = derivative(rest, &u[1..], order + n - j, slopes);
            // A profile too rough for this many derivatives at s = 0 has none where u is 0.
            let power = u[0].powi((n - 2 * j) as i32);
            if power == 0.0 { 0.0 } else { pairings(*n, j) * power * inner }
        })
        .sum()
}

/// One pair: its differences, over lengthscales.
struct Pair<'a> {
    axes: &'a [usize],
    lengthscales: &'a [f64],
    u: Vec<f64>,
}

impl<'a> Pair<'a> {
    fn new<const D: usize>(axes: &'a [usize], request: &Request<'a, D>, lane: usize) -> Self {
        let lengthscales = &request.hyperparameters[..axes.len()];
        let over_length = |(d, lengthscale): (&usize, &f64)| {
            (request.first[*d][lane] - request.second[*d]) / lengthscale
        };
        let u = axes.iter().zip(lengthscales).map(over_length).collect();
        Self { axes, lengthscales, u }
    }

    fn half_square(&self) -> f64 {
        0.5 * self.u.iter().map(|u| u * u).sum::<f64>()
    }

    fn derivative<const D: usize>(&self, slopes: &[f64], orders: [usize; D]) -> f64 {
        if beyond(orders, self.axes) {
            return 0.0;
        }
        let mut picked = [0; D];
        let mut scale = 1.0;
        for (axis, d) in self.axes.iter().enumerate() {
            picked[axis] = orders[*d];
            scale *= self.lengthscales[axis].powi(orders[*d] as i32);
        }
        derivative(&picked[..self.axes.len()], &self.u, 0, slopes) / scale
    }
}

/// One more derivative of g than the table takes, for the gradient in the lengthscales.
fn most<const D: usize>(orders: &[Orders<D>]) -> usize {
    orders.iter().map(|o| o.first.iter().sum::<usize>()).max().unwrap_or(0) + 2
}

impl<const D: usize, P: Profile> Kernel<D> for Radial<P> {
    fn name(&self) -> String {
        self.profile.name()
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        [lengths("lengthscale", self.axes.of::<D>()), self.profile.own()].concat()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { axes: self.axes.among::<D>(axes), ..self.clone() })
    }

    fn formula(&self, hyperparameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let axes = self.axes.of::<D>();
        let s = half_square(axes, hyperparameters, x, y);
        self.profile.formula(s, &hyperparameters[axes.len()..])
    }

    fn smoothness(&self) -> Option<usize> {
        self.profile.smoothness()
    }

    fn is_stationary(&self) -> bool {
        true
    }

    fn derivatives(&self, request: &Request<'_, D>, table: &mut [f64]) {
        let axes = self.axes.of::<D>();
        let (count, most) = (request.count(), most(request.orders));
        let mut slopes = [0.0; MOST_TOTAL];
        for lane in 0..count {
            let pair = Pair::new(axes, request, lane);
            let own = &request.hyperparameters[axes.len()..];
            self.profile.slopes(pair.half_square(), own, &mut slopes[..most]);
            for (entry, order) in request.orders.iter().enumerate() {
                table[entry * count + lane] = pair.derivative(&slopes, order.first);
            }
        }
    }

    fn pull_back(&self, request: &Request<'_, D>, weights: &[f64], gradient: &mut [f64]) {
        let axes = self.axes.of::<D>();
        let own = &request.hyperparameters[axes.len()..];
        let (count, most) = (request.count(), most(request.orders));
        let (mut slopes, mut by_own) = ([0.0; MOST_TOTAL], [0.0; MOST_TOTAL]);
        for lane in 0..count {
            let pair = Pair::new(axes, request, lane);
            self.profile.slopes(pair.half_square(), own, &mut slopes[..most]);
            self.profile.slopes_by_own(pair.half_square(), own, &mut by_own[..most]);
            for (entry, order) in request.orders.iter().enumerate() {
                let weight = weights[entry * count + lane];
                let value = pair.derivative(&slopes, order.first);
                for (axis, d) in axes.iter().enumerate() {
                    let mut raised = order.first;
                    raised[*d] += 1;
                    let r = pair.u[axis] * pair.lengthscales[axis];
                    let next = pair.derivative(&slopes, raised);
                    gradient[axis] -= weight * (r * next + order.first[*d] as f64 * value);
                }
                if let Some(slope) = gradient.get_mut(axes.len()) {
                    *slope += weight * pair.derivative(&by_own, order.first);
                }
            }
        }
    }
}
