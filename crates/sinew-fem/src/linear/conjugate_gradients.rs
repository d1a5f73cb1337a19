//! Preconditioned conjugate gradients.

use crate::vector::{dot, norm};

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
/// Ends when the residual is `tolerance` times the right-hand side, after `most` iterations, or after `most_halfway`
/// without half of the digits asked for.
///
/// `apply(x, y)` writes A x to y; `precondition(x, y)` a symmetric positive definite approximation of A⁻¹ x.
pub(crate) fn conjugate_gradients(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    mut precondition: impl FnMut(&[f64], &mut [f64]),
    right: &[f64],
    solution: &mut [f64],
    tolerance: f64,
    [most_halfway, most]: [usize; 2],
) -> Outcome {
    solution.fill(0.0);
    let scale = norm(right);
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
        outcome.relative_residual = norm(&residual) / scale;
        if outcome.relative_residual <= tolerance {
            return outcome;
        }
        if !(outcome.relative_residual.is_finite() && slope.is_finite()) {
            return Outcome { end: End::NotFinite, ..outcome };
        }
        let late =
            outcome.iterations == most_halfway && outcome.relative_residual > tolerance.sqrt();
        if late || outcome.iterations >= most {
            return Outcome { end: End::Exhausted, ..outcome };
        }
        apply(&direction, &mut product);
        outcome.iterations += 1;
        let curvature = dot(&direction, &product);
        if !curvature.is_finite() {
            return Outcome { end: End::NotFinite, ..outcome };
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(diagonal: &[f64], right: &[f64], most: [usize; 2]) -> (Outcome, Vec<f64>) {
        let mut solution = vec![f64::NAN; right.len()];
        let apply = |x: &[f64], y: &mut [f64]| {
            y.iter_mut().zip(x).zip(diagonal).for_each(|((y, x), d)| *y = d * x);
        };
        let precondition = |x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
        let outcome = conjugate_gradients(apply, precondition, right, &mut solution, 1e-12, most);
        (outcome, solution)
    }

    #[test]
    fn as_many_iterations_as_eigenvalues() {
        let (outcome, solution) = solve(&[1.0, 2.0, 4.0, 2.0], &[1.0, 1.0, -1.0, 3.0], [9; 2]);
        assert_eq!((outcome.end, outcome.iterations), (End::Converged, 3));
        let expected = [1.0, 0.5, -0.25, 1.5];
        assert!(solution.iter().zip(expected).all(|(x, e)| (x - e).abs() < 1e-14));
        let (nothing, zero) = solve(&[1.0; 4], &[0.0; 4], [9; 2]);
        assert_eq!((nothing.end, nothing.iterations, zero), (End::Converged, 0, vec![0.0; 4]));
    }

    #[test]
    fn each_failure_has_its_end() {
        let right = [1.0, 1.0, -1.0, 3.0];
        assert_eq!(solve(&[1.0, 2.0, -0.1, 2.0], &right, [9; 2]).0.end, End::NegativeCurvature);
        assert_eq!(solve(&[0.0; 4], &right, [9; 2]).0.end, End::NegativeCurvature);
        assert_eq!(solve(&[1.0, 2.0, 4.0, 2.0], &right, [2; 2]).0.end, End::Exhausted);
        assert_eq!(solve(&[1.0, 2.0, 4.0, 2.0], &right, [1, 9]).0.end, End::Exhausted);
        assert_eq!(solve(&[1.0, f64::NAN, 4.0, 2.0], &right, [9; 2]).0.end, End::NotFinite);
    }
}
