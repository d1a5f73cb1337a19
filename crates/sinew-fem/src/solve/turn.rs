//! Rotation of the nodes with prescribed motion.

use nalgebra::{Matrix3, Rotation3, Vector3};
use sinew_energy::Body;

/// A motion is one of a rigid body when its nodes are no farther off [relative to their distance from the centre]: coordinates of files.
const RIGID: f64 = 1e-4;
/// Rotation above which the failure is attributed to it \[degrees\]: halfway the held part is only half as wide.
const FAR: f64 = 120.0;

/// Angle \[degrees\] by which a prescribed motion turns the nodes that it moves as a rigid body, if it is far.
pub(crate) fn far_turn(body: &Body) -> Option<f64> {
    let held = |node: usize| -> Option<Vector3<f64>> {
        let [x, y, z] = [0, 1, 2].map(|i| body.prescribed[3 * node + i]);
        Some(Vector3::new(x?, y?, z?)).filter(|u| body.frames.get(node).is_none() && u.norm() > 0.0)
    };
    let moved = (0..body.nodes).filter_map(|node| {
        let from = Vector3::from(body.positions[node]);
        Some((from, from + held(node)?))
    });
    let pairs: Vec<_> = moved.collect();
    let mean = |sum: Vector3<f64>| sum / pairs.len() as f64;
    let [from, to] = [mean(pairs.iter().map(|p| p.0).sum()), mean(pairs.iter().map(|p| p.1).sum())];
    let arms = || pairs.iter().map(|(x, y)| (x - from, y - to));
    let products = arms().fold(Matrix3::zeros(), |sum, (x, y)| sum + y * x.transpose());
    let rotation = nearest_rotation(&products)?;
    let size = arms().map(|(x, _)| x.norm()).fold(0.0, f64::max);
    let off = arms().map(|(x, y)| (rotation * x - y).norm()).fold(0.0, f64::max);
    let degrees = rotation.angle().to_degrees();
    (size > 0.0 && off <= RIGID * size && degrees >= FAR).then_some(degrees)
}

/// The rotation R with the largest `tr(Rᵀ M)` (W. Kabsch, Acta Cryst. A 32, 1976).
fn nearest_rotation(products: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let singular = products.iter().all(|x| x.is_finite()).then(|| products.svd(true, true))?;
    let (u, v) = (singular.u?, singular.v_t?);
    // The least singular value comes last; a plane's motion leaves its sign open.
    let sign = if (u * v).determinant() < 0.0 { -1.0 } else { 1.0 };
    let turned = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v;
    Some(Rotation3::from_matrix_unchecked(turned))
}
