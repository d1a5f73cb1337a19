//! Shape functions at the quadrature points of a mesh, and cells that lie over each other.

use super::own_rule;
use crate::error::listed;
use crate::{Scene, SceneError};
use sinew_mesh::{Mesh, QuadraturePoint, folded_facets};
use sinew_num::{ascending, cross, dot3};

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
                    "cell {cell} has the volume {:?}, which must be positive; turn inverted cells by sinew_mesh::repair_orientation, and mesh a body with flat ones anew",
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
