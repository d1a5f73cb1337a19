//! Material directions at the quadrature points.

use super::Setup;
use super::geometry::{DIRECTION_TOLERANCE, orthonormalise};
use crate::{Material, SceneError};
use sinew_mesh::Mesh;
use sinew_num::dot3;
use std::sync::Arc;

impl<const N: usize> Setup<'_, N> {
    /// The material with orthonormal directions at each quadrature point, from one row per cell, point or node that is so to the
    /// digits of a file.
    pub(super) fn material(&self) -> Result<Arc<dyn Material>, SceneError> {
        let material = &self.scene.material;
        let needed = material.law().directions;
        if needed == 0 {
            return Ok(material.clone());
        }
        let (cells, nodes) = (self.mesh.cells.len(), self.mesh.points.len());
        let (points, given) = (cells * self.rule.len(), material.points().unwrap_or(0));
        if ![cells, points, nodes].contains(&given) {
            return Err(SceneError::Fibres(format!(
                "the law reads {needed} directions, for each of the {cells} cells, {points} quadrature points or {nodes} nodes, but {given} rows are given"
            )));
        }
        let mut rows = Vec::with_capacity(needed * given);
        for row in 0..given {
            check_directions(row, material.directions(row))?;
            rows.extend_from_slice(material.directions(row));
            orthonormalise(&mut rows[needed * row..]);
        }
        Ok(material.with_directions(match given {
            _ if given == points => rows,
            _ if given == cells => {
                rows.chunks_exact(needed).flat_map(|row| row.repeat(self.rule.len())).collect()
            }
            _ => self.interpolated(&rows, needed)?,
        }))
    }

    /// Directions of nodes at the quadrature points.
    fn interpolated(&self, rows: &[[f64; 3]], needed: usize) -> Result<Vec<[f64; 3]>, SceneError> {
        let shapes: Vec<_> = self.rule.iter().map(|point| Mesh::<N>::shape(point.at)).collect();
        let mut directions = Vec::with_capacity(needed * self.mesh.cells.len() * shapes.len());
        for (cell, nodes) in self.mesh.cells.iter().enumerate() {
            for shape in &shapes {
                let start = directions.len();
                for direction in 0..needed {
                    let nodal = nodes.map(|node| rows[needed * node + direction]);
                    directions.push(interpolate(&nodal, shape));
                }
                if let Some((direction, length)) = orthonormalise(&mut directions[start..]) {
                    return Err(not_unit(cell, direction, length));
                }
            }
        }
        Ok(directions)
    }
}

fn not_unit(cell: usize, direction: usize, length: f64) -> SceneError {
    SceneError::Fibres(format!(
        "direction {direction} of cell {cell} has length {length}, not 1; normalise it, and give a direction to every cell that has none"
    ))
}

fn check_directions(cell: usize, directions: &[[f64; 3]]) -> Result<(), SceneError> {
    for (direction, d) in directions.iter().enumerate() {
        let length = dot3(d, d).sqrt();
        // Written so that a NaN is an error as well.
        let unit = (length - 1.0).abs() <= DIRECTION_TOLERANCE;
        if !unit {
            return Err(not_unit(cell, direction, length));
        }
        for other in 0..direction {
            let product = dot3(d, &directions[other]);
            if product.abs() > DIRECTION_TOLERANCE {
                return Err(SceneError::Fibres(format!(
                    "directions {other} and {direction} of cell {cell} have the inner product {product:e}, not 0; orthogonalise them"
                )));
            }
        }
    }
    Ok(())
}

/// A nodal direction interpolated at a point. A direction has no sense, so each is given the sign of the first node's.
fn interpolate<const N: usize>(nodal: &[[f64; 3]; N], shape: &[f64; N]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (d, weight) in nodal.iter().zip(shape) {
        let sign = if dot3(d, &nodal[0]) < 0.0 { -1.0 } else { 1.0 };
        (0..3).for_each(|i| sum[i] += sign * weight * d[i]);
    }
    sum
}
