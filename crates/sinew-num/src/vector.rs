//! Products of vectors, and vectors of three components.

use crate::Scalar;

/// Inner product.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
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
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].clone() * b[k].clone() - a[k].clone() * b[j].clone()
    })
}

/// Sum of three components each.
#[inline]
pub fn add3<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    std::array::from_fn(|i| a[i].clone() + b[i].clone())
}

/// Difference of three components each.
#[inline]
pub fn sub3(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_a_million_terms_keeps_its_digits() {
        let terms = vec![0.1; 1_000_000];
        // 20 halvings and 8 terms, of half a rounding each; one after the other they lose a factor of 1e5.
        assert!((sum(&terms) / 1e5 - 1.0).abs() <= 14.0 * f64::EPSILON, "{}", sum(&terms));
        assert!((terms.iter().sum::<f64>() / 1e5 - 1.0).abs() > 1000.0 * f64::EPSILON);
        assert_eq!((sum(&[]), sum(&[1.0, 2.0, -4.0])), (0.0, -1.0));
    }

    #[test]
    fn a_cross_product_is_normal_to_both_and_its_square_is_lagranges() {
        let (a, b) = ([1.0, 2.0, 3.0], [-4.0, 5.0, 7.0]);
        let normal = cross(&a, &b);
        assert_eq!(normal, [-1.0, -19.0, 13.0]);
        assert_eq!((dot3(&normal, &a), dot3(&normal, &b)), (0.0, 0.0));
        assert_eq!(norm(&[3.0, -4.0]), 5.0);
        assert_eq!(dot3(&normal, &normal), dot(&a, &a) * dot(&b, &b) - dot(&a, &b).powi(2));
        assert_eq!((add3(&a, &b), sub3(&a, &b)), ([-3.0, 7.0, 10.0], [5.0, -3.0, -4.0]));
    }
}
