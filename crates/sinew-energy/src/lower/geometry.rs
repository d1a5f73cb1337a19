//! Shape functions and material directions at the quadrature points of a mesh, and cells that lie over each other.

use super::{Setup, own_rule};
use crate::error::listed;
use crate::laws::Guccione;
use crate::{Material, Scene, SceneError};
use sinew_mesh::{Mesh, QuadraturePoint, folded_facets};
use sinew_num::{Mat3, ascending, cross, dot3};
use std::sync::Arc;

/// Gradients of the shape functions at each quadrature point, and the volumes that the points stand for.
#[expect(clippy::type_complexity, reason = "the two arrays of Body")]
pub(super) fn shape_functions<const N: usize>(
    mesh: &Mesh<N>,
    rule: &[QuadraturePoint],
) -> Result<(Vec<[[f64; 3]; N]>, Vec<f64>), SceneError> {
    let derivatives: Vec<_> = rule.iter().map(|p| Mesh::<N>::shape_derivatives(p.at)).collect();
    let mut gradients = Vec::with_capacity(mesh.cells.len() * rule.len());
    let mut volumes = Vec::with_capacity(mesh.cells.len() * rule.len());
    for (cell, nodes) in mesh.cells.iter().enumerate() {
        let corners = nodes.map(|node| mesh.points[node]);
        for (point, derivatives) in rule.iter().zip(&derivatives) {
            let (gradient, determinant) = gradients_at(&corners, derivatives);
            // Written so that a NaN is an error as well.
            let positive = determinant > 0.0 && determinant.is_finite();
            if !positive {
                return Err(SceneError::Body(format!(
                    "cell {cell} has the volume {:?}, which must be positive; turn inverted cells over, and mesh a body with flat ones anew",
                    determinant * point.weight
                )));
            }
            gradients.push(gradient);
            volumes.push(point.weight * determinant);
        }
    }
    Ok((gradients, volumes))
}

/// Gradients in the reference configuration, and the determinant of the map from the reference element.
fn gradients_at<const N: usize>(
    nodes: &[[f64; 3]; N],
    derivatives: &[[f64; 3]; N],
) -> ([[f64; 3]; N], f64) {
    // Columns of the Jacobian; differences first, so that nothing cancels far from the origin.
    let mut columns = [[0.0; 3]; 3];
    for (x, slope) in nodes.iter().zip(derivatives).skip(1) {
        for (column, s) in columns.iter_mut().zip(slope) {
            for i in 0..3 {
                column[i] += (x[i] - nodes[0][i]) * s;
            }
        }
    }
    if Mesh::<N>::ELEMENT.dimension == 2 {
        columns[2] = [0.0, 0.0, 1.0];
    }
    let [a, b, c] = columns;
    let determinant = dot3(&a, &cross(&b, &c));
    let inverse =
        [cross(&b, &c), cross(&c, &a), cross(&a, &b)].map(|row| row.map(|x| x / determinant));
    let mut gradients = [[0.0; 3]; N];
    for (gradient, slope) in gradients.iter_mut().zip(derivatives).skip(1) {
        *gradient = std::array::from_fn(|i| (0..3).map(|k| slope[k] * inverse[k][i]).sum());
    }
    gradients[0] =
        std::array::from_fn(|i| -gradients[1..].iter().map(|gradient| gradient[i]).sum::<f64>());
    (gradients, determinant)
}

/// Places of the quadrature points of a scene, cell by cell.
pub(super) fn places<const N: usize>(scene: &Scene, mesh: &Mesh<N>) -> Vec<[f64; 3]> {
    let rule = own_rule::<N>(scene).iter();
    let shapes: Vec<[f64; N]> = rule.map(|point| Mesh::<N>::shape(point.at)).collect();
    let place = |cell: &[usize; N], shape: &[f64; N]| -> [f64; 3] {
        std::array::from_fn(|i| {
            cell.iter().zip(shape).map(|(&node, n)| n * mesh.points[node][i]).sum()
        })
    };
    mesh.cells.iter().flat_map(|cell| shapes.iter().map(|shape| place(cell, shape))).collect()
}

/// Largest error of the length of a unit vector and of the product of perpendicular ones: directions in files may have
/// single precision.
pub(super) const DIRECTION_TOLERANCE: f64 = 1e-5;

/// Makes vectors orthonormal in their order: number and length of the first whose part across those before it is too short.
pub(crate) fn orthonormalise(vectors: &mut [[f64; 3]]) -> Option<(usize, f64)> {
    let mut short = None;
    for at in 0..vectors.len() {
        let mut vector = vectors[at];
        for other in &vectors[..at] {
            let along = dot3(&vector, other);
            (0..3).for_each(|i| vector[i] -= along * other[i]);
        }
        let length = dot3(&vector, &vector).sqrt();
        vectors[at] = vector.map(|x| x / length);
        // Written so that a NaN is short as well.
        let long = length > DIRECTION_TOLERANCE;
        if !long {
            short = short.or(Some((at, length)));
        }
    }
    short
}

