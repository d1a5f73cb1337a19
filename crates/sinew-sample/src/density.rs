//! A density with its gradient.

/// Logarithm of a density over ℝⁿ, up to a constant, with its gradient.
pub trait LogDensity: Sync {
    /// Number of parameters n.
    fn dimension(&self) -> usize;

    /// Logarithm at `x`, −∞ outside the domain; `gradient` is written where it is finite.
    fn value_and_gradient(&self, x: &[f64], gradient: &mut [f64]) -> f64;
}
