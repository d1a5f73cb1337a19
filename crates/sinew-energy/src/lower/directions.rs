//! Material directions at the quadrature points.

use super::Setup;
use super::geometry::orthonormal;
use crate::SceneError;
use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use sinew_num::dot3;

/// Largest error of the length of a unit vector and of the product of perpendicular ones: directions in files may have
/// single precision.
const DIRECTION_TOLERANCE: f64 = 1e-5;

impl<const N: usize> Setup<'_, N>
where
    Nodes<N>: FiniteElement<N>,
{
    /// Orthonormal directions at each quadrature point, from one row per cell, point or node that is so to the digits of
    /// a file.
    pub(super) fn directions_at<const D: usize>(
        &self,
        rule: &[QuadraturePoint],
        rows: &[[[f64; 3]; D]],
    ) -> Result<Vec<[[f64; 3]; D]>, SceneError> {
        let (cells, given) = (self.mesh.cells.len(), rows.len());
        let points = cells * rule.len();
        if D == 0 {
            return Ok(Vec::new());
        }
        let nodes = self.mesh.points.len();
        if ![cells, points, nodes].contains(&given) {
            return Err(SceneError::DirectionCount { needed: D, cells, given, points, nodes });
        }
        check_directions(rows)?;
        let rows = rows.iter().enumerate().map(|(row, sum)| checked(row, *sum));
        let rows: Vec<_> = rows.collect::<Result<_, _>>()?;
        if given == points {
            return Ok(rows);
        }
        if given == cells {
            return Ok(rows.iter().flat_map(|row| vec![*row; rule.len()]).collect());
        }
        let shapes: Vec<_> = rule.iter().map(|point| Nodes::<N>::shape(point.at)).collect();
        let mut directions = Vec::with_capacity(points);
        for (cell, nodes) in self.mesh.cells.iter().enumerate() {
            let nodal = nodes.map(|node| rows[node]);
            for shape in &shapes {
                directions.push(checked(cell, interpolate(&nodal, shape))?);
            }
        }
        Ok(directions)
    }
}

fn check_directions<const D: usize>(rows: &[[[f64; 3]; D]]) -> Result<(), SceneError> {
    for (cell, directions) in rows.iter().enumerate() {
        for (direction, d) in directions.iter().enumerate() {
            let length = dot3(d, d).sqrt();
            // Written so that a NaN is an error as well.
            let unit = (length - 1.0).abs() <= DIRECTION_TOLERANCE;
            if !unit {
                return Err(SceneError::NotUnit { cell, direction, length });
            }
            for other in 0..direction {
                let product = dot3(d, &directions[other]);
                if product.abs() > DIRECTION_TOLERANCE {
                    let pair = [other, direction];
                    return Err(SceneError::NotPerpendicular { cell, pair, product });
                }
            }
        }
    }
    Ok(())
}

/// Nodal directions interpolated at a point. A direction has no sense, so each is given the sign of the first node's.
fn interpolate<const D: usize, const N: usize>(
    nodal: &[[[f64; 3]; D]; N],
    shape: &[f64; N],
) -> [[f64; 3]; D] {
    std::array::from_fn(|direction| {
        let mut sum = [0.0; 3];
        for (row, weight) in nodal.iter().zip(shape) {
            let d = &row[direction];
            let sign = if dot3(d, &nodal[0][direction]) < 0.0 { -1.0 } else { 1.0 };
            (0..3).for_each(|i| sum[i] += sign * weight * d[i]);
        }
        sum
    })
}

/// Directions made orthonormal in their order; exact ones stay as they are.
fn checked<const D: usize>(
    cell: usize,
    directions: [[f64; 3]; D],
) -> Result<[[f64; 3]; D], SceneError> {
    let (directions, lengths) = orthonormal(directions);
    // Written so that a NaN is an error as well.
    let unit = |length: &f64| *length > DIRECTION_TOLERANCE;
    match lengths.iter().position(|length| !unit(length)) {
        None => Ok(directions),
        Some(at) => Err(SceneError::NotUnit { cell, direction: at, length: lengths[at] }),
    }
}
