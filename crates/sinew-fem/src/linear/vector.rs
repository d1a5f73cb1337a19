//! Products and norms of vectors.

pub(crate) use sinew_num::{difference, dot};

/// Norm of a vector, by plain squares where they neither overflow nor underflow.
pub(crate) fn norm(x: &[f64]) -> f64 {
    /// Squares between these bounds lose nothing to overflow or underflow.
    const PLAIN: std::ops::Range<f64> = 1e-140..1e150;
    let plain = dot(x, x).sqrt();
    if PLAIN.contains(&plain) { plain } else { x.iter().copied().fold(0.0, f64::hypot) }
}

/// Adds a multiple of a vector.
pub(crate) fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
}

/// Residual relative to a force; zero for 0/0.
pub(crate) fn relative(residual: f64, force: f64) -> f64 {
    if residual == 0.0 { 0.0 } else { residual / force }
}

/// Starts and indices of a compressed structure of successive parts, each given by its indices and the ends of its rows or columns.
pub(crate) fn compressed<T>(parts: Vec<(Vec<T>, Vec<usize>)>) -> (Vec<usize>, Vec<T>) {
    let (mut starts, mut indices) = (vec![0], Vec::new());
    for (mut of_part, ends) in parts {
        starts.extend(ends.iter().map(|end| indices.len() + end));
        indices.append(&mut of_part);
    }
    (starts, indices)
}
