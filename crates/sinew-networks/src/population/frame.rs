//! Axes that turn with a body.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Principal axes of the nodes, one in each row, right-handed: longest first, the first two in the direction in which the nodes are
/// skewed (third moment), the third across both.
///
/// They turn with the body. Nodes count alike, so that a graded mesh has slightly other axes; bodies that are symmetric have no axes of
/// their own, and rounding decides.
pub(super) fn frame(positions: &[[f64; 3]]) -> [[f64; 3]; 3] {
    let points = || positions.iter().map(|x| Vector3::from(*x));
    let centre = points().sum::<Vector3<f64>>() / positions.len() as f64;
    let spread: Matrix3<f64> = points().map(|x| (x - centre) * (x - centre).transpose()).sum();
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(spread);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigenvalues[*b].total_cmp(&eigenvalues[*a]));
    let axis = |k: usize| -> Vector3<f64> {
        let axis: Vector3<f64> = eigenvectors.column(order[k]).into_owned();
        let skewness: f64 = points().map(|x| axis.dot(&(x - centre)).powi(3)).sum();
        if skewness < 0.0 { -axis } else { axis }
    };
    let (first, second) = (axis(0), axis(1));
    [first, second, first.cross(&second)].map(Into::into)
}

/// Positions along axes.
pub(super) fn along(axes: &[[f64; 3]; 3], positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    positions.iter().map(|x| axes.each_ref().map(|axis| dot(axis, x))).collect()
}
