//! Weighted sums of an operator's values: integrals by quadrature.

use crate::domain::{Domain, Side};
use crate::error::GpError;
use crate::operator::Operator;
use crate::quadrature::gauss_legendre;

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
    fn integrals_of_one_are_sizes() {
        let domain = Domain::cuboid([("x", [0.0, 2.0]), ("y", [1.0, 4.0])]).unwrap();
        let area = Functional::integral(&domain, Operator::identity(), 3).unwrap();
        assert!((area.weights.iter().sum::<f64>() - 6.0).abs() < 1e-13);
        let edge = Functional::face_integral(&domain, ("x", Side::Upper), Operator::identity(), 3)
            .unwrap();
        assert!(edge.points.iter().all(|p| p[0] == 2.0));
        assert!((edge.weights.iter().sum::<f64>() - 3.0).abs() < 1e-13);
    }
}
