//! Products of vectors, and vectors of three components.

use crate::Scalar;

/// Inner product.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// `a − b`.
pub fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Sum by halves: its rounding error grows with the logarithm of the number of terms.
///
/// ```
/// let tenths = vec![0.1; 1_000_000];
/// assert!((sinew_num::sum(&tenths) - 1e5).abs() < 1e-9);
/// assert!((tenths.iter().sum::<f64>() - 1e5).abs() > 1e-6); // one after the other
/// ```
pub fn sum(terms: &[f64]) -> f64 {
    /// Terms that are added one after the other.
    const FEW: usize = 8;
    if terms.len() <= FEW {
        return terms.iter().sum();
    }
    let (first, second) = terms.split_at(terms.len() / 2);
    sum(first) + sum(second)
}

/// Euclidean norm.
#[inline]
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Inner product of three components.
#[inline]
pub fn dot3<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> S {
    a[0].clone() * b[0].clone() + a[1].clone() * b[1].clone() + a[2].clone() * b[2].clone()
}

/// Cross product.
#[inline]
pub fn cross<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    let entry = |j: usize, k: usize| a[j].clone() * b[k].clone() - a[k].clone() * b[j].clone();
    [entry(1, 2), entry(2, 0), entry(0, 1)]
}

/// Sum of three components each.
#[inline]
pub fn add3<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    let entry = |i: usize| a[i].clone() + b[i].clone();
    [entry(0), entry(1), entry(2)]
}

/// Difference of three components each.
#[inline]
pub fn sub3(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
