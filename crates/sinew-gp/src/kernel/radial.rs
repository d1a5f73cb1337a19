//! Kernels g(s) of s = ½ Σ (xᵢ − xᵢ′)² / λᵢ²: derivatives of any order from those of g.

use super::{MOST_PAIRS, Orders, Pairs};

/// Highest order of a derivative in x − x′ over all axes together, and one more for gradients.
pub(super) const MOST_TOTAL: usize = 26;

/// Number of ways to pick `pairs` disjoint pairs out of `n`: n! / (pairs! (n − 2 pairs)! 2^pairs).
fn pairings(n: usize, pairs: usize) -> f64 {
    (0..pairs).map(|j| ((n - 2 * j) * (n - 2 * j - 1)) as f64 / (2.0 * (j + 1) as f64)).product()
}

/// ∂^γ g(s) for one pair, u the differences over lengthscales of the axes in use and `slopes` the
/// derivatives g⁽ᵐ⁾(s):
/// Π λ^(−γ) Σ_j Π c(γ, j) u^(γ−2j) g^(|γ|−|j|), the formula of Faà di Bruno for a quadratic s.
fn derivative(orders: &[usize], u: &[f64], slopes: &[f64]) -> f64 {
    fn sum(orders: &[usize], u: &[f64], order: usize, slopes: &[f64]) -> f64 {
        let Some((n, rest)) = orders.split_first() else { return slopes[order] };
        (0..=n / 2)
            .map(|j| {
                let inner = sum(rest, &u[1..], order + n - j, slopes);
                // A profile too rough for this many derivatives at s = 0 has none where u is 0.
                let power = u[0].powi((n - 2 * j) as i32);
                if power == 0.0 { 0.0 } else { pairings(*n, j) * power * inner }
            })
            .sum()
    }
    sum(orders, u, 0, slopes)
}

/// Whether a derivative is taken along an axis that the kernel does not depend on.
pub(super) fn beyond<const D: usize>(orders: [usize; D], axes: &[usize]) -> bool {
    (0..D).any(|d| orders[d] > 0 && !axes.contains(&d))
}

/// A function g of s with its derivatives.
pub(super) trait Profile {
    /// Fills `slopes` with g, g′, g″ … at s. Where a derivative at s = 0 does not exist it is 0.
    fn slopes(&self, s: f64, slopes: &mut [f64]);
}

/// Fills the table of [`super::Kernel::derivatives`].
pub(super) fn derivatives<const D: usize>(
    profile: &impl Profile,
    axes: &[usize],
    lengthscales: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    table: &mut [f64],
) {
    let count = pairs.count();
    for lane in 0..count {
        let pair = Pair::new(profile, axes, lengthscales, pairs, lane, orders);
        for (entry, order) in orders.iter().enumerate() {
            table[entry * count + lane] = pair.derivative(axes, lengthscales, order.first);
        }
    }
}

/// Adds the gradient in the logarithms of the lengthscales.
pub(super) fn pull_back<const D: usize>(
    profile: &impl Profile,
    axes: &[usize],
    lengthscales: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    weights: &[f64],
    gradient: &mut [f64],
) {
    let count = pairs.count();
    debug_assert!(count <= MOST_PAIRS);
    for lane in 0..count {
        let pair = Pair::new(profile, axes, lengthscales, pairs, lane, orders);
        for (entry, order) in orders.iter().enumerate() {
            let weight = weights[entry * count + lane];
            let value = pair.derivative(axes, lengthscales, order.first);
            for (axis, d) in axes.iter().enumerate() {
                let mut raised = order.first;
                raised[*d] += 1;
                let r = pair.u[axis] * lengthscales[axis];
                let next = pair.derivative(axes, lengthscales, raised);
                gradient[axis] -= weight * (r * next + order.first[*d] as f64 * value);
            }
        }
    }
}

/// Differences of one pair and the profile there.
struct Pair {
    u: Vec<f64>,
    slopes: [f64; MOST_TOTAL],
}

impl Pair {
    fn new<const D: usize>(
        profile: &impl Profile,
        axes: &[usize],
        lengthscales: &[f64],
        pairs: &Pairs<'_, D>,
        lane: usize,
        orders: &[Orders<D>],
    ) -> Self {
        let u: Vec<f64> = axes
            .iter()
            .zip(lengthscales)
            .map(|(d, lengthscale)| (pairs.first[*d][lane] - pairs.second[*d]) / lengthscale)
            .collect();
        let s = 0.5 * u.iter().map(|u| u * u).sum::<f64>();
        let most = orders.iter().map(|o| o.first.iter().sum::<usize>()).max().unwrap_or(0) + 2;
        let mut slopes = [0.0; MOST_TOTAL];
        profile.slopes(s, &mut slopes[..most]);
        Self { u, slopes }
    }

    fn derivative<const D: usize>(
        &self,
        axes: &[usize],
        lengthscales: &[f64],
        orders: [usize; D],
    ) -> f64 {
        if beyond(orders, axes) {
            return 0.0;
        }
        let mut picked = [0; D];
        let mut scale = 1.0;
        for (axis, d) in axes.iter().enumerate() {
            picked[axis] = orders[*d];
            scale *= lengthscales[axis].powi(orders[*d] as i32);
        }
        derivative(&picked[..axes.len()], &self.u, &self.slopes) / scale
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn pairings_are_hermite_coefficients() {
        // He₄ = x⁴ − 6x² + 3
        assert_eq!([0, 1, 2].map(|j| super::pairings(4, j)), [1.0, 6.0, 3.0]);
    }
}
