//! Weighted sums of an operator's values: integrals by quadrature.

use crate::domain::{Domain, Side};
use crate::error::GpError;
use crate::operator::Operator;

/// Σ weight · (L u)(point), a linear functional of u.
#[derive(Clone, Debug)]
pub struct Functional<const D: usize> {
    /// The operator L.
    pub operator: Operator<D>,
    /// Where it is evaluated.
    pub points: Vec<[f64; D]>,
    /// Weight of each point.
    pub weights: Vec<f64>,
}

/// Nodes and weights of Gauss and Legendre for ∫ over [0, 1], by Newton's method on the polynomial.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    (0..count)
        .map(|k| {
            let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (count as f64 + 0.5)).cos();
            let mut slope = 1.0;
            // Quadratic convergence from this start: six steps reach rounding for any count in use.
            for _ in 0..6 {
                let (mut before, mut at) = (1.0, x);
                for n in 2..=count {
                    let n = n as f64;
                    (before, at) = (at, ((2.0 * n - 1.0) * x * at - (n - 1.0) * before) / n);
                }
                if count == 1 {
                    before = 1.0;
                }
                slope = count as f64 * (x * at - before) / (x * x - 1.0);
                x -= at / slope;
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
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
    ) -> Result<Self, GpError> {
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
    ) -> Result<Self, GpError> {
        Self::over(domain, operator.into(), order, Some((domain.axis(axis)?, side)))
    }

    fn over(
        domain: &Domain<D>,
        operator: Operator<D>,
        order: usize,
        face: Option<(usize, Side)>,
    ) -> Result<Self, GpError> {
        if domain.cross_section().is_some() {
            return Err(GpError::PolygonFace { face: "the integral's domain".into() });
        }
        let mut nodes = vec![([0.0; D], 1.0)];
        for d in 0..D {
            let along: Vec<(f64, f64)> = match face {
                Some((axis, side)) if axis == d => vec![(domain.end(d, side), 1.0)],
                _ => gauss_legendre(order.max(1))
                    .into_iter()
                    .map(|(s, w)| {
                        (domain.lower()[d] + s * domain.extents()[d], w * domain.extents()[d])
                    })
                    .collect(),
            };
            nodes = nodes
                .iter()
                .flat_map(|(point, weight)| {
                    along.iter().map(move |(x, w)| {
                        let mut point = *point;
                        point[d] = *x;
                        (point, weight * w)
                    })
                })
                .collect();
        }
        let (points, weights) = nodes.into_iter().unzip();
        Ok(Self { operator, points, weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        for count in 1..8 {
            let rule = gauss_legendre(count);
            for power in 0..2 * count {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = 1.0 / (power as f64 + 1.0);
                assert!((sum - exact).abs() < 1e-14, "{count} {power}: {sum}");
            }
        }
        let domain = Domain::cuboid([("x", [0.0, 2.0]), ("y", [1.0, 4.0])]).unwrap();
        let area = Functional::integral(&domain, Operator::identity(), 3).unwrap();
        assert!((area.weights.iter().sum::<f64>() - 6.0).abs() < 1e-13);
        let edge = Functional::face_integral(&domain, ("x", Side::Upper), Operator::identity(), 3)
            .unwrap();
        assert!(edge.points.iter().all(|p| p[0] == 2.0));
        assert!((edge.weights.iter().sum::<f64>() - 3.0).abs() < 1e-13);
    }
}
