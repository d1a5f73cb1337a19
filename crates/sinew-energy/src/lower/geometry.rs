//! Shape functions at the quadrature points of a mesh.

use crate::SceneError;
use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use sinew_mesh::Mesh;
use sinew_num::{cross, dot3};

/// Gradients of the shape functions at each quadrature point, and the volumes that the points stand for.
#[expect(clippy::type_complexity, reason = "the two arrays of Body")]
pub(super) fn shape_functions<const N: usize>(
    mesh: &Mesh<N>,
    rule: &[QuadraturePoint],
) -> Result<(Vec<[[f64; 3]; N]>, Vec<f64>), SceneError>
where
    Nodes<N>: FiniteElement<N>,
{
    let derivatives: Vec<_> = rule.iter().map(|p| Nodes::<N>::shape_derivatives(p.at)).collect();
    let mut gradients = Vec::with_capacity(mesh.cells.len() * rule.len());
    let mut volumes = Vec::with_capacity(mesh.cells.len() * rule.len());
    for (cell, nodes) in mesh.cells.iter().enumerate() {
        let corners = nodes.map(|node| mesh.points[node]);
        for (point, derivatives) in rule.iter().zip(&derivatives) {
            let (gradient, determinant) = gradients_at(&corners, derivatives);
            // Written so that a NaN is an error as well.
            let positive = determinant > 0.0 && determinant.is_finite();
            if !positive {
                return Err(SceneError::InvertedCell { cell, volume: determinant * point.weight });
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
) -> ([[f64; 3]; N], f64)
where
    Nodes<N>: FiniteElement<N>,
{
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

/// Vectors made orthonormal in their order, and the lengths of their parts perpendicular to those before.
pub(crate) fn orthonormal<const D: usize>(mut vectors: [[f64; 3]; D]) -> ([[f64; 3]; D], [f64; D]) {
    let mut lengths = [0.0; D];
    for at in 0..D {
        let mut vector = vectors[at];
        for other in &vectors[..at] {
            let along = dot3(&vector, other);
            (0..3).for_each(|i| vector[i] -= along * other[i]);
        }
        lengths[at] = dot3(&vector, &vector).sqrt();
        vectors[at] = vector.map(|x| x / lengths[at]);
    }
    (vectors, lengths)
}
