//! Material directions at the quadrature points.

use super::geometry::dot;
use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use crate::{Law, Scene, SceneError};

/// How far a unit vector's length may be from 1, and the product of perpendicular ones from 0: wide
/// enough for directions written to files in single precision.
const DIRECTION_TOLERANCE: f64 = 1e-5;

impl<L: Law<D>, const D: usize, const N: usize> Scene<L, D, N>
where
    Nodes<N>: FiniteElement<N>,
{
    /// Directions at each quadrature point, from one row per cell, point or node.
    pub(super) fn directions_at(
        &self,
        rule: &[QuadraturePoint],
    ) -> Result<Vec<[[f64; 3]; D]>, SceneError> {
        let (cells, given) = (self.mesh.cells.len(), self.directions.len());
        let points = cells * rule.len();
        if D == 0 {
            return Ok(Vec::new());
        }
        let nodes = self.mesh.points.len();
        if ![cells, points, nodes].contains(&given) {
            return Err(SceneError::DirectionCount { needed: D, cells, given, points, nodes });
        }
        self.check_directions()?;
        if given == points {
            return Ok(self.directions.clone());
        }
        if given == cells {
            let repeated = self.directions.iter().flat_map(|row| vec![*row; rule.len()]);
            return Ok(repeated.collect());
        }
        let shapes: Vec<_> = rule.iter().map(|point| Nodes::<N>::shape(point.at)).collect();
        let mut directions = Vec::with_capacity(points);
        for (cell, nodes) in self.mesh.cells.iter().enumerate() {
            let nodal = nodes.map(|node| self.directions[node]);
            for shape in &shapes {
                directions.push(interpolate(cell, &nodal, shape)?);
            }
        }
        Ok(directions)
    }

    fn check_directions(&self) -> Result<(), SceneError> {
        for (cell, directions) in self.directions.iter().enumerate() {
            for (direction, d) in directions.iter().enumerate() {
                let length = dot(d, d).sqrt();
                // Written so that a NaN is an error as well.
                let unit = (length - 1.0).abs() <= DIRECTION_TOLERANCE;
                if !unit {
                    return Err(SceneError::NotUnit { cell, direction, length });
                }
                for other in 0..direction {
                    let product = dot(d, &directions[other]);
                    if product.abs() > DIRECTION_TOLERANCE {
                        let pair = [other, direction];
                        return Err(SceneError::NotPerpendicular { cell, pair, product });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Nodal directions at a point. A direction has no sense, so each node's is turned to agree with the
/// first one's; the result is made orthonormal again.
fn interpolate<const D: usize, const N: usize>(
    cell: usize,
    nodal: &[[[f64; 3]; D]; N],
    shape: &[f64; N],
) -> Result<[[f64; 3]; D], SceneError> {
    let mut result = [[0.0; 3]; D];
    for direction in 0..D {
        let mut sum = [0.0; 3];
        for (row, weight) in nodal.iter().zip(shape) {
            let d = &row[direction];
            let sign = if dot(d, &nodal[0][direction]) < 0.0 { -1.0 } else { 1.0 };
            (0..3).for_each(|i| sum[i] += sign * weight * d[i]);
        }
        for other in &result[..direction] {
            let along = dot(&sum, other);
            (0..3).for_each(|i| sum[i] -= along * other[i]);
        }
        let length = dot(&sum, &sum).sqrt();
        let unit = length > DIRECTION_TOLERANCE;
        if !unit {
            return Err(SceneError::NotUnit { cell, direction, length });
        }
        result[direction] = sum.map(|x| x / length);
    }
    Ok(result)
}