/// Checks that no two cells lie on the same side of a facet.
pub(super) fn check_overlaps<const N: usize>(mesh: &Mesh<N>) -> Result<(), SceneError> {
    let folds = folded_facets(mesh);
    let Some(pair) = folds.first() else { return Ok(()) };
    let cells = pair.map(|facet| facet.cell);
    let corners = mesh.nodes_of_facet(pair[0]).take(Mesh::<N>::ELEMENT.facet_corners);
    let [first, second] = cells.map(|cell| ascending(mesh.cells[cell]));
    let advice = if first == second {
        "they are one cell listed twice: remove one"
    } else {
        "one is folded over the other, the mesh is tangled there: move their nodes apart, or mesh the body anew"
    };
    Err(SceneError::Body(format!(
        "cells {} lie on the same side of the facet with nodes {}; {advice}",
        cells.map(|cell| cell.to_string()).join(" and "),
        listed(&ascending(corners))
    )))
}

impl<const N: usize> Setup<'_, N> {
    /// The material with orthonormal directions at each quadrature point, from one row per cell, point or node that is so to the
    /// digits of a file. A node whose row is zero takes those of the others of its cells.
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
            let own = material.directions(row);
            rows.extend_from_slice(own);
            let is_nodal = given != points && given != cells;
            if !is_nodal || own.iter().flatten().any(|x| *x != 0.0) {
                check_directions(row, own)?;
                orthonormalise(&mut rows[needed * row..]);
            }
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
        let read = if needed > 1 && !self.reads_across() { 1 } else { needed };
        let mut directions = Vec::with_capacity(needed * self.mesh.cells.len() * shapes.len());
        for (cell, nodes) in self.mesh.cells.iter().enumerate() {
            for shape in &shapes {
                let start = directions.len();
                for direction in 0..read {
                    let nodal = nodes.map(|node| rows[needed * node + direction]);
                    let (mean, is_determined) = interpolate(&nodal, shape);
                    if !is_determined {
                        return Err(SceneError::Fibres(format!(
                            "nothing determines direction {direction} of cell {cell}: those of its nodes stand at right angles to each other; give one to each cell instead"
                        )));
                    }
                    directions.push(mean);
                }
                if let Some((direction, length)) = orthonormalise(&mut directions[start..]) {
                    return Err(not_unit(cell, direction, length));
                }
                let frame = Guccione::frame(directions[start]);
                directions.extend_from_slice(&frame[read..needed]);
            }
        }
        Ok(directions)
    }

    /// Whether the energy changes where the directions across the first one turn about it: Guccione's does not.
    fn reads_across(&self) -> bool {
        let parameters = &self.scene.parameters[..self.scene.material.parameters().len()];
        let theta: Vec<f64> = parameters.iter().map(|p| p.range[1]).collect();
        let h = Mat3::from_fn(|i, j| 0.01 * (1.0 + 2.0 * i as f64 + 5.0 * j as f64).sin());
        let energy = |[c, s]: [f64; 2]| {
            let frame = [[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]];
            let directions = frame[..self.scene.material.law().directions].to_vec();
            self.scene.material.with_directions(directions).energy(0, &theta, &h, None)
        };
        let [plain, turned] = [[1.0, 0.0], [0.6, 0.8]].map(energy);
        // Written so that a NaN is a change as well.
        let alike = (turned - plain).abs() <= 1e-9 * plain.abs();
        !alike
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

/// Squarings that tell the largest eigenvalue of a matrix from one that is smaller by a part of 1e-5.
const SQUARINGS: usize = 20;

/// A nodal direction interpolated at a point, and whether anything determines it. A direction has no sense: each is turned along the
/// principal one of `Σ w d dᵀ`, and counts nothing at right angles to it.
fn interpolate<const N: usize>(nodal: &[[f64; 3]; N], shape: &[f64; N]) -> ([f64; 3], bool) {
    let weighted = || nodal.iter().zip(shape);
    // Directions within eight degrees of each other are turned along any of them as along the principal one.
    let agree = nodal.iter().all(|d| dot3(d, &nodal[0]).abs() > 0.99);
    let mut power = Mat3::from_fn(|i, j| weighted().map(|(d, w)| w * d[i] * d[j]).sum::<f64>());
    // Tends to the projection on the principal direction.
    for _ in 0..if agree { 0 } else { SQUARINGS } {
        let norm = power.squared_norm();
        power = Mat3::from_fn(|i, j| dot3(&power[i], &power[j]) / norm);
    }
    let longer = |a: [f64; 3], b: [f64; 3]| if dot3(&a, &a) < dot3(&b, &b) { b } else { a };
    let principal = if agree { nodal[0] } else { longer(longer(power[0], power[1]), power[2]) };
    let sense = 1f64.copysign(dot3(&principal, &nodal[0]));
    let mut sum = [0.0; 3];
    for (d, weight) in weighted() {
        let along = dot3(d, &principal);
        let sign = if along.abs() > DIRECTION_TOLERANCE { along.signum() * sense } else { 0.0 };
        (0..3).for_each(|i| sum[i] += sign * weight * d[i]);
    }
    (sum, agree || power.squared_norm() > 0.99)
}
