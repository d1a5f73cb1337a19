//! Nodes and weights of Gaussian quadrature.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side};

/// Nodes with the products of their weights, of one rule for each axis.
pub(crate) fn tensor_product<const D: usize>(rules: &[Vec<(f64, f64)>; D]) -> Vec<([f64; D], f64)> {
    let mut product = vec![([0.0; D], 1.0)];
    for (d, rule) in rules.iter().enumerate() {
        let extended = product.iter().flat_map(|(node, weight)| {
            rule.iter().map(move |(x, w)| {
                let mut node = *node;
                node[d] = *x;
                (node, weight * w)
            })
        });
        product = extended.collect();
    }
    product
}

/// Nodes and weights of Gauss and Legendre for ∫ over [0, 1].
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let rule = gauss(count, |n| n / (4.0 * n * n - 1.0).sqrt());
    rule.into_iter().map(|(x, weight)| (0.5 * (1.0 + x), weight)).collect()
}

/// Nodes and weights of Gauss and Hermite for means over a standard normal variable.
pub(crate) fn gauss_hermite(count: usize) -> Vec<(f64, f64)> {
    gauss(count, f64::sqrt)
}

/// The spectrum of the Jacobi matrix of orthogonal polynomials (Golub & Welsch 1969), with the
/// n-th number beside its diagonal of zeros from `beside`.
fn gauss(count: usize, beside: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let jacobi = Mat::from_fn(count, count, |i, j| match i.abs_diff(j) {
        1 => beside(i.max(j) as f64),
        _ => 0.0,
    });
    let eigen = SelfAdjointEigen::new(jacobi.as_ref(), Side::Lower)
        .expect("the spectrum of a small tridiagonal matrix is always found");
    let nodes = eigen.S().column_vector();
    (0..count).map(|k| (nodes[k], eigen.U()[(0, k)].powi(2))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials() {
        for count in 1..8 {
            let mean = |rule: Vec<(f64, f64)>, power: usize| -> f64 {
                rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum()
            };
            for power in 0..2 * count {
                let uniform = 1.0 / (power as f64 + 1.0);
                let found = mean(gauss_legendre(count), power);
                assert!((found - uniform).abs() < 1e-14, "{count} {power}: {found}");
                // Of even powers 1 · 3 · 5 ⋯ (power − 1).
                let normal: f64 = match power % 2 {
                    0 => (1..power).step_by(2).map(|odd| odd as f64).product(),
                    _ => 0.0,
                };
                let found = mean(gauss_hermite(count), power);
                // Of the size of the next even moment, up to 135135.
                let size: f64 = (1..=power).step_by(2).map(|odd| odd as f64).product();
                assert!((found - normal).abs() < 1e-12 * size, "{count} {power}: {found}");
            }
        }
    }
}
