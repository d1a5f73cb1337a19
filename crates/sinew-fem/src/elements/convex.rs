//! Tangents without negative eigenvalues.

use nalgebra::SMatrix;

/// Negative eigenvalue \[relative to the mean one\] that a tangent may keep.
const NEARLY: f64 = 1e-2;

/// Replaces the negative eigenvalues of a tangent by zero, if there are any (J. Teran, E. Sifakis, G. Irving, R. Fedkiw, Symposium on Computer Animation,
/// 2005); whether it did.
pub(crate) fn make_convex(tangent: &mut [[f64; 9]; 9]) -> bool {
    // Squares of entries near overflow are no numbers.
    let scale = tangent.as_flattened().iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    if !(scale > 0.0 && scale.is_finite()) {
        return false;
    }
    let half = 0.5 / scale;
    let matrix = SMatrix::<f64, 9, 9>::from_fn(|i, j| half * tangent[i][j] + half * tangent[j][i]);
    let nearly = SMatrix::identity() * (NEARLY / 9.0 * matrix.trace().abs());
    if (matrix + nearly).cholesky().is_some() {
        return false;
    }
    let eigen = matrix.symmetric_eigen();
    let negative = eigen.eigenvalues.map(|value| value.min(0.0));
    let part =
        eigen.eigenvectors * SMatrix::from_diagonal(&negative) * eigen.eigenvectors.transpose();
    for (i, row) in tangent.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, entry)| *entry -= scale * part[(i, j)]);
    }
    true
}
