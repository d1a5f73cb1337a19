//! Weighted sums of an operator's values: integrals by quadrature.

use crate::problem::domain::grid;
use crate::{Domain, Operator, Result, Side};
use nalgebra::DMatrix;

/// Σ weight · (L u)(point), a linear functional of u.
#[derive(Clone, Debug)]
pub struct Functional<const D: usize> {
    /// The operator L.
    pub operator: Operator<D>,
    /// Place of evaluation.
    pub points: Vec<[f64; D]>,
    /// Weight of each point.
    pub weights: Vec<f64>,
}

impl<const D: usize> Functional<D> {
    /// ∫ L u over a box, by Gauss–Legendre quadrature with `order` points along each axis.
    ///
    /// # Errors
    /// For domains with a polygon; give points and weights of your own there.
    pub fn integral(
        domain: &Domain<D>,
        operator: impl Into<Operator<D>>,
        order: usize,
    ) -> Result<Self> {
        Self::over(domain, operator.into(), order, None)
    }

    /// ∫ L u over the face at one end of an axis.
    ///
    /// # Errors
    /// As [`Functional::integral`]; and if there is no such axis.
    pub fn face_integral(
        domain: &Domain<D>,
        (axis, side): (&str, Side),
        operator: impl Into<Operator<D>>,
        order: usize,
    ) -> Result<Self> {
        Self::over(domain, operator.into(), order, Some((domain.axis(axis)?, side)))
    }

    fn over(
        domain: &Domain<D>,
        operator: Operator<D>,
        order: usize,
        face: Option<(usize, Side)>,
    ) -> Result<Self> {
        ensure!(
            domain.cross_section().is_none(),
            "the domain has a polygon; give points and weights of your own for the integral"
        );
        let along = |d: usize| match face {
            Some((axis, side)) if axis == d => (vec![domain.ends[d][side as usize]], vec![1.0]),
            _ => {
                let ([lower, _], extent) = (domain.ends[d], domain.extents()[d]);
                let rule = gauss_legendre(order.max(1)).into_iter();
                rule.map(|(s, w)| (lower + s * extent, w * extent)).unzip()
            }
        };
        let rules: [(Vec<f64>, Vec<f64>); D] = std::array::from_fn(along);
        let points = grid(&rules.each_ref().map(|rule| rule.0.clone()));
        let weights = grid(&rules.map(|rule| rule.1));
        let weights = weights.iter().map(|along| along.iter().product()).collect();
        Ok(Self { operator, points, weights })
    }
}

/// Nodes and weights of Gauss and Legendre for ∫ over [0, 1], from the spectrum of the Jacobi matrix of their polynomials (Golub &
/// Welsch 1969).
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let beside = |n: f64| n / (4.0 * n * n - 1.0).sqrt();
    let jacobi = DMatrix::from_fn(count, count, |i, j| match i.abs_diff(j) {
        1 => beside(i.max(j) as f64),
        _ => 0.0,
    });
    let eigen = jacobi.symmetric_eigen();
    let node = |k: usize| (0.5 * (1.0 + eigen.eigenvalues[k]), eigen.eigenvectors[(0, k)].powi(2));
    (0..count).map(node).collect()
}
