//! Preconditioned conjugate gradients.

/// How an iterative solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Outcome {
    /// Products with the matrix.
    pub iterations: usize,
    /// Norm of the residual relative to that of the right-hand side.
    pub relative_residual: f64,
    pub end: End,
}

/// Why an iterative solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The residual is below the tolerance.
    Converged,
    /// The matrix has a direction of negative or no curvature; the solution is what was found before, or that
    /// direction if there was none: either descends.
    NegativeCurvature,
    /// The iterations ran out.
    Exhausted,
    /// A number overflowed or is none.
    NotFinite,
}

/// Solves `A x = b` with a symmetric matrix from x = 0 (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952), truncated at
/// negative curvature (T. Steihaug, SIAM J. Numer. Anal. 20, 1983).
///
/// `apply(x, y)` writes A x to y; `precondition(x, y)` a symmetric positive definite approximation of A⁻¹ x.
pub(crate) fn conjugate_gradients(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    mut precondition: impl FnMut(&[f64], &mut [f64]),
    right: &[f64],
    solution: &mut [f64],
    tolerance: f64,
    most_iterations: usize,
) -> Outcome {
    solution.fill(0.0);
    let scale = dot(right, right).sqrt();
    let mut outcome = Outcome { iterations: 0, relative_residual: 0.0, end: End::Converged };
    if scale == 0.0 {
        return outcome;
    }
    let mut residual = right.to_vec();
    let mut direction = vec![0.0; right.len()];
    let mut product = vec![0.0; right.len()];
    precondition(&residual, &mut direction);
    let mut slope = dot(&residual, &direction);
    loop {
        outcome.relative_residual = dot(&residual, &residual).sqrt() / scale;
        if outcome.relative_residual <= tolerance {
            return outcome;
        }
        if !(outcome.relative_residual.is_finite() && slope.is_finite()) {
            return Outcome { end: End::NotFinite, ..outcome };
        }
        if outcome.iterations == most_iterations {
            return Outcome { end: End::Exhausted, ..outcome };
        }
        apply(&direction, &mut product);
        outcome.iterations += 1;
        let curvature = dot(&direction, &product);
        if curvature <= 0.0 || slope <= 0.0 {
            if outcome.iterations == 1 {
                solution.copy_from_slice(&direction);
            }
            return Outcome { end: End::NegativeCurvature, ..outcome };
        }
        let length = slope / curvature;
        solution.iter_mut().zip(&direction).for_each(|(x, p)| *x += length * p);
        residual.iter_mut().zip(&product).for_each(|(r, q)| *r -= length * q);
        precondition(&residual, &mut product);
        let next = dot(&residual, &product);
        let turn = next / slope;
        direction.iter_mut().zip(&product).for_each(|(p, z)| *p = z + turn * *p);
        slope = next;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
